"""How a yard file begins; imports nothing, as each start of a run asks it of its scene."""

from pathlib import Path

HEAD = "heavylift yard"


def is_yard(path: str | Path) -> bool:
    """Return whether a file begins like a yard file."""
    try:
        with open(path, encoding="utf-8") as file:
            lines = (line.strip() for line in file)
            return next((line for line in lines if line and line[0] != "#"), "").startswith(f"{HEAD}:")
    except (OSError, ValueError):
        return False
