"""The pruning rules: each looks at one thing that might be left out and predicts what that costs, by formula.

A rule returns a `Choice`: what to leave out, how many states that saves, the predicted error of each quantity that a
scene can ask, and why.  Whether it is left out is decided in `choose`.  Where the formulas come from and how they are
tested: FIDELITY.md; the answer to the action list stands in `response`, those of shares in `hooks`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt

from heavylift.nodes.plan.plan import Fidelity

from .case import Case
from .chance import AWAITED, PULLED, ROCKS, TWO, WITHOUT, Errors, between, overshoot, swung, tipped
from .hooks import Hook, coupling, leaning, redistribution

COUPLED = 1.4  # of a coupling from straight pendulums of the longest ropes
ONE_BY_ONE = 2.0  # of a load that comes aside as its corners part one after the other
VIBRATES = 0.003  # part of a rope's mass that moves as only four lumps show
PULLED_ALONG = 14.0  # of what a servo gives to a load that is let go aside: it was pulled by it, and damps the swing
TILTS = 1.5  # of what such a servo would give if the block went aside as far as its hooks go up and down, measured
TUGS, PARTS_SOONER = 10.0, 5.0  # of the stretch by which such a servo hoists a load that it lets nearer, measured
SWAYED = 1.6  # of girders whose trolleys sway on their servos
BOTH_WAYS = 2.0  # there and back
LEANING = 2.0  # heights of a block on more than three hooks, which the girders lift by one corner after the other
OPPOSED = 2.0  # two swings of one size: a block that leans as it is lifted swings before it is moved
SOONER = 1.05  # by what the block does not hang straight
STATES = 2  # of a degree of freedom: coordinate and velocity


@dataclass(frozen=True)
class Choice:
    """What a rule would leave out: the key of the fidelity that names it, what changes there, joints that are locked,
    states saved, predicted errors, and why; `allowed`: whether the scene permits it at any accuracy."""

    rule: str
    key: str
    change: dict[str, str | int]
    saved: int
    errors: Errors
    reason: str
    allowed: bool = True
    locked: tuple[str, ...] = ()


Rule = Callable[[Case, Fidelity], Choice]


def lumps(case: Case, at: Fidelity) -> Choice:
    """Two lumps a rope, which have its mass and its inertia already: what is lost is how the rope itself vibrates."""
    heavy = max(h.rope_mass / h.load for h in case.hooks)
    sways = heavy * VIBRATES
    errors = between(case, TWO)
    errors["swing"] = max(sways, errors["swing"])
    errors["position"] = max(2.0 * sways * case.swings.most / case.way, errors["position"])
    dynamic = max(overshoot(case, h, girder=True) for h in case.hooks)
    errors["rope tension"] = _peak(case, dynamic * heavy / 8.0, errors["rope tension"])
    errors["lift-off time"] += _wave(case) / 20.0
    degrees = 4 if at.motion == "spatial" else 2
    saved = STATES * degrees * max(0, at.lumps - 2) * len(case.hooks)
    allowed = at.ropes == "massive" and at.lumps > 2
    why = f"more than two show how a rope vibrates that weighs {heavy:.2%} of its load"
    return Choice("two lumps", "lumps", {"lumps": 2}, saved, errors, why, allowed)


def rope_mass(case: Case, at: Fidelity) -> Choice:
    """The mass of ropes lumped onto hooks and trolleys: statics, the frequency of the swing and that of the load up and
    down stay; lost is the sixth of it that couples both ends, so that a trolley shakes its load by so much less, the
    time of a wave to the hook, and how the waves of several ropes share a load that more than three carry."""
    heavy = max(h.rope_mass / h.load for h in case.hooks)
    parts_aside = case.swings.jumps > 0.0 and not case.determinate
    coupled = COUPLED * coupling(case.hooks) * (ONE_BY_ONE if parts_aside else 1.0)
    dynamic = max(overshoot(case, h, girder=True) for h in case.hooks)
    errors = between(case, WITHOUT)
    errors["swing"] += coupled
    errors["position"] += coupled * case.swings.most / case.way
    waves = dynamic * heavy / (2.0 if case.determinate else 1.0)
    errors["rope tension"] = _peak(case, waves, errors["rope tension"] + tipped(case, coupled))
    errors["lift-off time"] += 0.8 * _wave(case)
    chains = at.lumps * len(case.hooks)
    degrees = 4 if at.motion == "spatial" else 2
    pulled = case.swings.jumps > 0.0 and any(2.0 * h.rope_mass > PULLED * (h.load - h.share) for h in case.hooks)
    why = f"a rope weighs {heavy:.2%} of its load"
    why += "; but that is a quarter of what its hook does, which a load that comes aside pulls along" if pulled else ""
    saved = STATES * degrees * chains
    return Choice("lumped ropes", "ropes", {"ropes": "elastic"}, saved, errors, why, not pulled)


def girder(case: Case, at: Fidelity) -> Choice:
    """A girder that does not bend: the block is picked up faster, hangs higher, and no slope moves it aside; more
    hooks than three share it otherwise."""
    g = case.gravity
    steady = min(h.ramp for h in case.hooks) / g  # any hook goes at least this far beyond its static load
    dynamic = max(overshoot(case, h, bends) for h in case.hooks for bends in (True, False)) - steady
    spread = 0.0 if case.determinate else redistribution(case.hooks)
    sag = max(h.sag(g) for h in case.hooks)
    aside = max(2.0 * h.sag(g) * h.aside + h.slides + h.tilts * h.traverses for h in case.hooks)
    known = case.awaited and case.determinate  # then the girder has bent before anything hangs
    hangs = sag if case.determinate else LEANING * sag
    high = _bounce(case, girder=True) + _bounce(case, girder=False) + _halting(case) if known else hangs
    errors = swung(case, max(h.sag(g) / h.reach for h in case.hooks) / 2.0)
    errors["swing"] += aside / case.swings.least + max(h.tilts for h in case.hooks)
    errors["swing"] *= SWAYED
    errors["swing"] += OPPOSED * leaning(case.hooks, g) / case.swings.least
    landing = BOTH_WAYS * case.awaits if case.awaits > AWAITED else 0.0  # in whatever phase of the swing
    errors["swing"] += landing / case.swings.least
    errors["position"] = (high + landing + BOTH_WAYS * (errors["position"] * case.way + aside)) / case.way
    errors["rope tension"] = _peak(case, dynamic, tipped(case, errors["swing"])) + spread
    errors["lift-off time"] = max(min(1.0, _sooner(case, h)) for h in case.hooks)
    shared = f", which shifts {spread:.1%} of a hook's load" if spread else ""
    uneven = "" if case.even else "; but hooks that lift at different speeds tilt the block until it is taken up"
    changes = "; but hooks change as it hangs" if case.changes else ""
    changes = "; but it jumps aside as it parts" if case.swings.jumps else changes
    return Choice(
        "rigid girder", "girder", {"girder": "rigid"}, girder_states(case), errors,
        f"the block bends it by {sag * 1e3:.0f} mm{shared}{uneven}{changes}", case.even and not changes,
    )  # fmt: skip


def girder_states(case: Case) -> int:
    """One mode of each crane that lifts."""
    return STATES * len({h.crane for h in case.hooks})


def rope_elasticity(case: Case, at: Fidelity) -> Choice:
    """Ropes that do not stretch, for a scene that names them: which of them pull is decided by less than any model
    knows (1054 and 1016 kN on two alike that truly carry 734), and steps are no cheaper."""
    stretch = max(h.stretch(case.gravity, girder=False) for h in case.hooks)
    why = f"the block stretches them by {stretch * 1e3:.0f} mm; but ropes that do not stretch share no load as ropes do"
    return Choice("rigid ropes", "ropes", {"ropes": "rigid", "slings": "rigid"}, 0, {}, why, allowed=False)


def plane(case: Case, at: Fidelity) -> Choice:
    """Motion in a plane: exact for a lift that is its own mirror image, wrong for any other."""
    states = STATES * (3 * (len(case.hinges) + 1) + len(case.hinges) + 1)
    why = "the lift is its own mirror image" if case.mirrored else "the lift has no plane of symmetry"
    return Choice("planar motion", "motion", {"motion": "across"}, states, {}, why, case.mirrored)


def hinges(case: Case, at: Fidelity) -> Choice:
    """Beams of loaders that do not turn on their hinges: exact in a mirrored lift, where nothing turns them; in any
    other slings of one beam stretch differently instead, and what little the load swings is half wrong."""
    allowed, why = bool(case.hinges) and not case.turns, "nothing turns a beam"
    if not case.mirrored:
        allowed, why = False, "slings that stretch differently turn the beams"
    if case.swings.along(0):
        allowed, why = False, "what moves the load along the rails turns the beams"
    return Choice("locked hinges", "locked", {}, STATES * len(case.hinges), Errors(), why, allowed, case.hinges)


def idle_drives(case: Case, at: Fidelity) -> Choice:
    """Gantries and trolleys that no order moves stand still; their servos give way to what swings towards them: all of
    the swing, or, of a gantry in a move across, what a lift that is not mirrored leans.  A load that is let go aside of
    its hooks has pulled them along before it parts, and then swings less."""
    idle = tuple(joint for joint in case.drives if joint not in case.ordered)
    swings = case.swings.along(0)
    pulled = [j for j in idle if not j.endswith(".gantry") or swings]
    gives = max((m * case.gravity / case.reach / k for k, m in (case.drives[j] for j in pulled)), default=0.0)
    errors = swung(case, gives / 2.0) if gives else Errors()
    if gives and case.tilted:  # its ropes lean, and not alike
        errors["swing"] += TILTS * gives * case.tilted / case.swings.least
        errors["position"] += TILTS * gives * case.tilted / case.way
    if gives and case.swings.jumps:
        along = PULLED_ALONG * gives * case.swings.jumps
        errors["swing"] += along / max(case.swings.least, case.swings.jumps)
        errors["position"] += along / case.way
        inclined = gives * case.swings.jumps * case.swings.jumps / case.reach  # which hoists it by as much
        hoisted = inclined / min(h.stretch(case.gravity, girder=True) for h in case.hooks)
        errors["rope tension"] += TUGS * hoisted
        errors["lift-off time"] += PARTS_SOONER * hoisted
    if gives and case.swings.lands:  # where it stands again is decided by the phase in which it rocks then
        late = gives / 2.0 * case.swings.omegas[1] * case.lasts
        errors["position"] = errors.get("position", 0.0) + ROCKS * min(1.0, late) / case.way
    return Choice("locked drives", "locked", {}, STATES * len(idle), errors, "no order moves them", bool(idle), idle)


def pads(case: Case, at: Fidelity) -> Choice:
    """Pads of faces that the block does not stand on: without a turn they never meet a stool."""
    why = "a turn lands on another face" if case.turns else "no turn brings another face to the stools"
    return Choice("standing pads", "pads", {"pads": "standing"}, 0, {}, why, not case.turns)


RULES: tuple[Rule, ...] = (pads, lumps, rope_mass, girder, plane, idle_drives, hinges, rope_elasticity)


def _wave(case: Case) -> float:
    """Time of a wave along a rope, relative to the stage that lifts."""
    stage = min(h.stretch(case.gravity, girder=True) / h.picks for h in case.hooks)
    return max(sqrt(h.rope_mass * h.soft_rope) for h in case.hooks) / stage


def _bounce(case: Case, girder: bool) -> float:
    """How far the block goes up and down once it has parted from its stools [m]."""
    rings = max(h.rings * h.load * case.gravity * h.soft(girder) for h in case.hooks)
    return max(2.0 * h.picks / h.omega(girder) for h in case.hooks) + rings


def _halting(case: Case) -> float:
    """What a winch that halts goes on winding [m]."""
    return max(h.picks * h.picks / h.ramp / 2.0 if h.ramp else 0.0 for h in case.hooks)


def _sooner(case: Case, h: Hook) -> float:
    """Part of the stage that lifts which a stiff girder saves; winches that halt when all is taut have then taken up
    some of the stretch."""
    stretch = h.stretch(case.gravity, girder=True)
    return SOONER * h.sag(case.gravity) / max(stretch - _halting(case), 1e-3 * stretch)


def _peak(case: Case, bounce: float, swings: float) -> float:
    """Error of the largest tension, which comes as the load bounces or as it swings; both at once where nothing damps
    the bounce, or where it comes aside as it parts."""
    return max(bounce, swings) if case.damped and not case.swings.jumps else bounce + swings
