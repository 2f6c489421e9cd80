"""Tensions in the parts of a reeved rope while its sheaves turn: highest in the part at the drum when hoisting, in the
dead end when lowering.

Each sheave passes on `efficiency` times the tension, so the tensions of the n parts that belong to one drum end form a
geometric series, whose sum is the load. Two drum ends meet at an equaliser and have half of the parts each. Wire Rope
Technical Board, Wire Rope Users Manual, 4th edition, "Wire rope efficiency over sheaves"; ISO 4308-1, efficiency of the
rope reeving.
"""

ROLLING = 0.98  # efficiency of a sheave on rolling bearings


def drum_ends(falls: int, given: int | None = None) -> int:
    """Return the number of rope ends on the drum; by default, two for an even number of falls and one for an odd."""
    return given or (2 if falls % 2 == 0 else 1)


def lead_factor(falls: int, ends: int, efficiency: float) -> float:
    """Return the ratio of the highest rope tension in a reeving to the mean tension of all falls.

    This is n (1 - eta) / (1 - eta^n) with the efficiency eta and n = falls / drum ends. It is the tension at the drum
    when hoisting, and at the dead end (or at the equaliser) when lowering."""
    n = falls // ends
    if efficiency == 1.0:
        return 1.0
    return n * (1.0 - efficiency) / (1.0 - _power(efficiency, n))


def drum_end_factor(falls: int, ends: int, efficiency: float, *, hoisting: bool) -> float:
    """Return the ratio of the rope tension at the drum to the mean tension of all falls.

    The rope at the drum has the highest tension when hoisting and the lowest when lowering."""
    lead = lead_factor(falls, ends, efficiency)
    return lead if hoisting else lead * _power(efficiency, falls // ends - 1)


def _power(x: float, n: int) -> float:
    """Return x to the power n by repeated products, which give the same bits on every processor."""
    found = 1.0
    for _ in range(n):
        found *= x
    return found
