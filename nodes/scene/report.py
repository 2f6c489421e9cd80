"""What `heavylift check SCENE` prints: the size of a scene and the static loads of each stage.

Shares are those of the plumb equilibrium; "on the rope" counts the hook block, "below the hook" does not.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING

from . import plan, schema
from .capacity import below, crane_load, sling_tension
from .follow import Following, Step

if TYPE_CHECKING:
    from heavylift.kernel.analysis.mobility import Mobility


@dataclass(frozen=True)
class Row:
    """The load of one hook in one stage [kg], and what of its capacity it uses."""

    stage: str
    hook: str
    sling_load: float
    below_hook: float
    on_rope: float
    use: float


@dataclass(frozen=True)
class Report:
    """The size of a scene and its static loads; `str` is the printed page."""

    name: str
    bodies: int
    dof: int
    ropes: int
    slings: int
    models: int
    actions: int
    mobility: Mobility
    rows: tuple[Row, ...]
    lines: tuple[str, ...]

    def __str__(self) -> str:
        return "\n".join(self.lines)


def report(scene: schema.Scene, built: plan.Plan, followed: Following | None, pruning: str = "") -> Report:
    """The report of a scene whose action list was followed; `pruning`: what of it is modelled."""
    mobility = _mobility(built)
    ropes = len(built.rig.hook_ropes) + sum(len(m.system.ropes) + len(m.system.reevings) for m in built.mechanisms)
    slings, actions = len(built.rig.slings), len(built.actions)
    models = len(built.cranes) + len(built.loaders) + (built.block is not None) + len(built.mechanisms) + 1
    counts = (mobility.bodies, mobility.dof, ropes, slings, models, actions)
    words = ("bodies", "degrees of freedom", "ropes", "slings", "models", "actions")
    lines = [f"{built.name}: " + ", ".join(f"{n} {_many(n, word)}" for n, word in zip(counts, words, strict=True))]
    lines += [f"  {line}" for line in mobility.lines]
    rows: list[Row] = []
    if followed:
        rows = _rows(scene, built, followed)
        lines += _page(scene, built, followed, rows)
    lines += ["", pruning] if pruning else []
    return Report(built.name, *counts, mobility=mobility, rows=tuple(rows), lines=tuple(lines))


def _mobility(built: plan.Plan) -> Mobility:
    """Bodies and degrees of freedom of what is simulated, as the kernel counts them."""
    from heavylift.kernel.analysis.mobility import mobility  # needs NumPy, which declaring a scene does not
    from heavylift.kernel.rate import Program
    from heavylift.nodes.models import system

    return mobility(Program(system(built)))


def _many(n: int, word: str) -> str:
    one = {"bodies": "body", "degrees of freedom": "degree of freedom"}
    return word if n != 1 else one.get(word, word[:-1])


def _rows(scene: schema.Scene, built: plan.Plan, followed: Following) -> list[Row]:
    found = []
    for step in followed.steps:
        if step.loads is None:
            continue
        loads = below(scene, built, step)
        for crane in built.cranes:
            for hook in crane.hooks:
                rope = next(r for r in built.rig.hook_ropes if r.name == hook.rope)
                load, lower = step.loads.get(rope.carries, 0.0), loads[rope.name]
                used = lower / hook.capacity
                found.append(Row(step.stage, hook.rope, load, lower, lower + hook.block_mass, used))
    return found


def _page(scene: schema.Scene, built: plan.Plan, followed: Following, rows: list[Row]) -> list[str]:
    hooks = list(dict.fromkeys(row.hook for row in rows))
    if not hooks:
        return ["", "Nothing is lifted as far as the action list can be followed without its dynamics."]
    lines = ["", _line("static sling load [t]", hooks)]
    shown: list[str] = []
    for stage, group in groupby(rows, key=lambda row: row.stage):
        cells = [f"{row.sling_load / 1e3:.1f}" for row in group]
        if cells != shown and stage in followed.told_stages:
            lines.append(_line(stage, cells))
            shown = cells
    largest = {hook: max((r for r in rows if r.hook == hook), key=lambda r: r.on_rope) for hook in hooks}
    lines += [
        "",
        _line("largest load of the rope [t]", [f"{largest[h].on_rope / 1e3:.1f}" for h in hooks]),
        _line("without the hook block [t]", [f"{largest[h].below_hook / 1e3:.1f}" for h in hooks]),
        _line("use of the hook's capacity", [f"{largest[h].use:.0%}" for h in hooks]),
        "",
        *_uses(scene, built, [step for step in followed.steps if step.loads is not None]),
    ]
    if not followed.known:
        lines += ["", f"Followed up to {followed.steps[-1].stage}; what comes later depends on the motion."]
    return lines


def _line(label: str, cells: list[str]) -> str:
    return f"  {label:<28}" + "".join(f" {cell:>{max(9, len(cell))}}" for cell in cells)


def _uses(scene: schema.Scene, built: plan.Plan, steps: list[Step]) -> list[str]:
    """The largest use of each crane, and the smallest factors of ropes and slings."""
    lines = []
    for crane in built.cranes:
        load = max(crane_load(built, below(scene, built, step), crane.name) for step in steps)
        use = f"{load / crane.capacity:.0%}"
        lines.append(f"  {crane.name:<28} at most {load / 1e3:.1f} t of {crane.capacity / 1e3:g} t ({use})")
    assert scene.rig is not None
    rope_factors, sling_factors = [], []
    for step in steps:
        loads = below(scene, built, step)
        for rope in built.rig.hook_ropes:
            given = scene.cranes[rope.crane]
            tension = (loads[rope.name] + given.hook_block) * built.gravity
            rope_factors.append((given.falls * given.fall_breaking / tension, rope.name, given.rope_factor))
        for sling in built.rig.slings:
            tension = sling_tension(built, step, sling)
            if tension > 0:
                breaking = scene.rig.sling.breaking
                sling_factors.append((breaking / tension, sling.name, scene.rig.sling.factor))
    for what, factors in (("hook ropes", rope_factors), ("slings", sling_factors)):
        if factors:
            factor, name, needed = min(factors)
            lines.append(f"  {what:<28} safety factor at least {factor:.1f} ({name}), {needed:g} needed")
    return lines
