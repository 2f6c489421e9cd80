"""The order of names where an order means nothing: that in which people count, "H2" before "H10".

Elements are put into it once, where a description is assembled, so that nothing depends on who wrote what first.
"""

import re
from functools import lru_cache

Key = tuple[tuple[str | tuple[int, str], ...], str]


@lru_cache(maxsize=4096)
def natural(name: str) -> Key:
    """Sort key of a name: its words and its numbers in turn; equal ones, such as "1" and "01", by their letters."""
    parts = re.split(r"([0-9]+)", name)
    numbers = (part.lstrip("0") for part in parts)  # in order of their lengths: no name is too long for that
    return tuple((len(x), x) if i % 2 else parts[i] for i, x in enumerate(numbers)), name
