"""Who touches at an instant: candidates take slots, and places that have left their face free them.

A candidate whose witness is no more than `TOUCH` at an event touches in that instant; of more than there are slots
for, the fastest come first.  What touches sticks until the solver says more.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import KernelError
from .pairs import HELD
from .slots import LEAVE, Site
from .unilateral import Numbers, Slot

__all__ = ["check_start", "touch"]

TOUCH = 1e-8  # [m] gap of what touches in the same instant
INSIDE = 1e-6  # [m] by which shapes may overlap at the start

Ends = dict[int, Any]  # numbers of the bodies


def check_start(sites: list[Site], numbers: Numbers, ends: Ends) -> None:
    """Raises KernelError if shapes overlap at the start."""
    for s in sites:
        deep = min(gap for gap, _ in s.pair.watch(*_shapes(s, numbers, ends)))
        if deep < -INSIDE:
            raise KernelError(
                f"contact '{s.contact.name}' at 0.000 s: '{s.contact.a.body}' lies {-deep * 1e3:.3g} mm inside "
                f"of '{s.contact.b.body}'; move them apart"
            )


def touch(sites: list[Site], slots: list[Slot], numbers: Numbers, ends: Ends) -> None:
    """Free the slots whose place has left its face; give free ones to what touches, fastest first.  All stick."""
    for s in sites:
        shapes, own = _shapes(s, numbers, ends), [x for x in slots if x.site is s]
        for x in own:
            if x.on and _beyond(s, x.state, ends):
                x.let_go()
        held = numbers("held", s.contact.name)
        nearing = sorted((rate, i) for i, (gap, rate) in enumerate(s.pair.watch(*shapes)) if gap <= TOUCH)
        for _, i in nearing:
            spare = next((x for x in own if not x.on), None)
            if held[i] > 0.0 or spare is None:
                continue
            place = s.pair.hold(i, *shapes)
            if not _beyond(s, np.array(place), ends):
                spare.take(i, place)
    for x in slots:
        if x.on:
            x.grip()


def _shapes(s: Site, numbers: Numbers, ends: Ends) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    p = numbers("shapes", s.contact.name)
    A, B = (np.array(ends[i], float) for i in s.bodies)
    return p[: s.first], p[s.first :], A, B


def _beyond(s: Site, h: np.ndarray, ends: Ends) -> bool:
    """Whether a slot's place lies beyond its face or edges."""
    A, B = (np.array(ends[i], float) for i in s.bodies)
    along = s.pair.frame(h[:HELD], A, B).along
    return bool((np.abs(along) > h[HELD - 2 : HELD] + LEAVE).any())
