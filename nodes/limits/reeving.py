"""Loads in the parts of a reeved rope while its sheaves turn: highest in the lead part when hoisting, in the dead end
when lowering.

Each sheave passes on `efficiency` times the tension, so the tensions of the n parts of one drum end form a geometric
series, whose sum is the load. Two drum ends meet at an equaliser and have half of the parts each. Wire Rope Technical
Board, Wire Rope Users Manual, 4th edition, "Wire rope efficiency over sheaves"; ISO 4308-1, efficiency of the rope
reeving.
"""

ROLLING = 0.98  # efficiency of a sheave on rolling bearings


def drum_ends(falls: int, given: int | None = None) -> int:
    """Return the number of rope ends on the drum: as given, else two for an even number of falls, else one."""
    return given or (2 if falls % 2 == 0 else 1)


def lead_factor(falls: int, ends: int, efficiency: float) -> float:
    """Return the tension of the lead part of the rope over the mean of all falls: n (1 - eta) / (1 - eta^n), with n =
    falls / drum ends. It is the lead part when hoisting; when lowering, the dead end (or the equaliser's part) has this
    tension."""
    n = falls // ends
    if efficiency == 1.0:
        return 1.0
    return n * (1.0 - efficiency) / (1.0 - _power(efficiency, n))


def drum_end_factor(falls: int, ends: int, efficiency: float, *, hoisting: bool) -> float:
    """Return the tension of the part at the drum over the mean of all falls: the most loaded part when hoisting, the
    least loaded one when lowering."""
    lead = lead_factor(falls, ends, efficiency)
    return lead if hoisting else lead * _power(efficiency, falls // ends - 1)


def _power(x: float, n: int) -> float:
    """Return x to the n by repeated products: the same bits on every processor."""
    found = 1.0
    for _ in range(n):
        found *= x
    return found
