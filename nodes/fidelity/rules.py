"""The pruning rules: each looks at one thing that might be left out and predicts what that costs, by formula.

A rule returns a `Choice`: what to leave out, how many states that saves, the predicted error of each quantity that a
scene can ask, and why.  Whether it is left out is decided in `choose`.  Formulas, with m the load of a hook, d its
static deflection, L its rope, a and v ramp and speed of the winch, w frequencies:

    pick-up      phi - 1 = v / sqrt(g d)              an elastic hook that begins to carry at speed v (C09)
    ramp         phi - 1 = (a / g) (1 + |sin(w t / 2)|)  of a linear oscillator, ramped up in the time t = v / a
    pendulum     dw / w = -dL / 2 L,  m_rope / 12 m    its length, the inertia of its rope (C13b)
    servo        dw / w = m g / (2 L k)               a pendulum that hangs from a spring k
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import pi, sin, sqrt

from heavylift.nodes.scene.plan import Fidelity

from .case import Case, Hook
from .question import Asked

__all__ = ["RULES", "Choice", "Rule"]

Errors = dict[Asked, float]
STATES = 2  # of a degree of freedom: coordinate and velocity


@dataclass(frozen=True)
class Choice:
    """What a rule would leave out: the key of the fidelity that names it, what changes there, joints that are locked,
    states saved, predicted errors, and why; `allowed`: whether the scene permits it at any accuracy."""

    rule: str
    key: str
    change: dict[str, str]
    saved: int
    errors: Errors
    reason: str
    allowed: bool = True
    locked: tuple[str, ...] = ()


Rule = Callable[[Case, Fidelity], Choice]


def rope_mass(case: Case, at: Fidelity) -> Choice:
    """Ropes without mass: their inertia adds a third of it to the load, axially, and m_r / 12 m to a pendulum's."""
    ratio = max(h.rope_mass / h.load for h in case.hooks)
    dynamic = max(_pick_up(case, h, girder=True) + _ramped(case, h, True) for h in case.hooks)
    droop = max(h.rope_mass / 2.0 * case.gravity * h.soft_rope / max(h.picks, 1e-9) for h in case.hooks)
    errors: Errors = {
        "rope tension": dynamic * ratio / 2.0,
        "swing": _swing(case, ratio / 12.0),
        "position": ratio / 12.0,
        "lift-off time": droop / case.stage,
    }
    lumps = at.lumps * len(case.hooks)
    return Choice(
        "massless ropes", "ropes", {"ropes": "elastic"}, STATES * 4 * lumps, errors,
        f"a rope weighs {ratio:.2%} of its load",
    )  # fmt: skip


def girder(case: Case, at: Fidelity) -> Choice:
    """A girder that does not bend: without its deflection, the load is picked up faster and swings up quicker."""
    gone = max(abs(_dynamic(case, h, True) - _dynamic(case, h, False)) for h in case.hooks)
    pick = max(_pick_up(case, h, girder=False) for h in case.hooks)
    sag = max(h.load * case.gravity * h.soft_girder for h in case.hooks)
    late = max(h.load * case.gravity * h.soft_girder / max(h.picks, 1e-9) for h in case.hooks)
    errors: Errors = {
        "rope tension": max(gone, pick),
        "swing": 0.0,
        "position": 0.0,
        "lift-off time": late / case.stage,
    }
    return Choice(
        "rigid girder", "girder", {"girder": "rigid"}, STATES * len({h.rope.split(".")[0] for h in case.hooks}),
        errors, f"the load bends it by {sag * 1e3:.0f} mm",
    )  # fmt: skip


def rope_elasticity(case: Case, at: Fidelity) -> Choice:
    """Ropes that do not stretch: no dynamic factor at all, and the load is lifted at once."""
    dynamic = max(_dynamic(case, h, girder=False) for h in case.hooks)
    stretch = max(h.stretch(case.gravity, girder=False) / h.length for h in case.hooks)
    late = max(h.stretch(case.gravity) / max(h.picks, 1e-9) for h in case.hooks)
    errors: Errors = {
        "rope tension": dynamic,
        "swing": _swing(case, stretch / 2.0),
        "position": stretch,
        "lift-off time": late / case.stage,
    }
    many = "" if case.determinate else "; but more than three hooks share the load by their stiffness"
    return Choice(
        "rigid ropes", "ropes", {"ropes": "rigid", "slings": "rigid"}, 0, errors,
        f"they stretch by {stretch:.2%}{many}", case.determinate,
    )  # fmt: skip


def plane(case: Case, at: Fidelity) -> Choice:
    """Motion in a plane: exact for a lift that is its own mirror image, wrong for any other."""
    states = STATES * (3 * (len(case.hinges) + 1) + len(case.hinges) + 1)
    why = "the lift is its own mirror image" if case.mirrored else "the lift has no plane of symmetry"
    return Choice("planar motion", "motion", {"motion": "across"}, states, {}, why, case.mirrored)


def hinges(case: Case, at: Fidelity) -> Choice:
    """Beams of loaders that do not turn on their hinges: slings of equal length share the load all the same."""
    states = STATES * len(case.hinges)
    return Choice("locked hinges", "locked", {}, states, {}, "no order turns a beam", bool(case.hinges), case.hinges)


def idle_drives(case: Case, at: Fidelity) -> Choice:
    """Gantries and trolleys that no order moves stand still; their servos give way a little."""
    idle = tuple(joint for joint in case.drives if joint not in case.ordered)
    gives = max((m * case.gravity / case.longest / k for k, m in (case.drives[j] for j in idle)), default=0.0)
    errors: Errors = {"swing": _swing(case, gives / 2.0), "position": gives}
    return Choice("locked drives", "locked", {}, STATES * len(idle), errors, "no order moves them", bool(idle), idle)


RULES: tuple[Rule, ...] = (rope_mass, girder, plane, idle_drives, hinges, rope_elasticity)


def _dynamic(case: Case, h: Hook, girder: bool) -> float:
    """phi - 1 of picking up or ramping, whichever is more."""
    return max(_pick_up(case, h, girder), _ramped(case, h, girder))


def _pick_up(case: Case, h: Hook, girder: bool) -> float:
    return h.picks / sqrt(case.gravity * max(h.stretch(case.gravity, girder), 1e-12))


def _ramped(case: Case, h: Hook, girder: bool) -> float:
    omega = sqrt(case.gravity / max(h.stretch(case.gravity, girder), 1e-12))
    time = h.hoists / h.ramp if h.ramp else 0.0
    return h.ramp / case.gravity * (1.0 + abs(sin(min(omega * time, pi) / 2.0)))


def _swing(case: Case, shift: float) -> float:
    """Error of the envelope after a move from that of the frequency: phase times shift, at least the shift."""
    phases: Iterable[float] = (case.omega * (s.ramping + s.cruising) / 2.0 for s in case.swings)
    return abs(shift) * max([1.0, *phases])
