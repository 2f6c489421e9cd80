"""What `heavylift check SCENE` prints: the size of a scene and the static loads of each stage.

Loads are those of the equilibrium path; "on the rope" counts the hook block, "below the hook" does not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from math import degrees
from typing import TYPE_CHECKING

from heavylift.nodes.limits.sharing import dynamics_foreseen, hoisting_foreseen, shared
from heavylift.nodes.limits.telling import HEAD, likewise, unjudged
from heavylift.nodes.limits.telling import rows as rows_of
from heavylift.nodes.models.machine import turning
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.actions import Move
from heavylift.nodes.plan.limit import Finding, Use
from heavylift.nodes.plan.pulses import ramp, times
from heavylift.nodes.statics import Followed, Following

COLUMNS = 6  # of a table of ropes

if TYPE_CHECKING:
    from heavylift.kernel.model.reactions.mobility import Mobility


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
    uses: tuple[Use, ...] = ()  # of each limit, the worst on the path at rest
    findings: tuple[Finding, ...] = ()  # what is beyond a limit there, or should be reported

    def __str__(self) -> str:
        return "\n".join(self.lines)


def report(
    built: plan.Plan,
    statics: Followed,
    followed: Following | None,
    uses: Sequence[Use],
    findings: Sequence[Finding],
) -> Report:
    """The report of a scene whose action list was followed."""
    mobility = _mobility(built)
    ropes = len(built.rig.hook_ropes) + sum(len(m.system.ropes) + len(m.system.reevings) for m in built.mechanisms)
    rigged = {sling for m in built.mechanisms for slings in m.rigged.values() for sling in slings}
    hung = [rope for m in built.mechanisms for rope in m.system.all_ropes if rope.hooked and rope.name in rigged]
    ropes, slings, actions = ropes - len(rigged), len(built.rig.slings) + len(hung), len(built.actions)
    models = len(built.cranes) + len(built.loaders) + (built.block is not None) + len(built.mechanisms)
    models += len(built.models) + 1
    counts = (mobility.bodies, mobility.dof, ropes, slings, models, actions)
    words = ("bodies", "degrees of freedom", "ropes", "slings", "models", "actions")
    lines = [f"{built.name}: " + ", ".join(f"{n} {_many(n, word)}" for n, word in zip(counts, words, strict=True))]
    lines += [f"  {line}" for line in mobility.lines]
    rows: list[Row] = []
    if followed:
        rows = _rows(built, followed)
        lines += _page(followed, rows) + _limits(built, uses, findings)
    else:
        lines += _ropes_at_rest(statics) + (_limits(built, uses, findings) if uses else _lines(findings))
    lines += _swing_free(built)
    return Report(built.name, *counts, mobility, tuple(rows), tuple(lines), tuple(uses), tuple(findings))


def _mobility(built: plan.Plan) -> Mobility:
    """Bodies and degrees of freedom of what is simulated, as the kernel counts them."""
    from heavylift.kernel.model.program import Program
    from heavylift.kernel.model.reactions.mobility import mobility  # needs NumPy, which declaring a scene does not
    from heavylift.nodes.models import system

    return mobility(Program(system(built)))


def _many(n: int, word: str) -> str:
    one = {"bodies": "body", "degrees of freedom": "degree of freedom"}
    return word if n != 1 else one.get(word, word[:-1])


def _rows(built: plan.Plan, followed: Following) -> list[Row]:
    """The hooks at the end of each stage in which the block hangs, in a turn every 30 degrees, too."""
    found = []
    for step in followed.steps:
        if step.loads is None or not step.told:
            continue
        for crane in built.cranes:
            for hook in crane.hooks:
                rope = next(r for r in built.rig.hook_ropes if r.name == hook.rope)
                load, on_rope = step.loads.get(rope.carries, 0.0), step.static.tensions[rope.name] / built.gravity
                below = on_rope - hook.block_mass
                found.append(Row(step.stage, hook.rope, load, below, on_rope, below / hook.capacity))
    return found


def _page(followed: Following, rows: list[Row]) -> list[str]:
    hooks = list(dict.fromkeys(row.hook for row in rows))
    if not hooks:
        return ["", "Nothing is lifted as far as the action list can be followed without its dynamics."]
    lines = ["", _line("static sling load [t]", hooks)]
    shown: list[str] = []
    for stage, group in groupby(rows, key=lambda row: row.stage):
        cells = [f"{row.sling_load / 1e3:.1f}" for row in [*group][-len(hooks) :]]  # at its end
        if cells != shown:
            lines.append(_line(stage, cells))
            shown = cells
    largest = {hook: max((r for r in rows if r.hook == hook), key=lambda r: r.on_rope) for hook in hooks}
    lines += [
        "",
        _line("largest load of the rope [t]", [f"{largest[h].on_rope / 1e3:.1f}" for h in hooks]),
        _line("without the hook block [t]", [f"{largest[h].below_hook / 1e3:.1f}" for h in hooks]),
        _line("use of the hook's capacity", [f"{largest[h].use:.0%}" for h in hooks]),
    ]
    return lines


def _line(label: str, cells: list[str]) -> str:
    return f"  {label:<28}" + "".join(f" {cell:>{max(9, len(cell))}}" for cell in cells)


def _limits(built: plan.Plan, uses: Sequence[Use], findings: Sequence[Finding]) -> list[str]:
    """What is used of each limit, where it comes from, and what is not judged."""
    read = rows_of(uses)
    table = [HEAD, *read] if read else []
    widths = [max(len(cells[i]) for cells in table) for i in range(len(HEAD) - 1)] if read else []
    lines = ["", "Limits on the path at rest:"] if read else [""]
    for cells in table:
        lines.append(
            "  " + "  ".join(f"{cell:<{w}}" for cell, w in zip(cells, widths, strict=False)) + f"  {cells[-1]}"
        )
    foreseen = dynamics_foreseen(built)
    lines += [f"  dynamic amplification foreseen: {foreseen[0]:g} ({foreseen[1]})"] if foreseen else []
    lines += [f"  {line}" for line in (*hoisting_foreseen(built), *shared(built), *unjudged(built.limits))]
    return [line.rstrip() for line in lines] + _lines(findings)


def _swing_free(built: plan.Plan) -> list[str]:
    """The ramps that leave no swing, as they were chosen; moves alike in one line."""
    found: dict[tuple[str, str], list[str]] = {}
    angular = {name for mechanism in built.mechanisms for name in turning(mechanism.system)}
    for number, action in enumerate(built.actions, 1):
        for x in action.orders:
            if isinstance(x, Move) and x.pulses:
                chosen = _chosen(x, "rad/s2" if x.actuator in angular else "m/s2")
                found.setdefault((action.stage or f"action {number}", chosen), []).append(plan.driven(x.actuator))
    lines = [f"  {stage}: {', '.join(names)}: {chosen}" for (stage, chosen), names in found.items()]
    return ["", "Ramps without swing:", *lines] if lines else []


def _chosen(move: Move, unit: str) -> str:
    way, told = None if move.by is None else abs(move.by), []
    speed, *_ = times(move.pulses, way, abs(move.speed), move.accel, move.periods)  # that is reached
    for period in move.periods:
        accel = speed / period if move.pulses == 1 else move.accel
        lasts = ramp(move.pulses, speed, accel, period)[-1][0]
        how = f"{accel:.4g} {unit}{' in two pulses' * (move.pulses == 2)}"
        told.append(f"{how}, {lasts:.2f} s (a swing of {period:.2f} s)")
    same = told[0] == told[1]
    left = f"; as lengths change, about {degrees(move.left):.2g} deg of swing is left" if move.left else ""
    return (f"{told[0]}, to start and to stop" if same else f"{told[0]}, to start; {told[1]}, to stop") + left


def _lines(findings: Sequence[Finding]) -> list[str]:
    return [f"{f.severity}: {f.sentence}{f' ({f.stage})' if f.stage else ''}" for f in likewise(findings)]


def _ropes_at_rest(statics: Followed) -> list[str]:
    """What the first ropes of a mechanism carry at rest, over sheaves their most loaded part, at the end of each
    action."""
    ends = [a for a, b in pairwise(statics.states) if a.action != b.action] + list(statics.states[-1:])
    ropes = list(ends[0].tensions)[:COLUMNS] if ends else []
    lines = ["", _line("rope tension at rest [kN]", ropes)] if ropes else []
    shown: list[str] = []
    for state in ends if ropes else []:
        cells = [f"{state.tensions[name] / 1e3:.1f}" for name in ropes]
        if cells != shown:
            lines.append(_line(state.stage, cells))
            shown = cells
    if statics.why:
        lines += ["", f"No rest is known{f' after {ends[-1].stage}' if ends else ''}: {statics.why}"]
    return lines
