"""What `heavylift check SCENE` prints: the size of a scene and the static loads of each stage.

Shares are those of the plumb equilibrium; "on the rope" counts the hook block, "below the hook" does not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

from heavylift.nodes.limits.findings import Finding
from heavylift.nodes.limits.limit import Use
from heavylift.nodes.limits.sharing import dynamics_foreseen, hoisting_foreseen, shared
from heavylift.nodes.limits.telling import HEAD, likewise, unjudged
from heavylift.nodes.limits.telling import rows as rows_of
from heavylift.nodes.statics import StaticState

from . import plan
from .follow import Following


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
    rows: tuple[Row, ...]
    lines: tuple[str, ...]
    uses: tuple[Use, ...] = ()  # of each limit, the worst on the path at rest
    findings: tuple[Finding, ...] = ()  # what is beyond a limit there, or should be told

    def __str__(self) -> str:
        return "\n".join(self.lines)


def report(
    built: plan.Plan,
    followed: Following | None,
    states: Sequence[StaticState],
    uses: Sequence[Use],
    findings: Sequence[Finding],
    pruning: str = "",
) -> Report:
    """The report of a scene whose action list was followed; `pruning`: what of it is modelled."""
    bodies = 3 * len(built.cranes) + 2 * len(built.loaders) + (built.block is not None)
    bodies += sum(len(m.system.bodies) for m in built.mechanisms)
    dof = 3 * len(built.cranes) + 7 * len(built.loaders) + 6 * (built.block is not None)
    dof += sum(len(j.v0) for m in built.mechanisms for j in m.system.joints)
    ropes = len(built.rig.hook_ropes) + sum(len(m.system.ropes) + len(m.system.reevings) for m in built.mechanisms)
    slings, actions = len(built.rig.slings), len(built.actions)
    models = len(built.cranes) + len(built.loaders) + (built.block is not None) + len(built.mechanisms) + 1
    counts = (bodies, dof, ropes, slings, models, actions)
    words = ("bodies", "degrees of freedom", "ropes", "slings", "models", "actions")
    lines = [f"{built.name}: " + ", ".join(f"{n} {_many(n, word)}" for n, word in zip(counts, words, strict=True))]
    rows: list[Row] = []
    if followed:
        rows = _rows(built, followed, states)
        lines += _page(followed, rows) + _limits(built, uses, findings)
    lines += ["", pruning] if pruning else []
    return Report(built.name, *counts, tuple(rows), tuple(lines), tuple(uses), tuple(findings))


def _many(n: int, word: str) -> str:
    one = {"bodies": "body", "degrees of freedom": "degree of freedom"}
    return word if n != 1 else one.get(word, word[:-1])


def _rows(built: plan.Plan, followed: Following, states: Sequence[StaticState]) -> list[Row]:
    found = []
    for step, state in zip(followed.steps, states, strict=True):
        if step.loads is None:
            continue
        for crane in built.cranes:
            for hook in crane.hooks:
                rope = next(r for r in built.rig.hook_ropes if r.name == hook.rope)
                load, on_rope = step.loads.get(rope.carries, 0.0), state.tensions[rope.name] / built.gravity
                below = on_rope - hook.block_mass
                found.append(Row(state.stage, hook.rope, load, below, on_rope, below / hook.capacity))
    return found


def _page(followed: Following, rows: list[Row]) -> list[str]:
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
    ]
    if not followed.known:
        lines += ["", f"Followed up to {followed.steps[-1].stage}; what comes later depends on the motion."]
    return lines


def _line(label: str, cells: list[str]) -> str:
    return f"  {label:<28}" + "".join(f" {cell:>{max(9, len(cell))}}" for cell in cells)


def _limits(built: plan.Plan, uses: Sequence[Use], findings: Sequence[Finding]) -> list[str]:
    """What is used of each limit, where it comes from, and what nobody judges."""
    table = [HEAD, *rows_of(uses)]
    widths = [max(len(cells[i]) for cells in table) for i in range(len(HEAD) - 1)]
    lines = ["", "Limits on the path at rest:"]
    for cells in table:
        lines.append(
            "  " + "  ".join(f"{cell:<{w}}" for cell, w in zip(cells, widths, strict=False)) + f"  {cells[-1]}"
        )
    foreseen = dynamics_foreseen(built)
    lines += [f"  dynamic amplification foreseen: {foreseen[0]:g} ({foreseen[1]})"] if foreseen else []
    lines += [f"  {told}" for told in (*hoisting_foreseen(built), *shared(built), *unjudged(built.limits))]
    lines += [f"{f.severity}: {f.sentence}{f' ({f.stage})' if f.stage else ''}" for f in likewise(findings)]
    return [line.rstrip() for line in lines]
