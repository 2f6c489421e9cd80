"""What the parts of a reeved rope carry while its sheaves turn: most the lead part in hoisting, the dead end in
lowering.

Each sheave passes on `efficiency` times the tension, so that n parts behind one drum end carry a geometric series;
their sum is the load.  Two drum ends meet at an equaliser and carry half of the parts each.  Wire Rope Technical Board,
Wire Rope Users Manual, 4th edition, "Wire rope efficiency over sheaves"; ISO 4308-1, efficiency of the rope reeving.
"""

from __future__ import annotations

ROLLING = 0.98  # efficiency of a sheave on rolling bearings


def drum_ends(falls: int, given: int | None = None) -> int:
    """Rope ends on the drum: as given, or two for an even number of falls."""
    return given or (2 if falls % 2 == 0 else 1)


def lead_factor(falls: int, ends: int, efficiency: float) -> float:
    """Tension of the lead part over the mean: n (1 - eta) / (1 - eta^n), n = falls / ends parts per drum end.

    That is the lead part when hoisting, and the dead end (or the equaliser's part) when lowering.
    """
    n = falls // ends
    if efficiency == 1.0:
        return 1.0
    return n * (1.0 - efficiency) / (1.0 - _power(efficiency, n))


def drum_end_factor(falls: int, ends: int, efficiency: float, *, hoisting: bool) -> float:
    """Part at the drum over the mean one: the most loaded when hoisting, the least loaded when lowering."""
    lead = lead_factor(falls, ends, efficiency)
    return lead if hoisting else lead * _power(efficiency, falls // ends - 1)


def _power(x: float, n: int) -> float:
    """x to the n by repeated products: the same bits on every processor."""
    found = 1.0
    for _ in range(n):
        found *= x
    return found
