"""Who touches at an instant: candidates take slots, and places that have left their face free them.

A candidate whose witness is no more than `TOUCH` at an event touches in that instant; of more than there are slots
for, the fastest come first.  What touches sticks until the solver says more.
"""

from __future__ import annotations

import numpy as np
from heavylift.kernel.algebra.spatial import exact
from heavylift.kernel.compiler.symbol import Array
from heavylift.kernel.constraints.contact.contact_points import LEAVE, RESTING, Site
from heavylift.kernel.constraints.contact.frames import ContactFrame
from heavylift.kernel.constraints.contact.pairs import HELD
from heavylift.kernel.errors import KernelError

from .unilateral import Numbers, Slot

TOUCH = 1e-8  # [m] gap of what touches in the same instant
SAME = 1e-7  # [m] and [rad] between candidates that are one place
INSIDE = 1e-6  # [m] by which shapes may overlap at the start

Ends = dict[int, Array]  # numbers of the bodies


def check_start(sites: list[Site], numbers: Numbers, ends: Ends) -> None:
    """Raises KernelError if shapes overlap at the start."""
    for s in sites:
        deep = min(gap for gap, _ in s.pair.watch(*_shapes(s, numbers, ends)))
        if deep < -INSIDE:
            raise KernelError(
                f"contact '{s.contact.name}' at 0.000 s: '{s.contact.a.body}' lies {-deep * 1e3:.3g} mm inside "
                f"of '{s.contact.b.body}'; move them apart"
            )


def touch(sites: list[Site], slots: list[Slot], numbers: Numbers, ends: Ends, fell: set[int]) -> None:
    """Free the slots whose place has left its face; give free ones to what touches, fastest first.  All stick.

    `fell`: candidates, counted through all sites, whose guards say that they touch.  At the end of an edge they may
    say so by round-off that is another one here.
    """
    first = 0
    for s in sites:
        shapes, own = _shapes(s, numbers, ends), [x for x in slots if x.site is s]
        places: list[tuple[ContactFrame, Slot]] = []
        for x in own:
            if x.on and _within(f := _frame(s, x.state, ends), x.state):
                places.append((f, x))
            elif x.on:
                x.let_go()
        held = numbers("held", s.contact.name)
        found = enumerate(s.pair.watch(*shapes))
        nearing = sorted((rate, i) for i, (gap, rate) in found if gap <= TOUCH or first + i in fell)
        first += s.pair.candidates
        for rate, i in nearing:
            h = [float(x) for x in s.pair.hold(i, *shapes)]
            f = _frame(s, np.array(h), ends)
            if held[i] > 0.0 or not _within(f, np.array(h)) or not _adds(f, places):
                continue
            spare = next((x for x in own if not x.on), None)
            if spare is None and rate < -RESTING and (spare := _second(places)):
                spare.let_go()
                places = [(g, x) for g, x in places if x is not spare]
            if spare:
                spare.take(i, h)
                places.append((f, spare))
    for x in slots:
        if x.on:
            x.grip()


def _shapes(s: Site, numbers: Numbers, ends: Ends) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    p = numbers("shapes", s.contact.name)
    A, B = (exact(ends[i]) for i in s.bodies)
    return exact(p[: s.first]), exact(p[s.first :]), A, B


def _frame(s: Site, h: np.ndarray, ends: Ends) -> ContactFrame:
    A, B = (exact(ends[i]) for i in s.bodies)
    return s.pair.frame(exact(h[:HELD]), A, B)


def _within(f: ContactFrame, h: np.ndarray) -> bool:
    """Whether a slot's place lies on its face or edges."""
    return bool((np.abs(f.along) <= h[HELD - 2 : HELD] + LEAVE).all())


def _adds(f: ContactFrame, places: list[tuple[ContactFrame, Slot]]) -> bool:
    """Whether a candidate holds what others do not hold: where a corner meets an edge, many candidates are one place,
    and two directions hold it."""
    here = [g for g, _ in places if _near(f, g)]
    return len(here) < 2 and all(np.abs(f.F[0] - g.F[0]).max() > SAME for g in here)


def _second(places: list[tuple[ContactFrame, Slot]]) -> Slot | None:
    """The slot of a second direction at some place, which what approaches elsewhere needs more."""
    found = (x for k, (f, x) in enumerate(places) if any(_near(f, g) for g, _ in places[:k]))
    return next(found, None)


def _near(f: ContactFrame, g: ContactFrame) -> bool:
    return bool(np.abs(f.x - g.x).max() < SAME)
