"""Whether cranes, hooks and slings may carry what they would, in every static state of the action list.

Load of a hook, a trolley and a crane = what hangs below the hook blocks: block and loaders.  A crane that
lifts together with another may use its tandem share only.  Design factors: breaking force / static
tension.
"""

from __future__ import annotations

from collections.abc import Sequence

from heavylift.nodes.statics.lift import Step

from . import plan, schema
from .findings import Findings, Told
from .yard import HOOKS


def capacity_checks(scene: schema.Scene, built: plan.Plan, steps: Sequence[Step]) -> list[tuple[str, str]]:
    """All that would be overloaded, or that nothing could hold, told once per subject."""
    found = Findings()
    for step in steps:
        for check in (_hooks, _trolleys, _cranes, _slings, _ropes):
            found.take(check.__name__, check(scene, built, step), step.static.stage, step.where)
    return found.list()


def below(scene: schema.Scene, built: plan.Plan, step: Step) -> dict[str, float]:
    """What hangs below the hook block of each rope: the loader and its share of the block [kg]."""
    assert scene.rig is not None
    found = {}
    for rope in built.rig.hook_ropes:
        loader = scene.rig.loaders[rope.carries]
        found[rope.name] = loader.upper_mass + loader.lower_mass + (step.loads or {}).get(rope.carries, 0.0)
    return found


def crane_load(built: plan.Plan, loads: dict[str, float], crane: str, trolley: str = "") -> float:
    """Sum over the hooks of a crane, or of one of its trolleys [kg]."""
    ropes = [r for r in built.rig.hook_ropes if r.crane == crane]
    return sum(loads[r.name] for r in ropes if not trolley or HOOKS[r.hook][0] == trolley)


def sling_tension(built: plan.Plan, step: Step, sling: plan.Sling) -> float:
    """Static tension of a hooked sling: half of its loader's share [N]."""
    pair = [s for s in built.rig.slings if s.loader == sling.loader and s.name in step.state.lugs]
    return (step.loads or {}).get(sling.loader, 0.0) * built.gravity / max(1, len(pair))


def _hooks(scene: schema.Scene, built: plan.Plan, step: Step) -> Told:
    loads = below(scene, built, step)
    for crane in built.cranes:
        for hook in crane.hooks:
            if loads[hook.rope] > hook.capacity * (1 + 1e-9):
                told = _over(f"the hook {hook.rope} would carry", loads[hook.rope], hook.capacity)
                yield hook.rope, step.where or hook.where, told


def _trolleys(scene: schema.Scene, built: plan.Plan, step: Step) -> Told:
    loads = below(scene, built, step)
    for crane in built.cranes:
        for trolley in (crane.upper, crane.lower):
            load = crane_load(built, loads, crane.name, trolley.name)
            if load > trolley.capacity * (1 + 1e-9):
                told = _over(f"the {trolley.name} trolley of {crane.name} would carry", load, trolley.capacity)
                yield f"{crane.name} {trolley.name}", step.where or trolley.where, told


def _cranes(scene: schema.Scene, built: plan.Plan, step: Step) -> Told:
    loads = below(scene, built, step)
    for crane in built.cranes:
        load = crane_load(built, loads, crane.name)
        if load > crane.capacity * (1 + 1e-9):
            given = scene.cranes[crane.name]
            told = _over(f"{crane.name} would carry", load, crane.capacity)
            if crane.capacity < given.capacity:
                told += f", {given.tandem:.0%} of its {given.capacity / 1e3:g} t as two cranes lift together"
            yield crane.name, step.where or crane.where, told


def _slings(scene: schema.Scene, built: plan.Plan, step: Step) -> Told:
    """The design factor of the slings."""
    assert scene.rig is not None
    for sling in built.rig.slings:
        tension = sling_tension(built, step, sling)
        if tension > sling.rated * (1 + 1e-9):
            given = scene.rig.sling
            told = _factor(f"each sling of {sling.loader}", given.breaking, tension, given.factor)
            yield sling.loader, step.where or sling.where, told


def _ropes(scene: schema.Scene, built: plan.Plan, step: Step) -> Told:
    """The design factor of the hook ropes, which carry the hook block besides."""
    loads = below(scene, built, step)
    for rope in built.rig.hook_ropes:
        crane = scene.cranes[rope.crane]
        tension = (loads[rope.name] + crane.hook_block) * built.gravity
        if tension > rope.rated * (1 + 1e-9):
            told = _factor(f"the rope {rope.name}", crane.falls * crane.fall_breaking, tension, crane.rope_factor)
            yield rope.name, step.where or rope.where, told


def _over(what: str, load: float, capacity: float) -> str:
    return f"{what} {load / 1e3:.1f} t of {capacity / 1e3:g} t"


def _factor(what: str, breaking: float, tension: float, factor: float) -> str:
    had = f"{tension / 1e3:.0f} kN are {breaking / tension:.2f} times below its breaking force"
    return f"{what} has too little safety: {had}, {factor:g} are needed"
