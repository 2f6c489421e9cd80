"""What the fidelity of a scene leaves out, and the error that the rules predict for it; in the summary of every run."""

from __future__ import annotations

from dataclasses import dataclass

from heavylift.nodes.plan.fidelity import Asked
from heavylift.nodes.plan.plan import Fidelity, Plan

from .case import case_of
from .chance import Errors
from .following import Following
from .lifts import lift_of
from .rules import girder, hinges, idle_drives, lumps, rope_mass
from .verdict import EXACT, percent, unruled

SPARE = 2.0  # on the rule of ropes with lumped mass, for ropes without any: their load moves a third of it less
SUMMARISED: Asked = "rope tension"  # the quantity that every summary shows


@dataclass(frozen=True)
class Modelled:
    """What a rung leaves out, in words, and the predicted errors; none where `unknown` says why."""

    left_out: tuple[str, ...]
    errors: Errors
    unknown: str = ""

    def __str__(self) -> str:
        out = ", ".join(self.left_out) or "nothing left out"
        if self.unknown:
            return f"{out}; error not predicted: {self.unknown}"
        return f"{SUMMARISED} within {percent_up(self.errors[SUMMARISED])}: {out}"


def modelled_as(plan: Plan, followed: Following | None) -> Modelled:
    """The rung of a plan; `followed`: its action list, None for a mechanism."""
    at, out = plan.fidelity, _left_out(plan.fidelity)
    if lift_of(plan).block is None or followed is None:
        return Modelled((), {}, "a mechanism is modelled as it is written, no rule looks at it")
    if why := unruled(plan):
        return Modelled(out, {}, why)
    case = case_of(plan, followed)
    if case is None:
        return Modelled(out, {}, "no block is lifted as far as the action list can be followed before the run")
    rules = []
    if at.girder == "rigid":
        rules.append(girder(case, at).errors)
    if at.ropes == "massive" and at.lumps < Fidelity().lumps:
        rules.append(lumps(case, at).errors)
    if at.ropes != "massive":
        spare = SPARE if at.rope_mass == "none" else 1.0
        rules.append({q: spare * e for q, e in rope_mass(case, at).errors.items()})
    if at.ropes == "rigid":
        return Modelled(out, {}, "no rule predicts how rigid ropes share a load")
    if at.slings == "rigid":
        return Modelled(out, {}, "no rule looks at rigid slings on elastic ropes")
    if at.motion != "spatial" and not (at.motion == "across" and case.mirrored):
        return Modelled(out, {}, "the lift is no plane one")
    for rule in (hinges, idle_drives):
        choice = rule(case, at)
        if any(joint in at.locked for joint in choice.locked):
            if not choice.allowed:
                return Modelled(out, {}, f"{choice.rule}: {choice.reason}")
            rules.append(choice.errors)
    return Modelled(out, {SUMMARISED: EXACT + sum(errors.get(SUMMARISED, 0.0) for errors in rules)})


def _left_out(at: Fidelity) -> tuple[str, ...]:
    """What a rung leaves out, in words."""
    words = [
        ("girder rigid", at.girder == "rigid"),
        ("ropes rigid", at.ropes == "rigid"),
        ("slings rigid", at.slings == "rigid"),
        ("ropes without mass", at.ropes != "massive" and at.rope_mass == "none"),
        ("rope mass lumped at the ends", at.ropes != "massive" and at.rope_mass == "lumped"),
        (f"each rope of {at.lumps} lumps", at.ropes == "massive"),
        (f"motion {at.motion} the rails alone", at.motion != "spatial"),
        (f"{len(at.locked)} joint{'s' * (len(at.locked) > 1)} locked", bool(at.locked)),
    ]
    return tuple(word for word, out in words if out)


def percent_up(error: float) -> str:
    """A bound in percent, rounded up to two digits."""
    from math import ceil, floor, log10

    if error <= 0.0:
        return percent(error)
    unit = 10.0 ** (floor(log10(100.0 * error)) - 1)
    return f"{ceil(100.0 * error / unit - 1e-9) * unit:.10g} %"
