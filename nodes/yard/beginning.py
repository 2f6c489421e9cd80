"""How a yard file is recognised, and where the bundled yards are; imports nothing heavy, since every start of a run
needs it."""

from pathlib import Path

HEAD = "heavylift yard"


def is_yard(path: str | Path) -> bool:
    """Return whether a file begins like a yard file; `path`: its path, or the name of a bundled yard."""
    try:
        with open(yard_path(path), encoding="utf-8") as file:
            lines = (line.strip() for line in file)
            return next((line for line in lines if line and line[0] != "#"), "").startswith(f"{HEAD}:")
    except (OSError, ValueError):
        return False


def yard_path(name: str | Path) -> Path:
    """Return the file of a yard: the path itself, or the file of the bundled yard with this name."""
    bundled = Path(__file__).parent / "yards" / f"{name}.yaml"
    return bundled if not Path(name).exists() and str(name).isidentifier() and bundled.is_file() else Path(name)
