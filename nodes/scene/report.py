"""The report of `heavylift check SCENE`: the size of a scene and the static loads of each stage.

Loads are those of the equilibrium path; the load "on the rope" includes the hook block, the load "below the hook" does
not.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from math import degrees, pi, sqrt
from typing import TYPE_CHECKING

from heavylift.kernel.description.findings import Check, State, findings
from heavylift.kernel.description.forces import Reeving
from heavylift.kernel.description.mechanics import Rope
from heavylift.nodes.limits.checks import governing, likewise, line_of, open_checks, scope, state_of, table_of
from heavylift.nodes.limits.run_tables import HookReach
from heavylift.nodes.limits.sharing import dynamics_required, hoisting_factors, shared
from heavylift.nodes.models.machine import turning
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.actions import Move, Turn
from heavylift.nodes.plan.connections import lug_places, ties_on
from heavylift.nodes.plan.limit import Use
from heavylift.nodes.plan.pulses import ramp, times
from heavylift.nodes.statics import Followed, StaticState
from heavylift.nodes.statics.aiming import world
from heavylift.recordings.sheets.sheet import Cell, Column, Table, part_text

from .factor_sheet import charts_used, rigging

COLUMNS = 6  # of a table of ropes
SHOWN, ROUND = pi / 6.0, 1e-6  # [rad] of a turn that has a row of its own

if TYPE_CHECKING:
    from heavylift.kernel.model.reactions.mobility import Mobility


@dataclass(frozen=True)
class HookLoadRow:
    """Loads of a hook in a stage [kg], and its utilisation."""

    stage: str
    hook: str
    sling_load: float
    below_hook: float
    on_rope: float
    use: float


@dataclass(frozen=True)
class SceneReport:
    """Size of a scene and its static loads; `str()` of it is the full report."""

    name: str
    bodies: int
    dof: int
    ropes: int
    slings: int
    models: int
    actions: int
    mobility: "Mobility"
    rows: tuple[HookLoadRow, ...]
    lines: tuple[str, ...]
    brief: tuple[str, ...]  # of them what fits a screen
    uses: tuple[Use, ...] = ()  # of each limit, the worst on the path at rest
    checks: tuple[Check, ...] = ()  # worst first
    line: str = ""  # how many checks have which state
    state: State = "amber"  # the worst
    tables: tuple[Table, ...] = ()  # static loads, radius and chart, design loads, the rigger's list

    def __str__(self) -> str:
        return "\n".join(self.lines)


def report(
    built: plan.Plan,
    statics: Followed,
    uses: Sequence[Use],
    checks: Sequence[Check] = (),
) -> SceneReport:
    """Return the report of a scene with its equilibrium path."""
    mobility = _mobility(built)
    every: list[Rope | Reeving] = []
    for m in built.machines:
        every += [*m.system.ropes, *m.system.reevings]
    ties = {tie.rope: not tie.rigging for m in built.machines for tie in m.ties}
    slings = sum(rope.hooked or ties[rope.name] for rope in every if rope.name in ties)
    ropes, actions = sum(rope.name not in ties for rope in every), len(built.actions)
    models = len(built.machines) + len(built.models) + 1
    counts = (mobility.bodies, mobility.dof, ropes, slings, models, actions)
    words = ("bodies", "degrees of freedom", "ropes", "slings", "models", "actions")
    size = f"{built.name}: " + ", ".join(f"{n} {_many(n, word)}" for n, word in zip(counts, words, strict=True))
    configured = [
        f"  {m.name}: {', '.join(f'{key} {x}' for key, x in m.configuration.items())}"
        for m in built.machines
        if m.configuration
    ]
    rows: list[HookLoadRow] = []
    hooks = [hook for machine in built.machines for hook in machine.hooks]
    loaded = any(machine.cargo for machine in built.machines) and not built.lists
    if loaded and hooks and all(hook.capacity for hook in hooks):
        rows = _rows(built, statics)
        loads_at_rest = _page(rows)
        loads = (
            [] if rows else ["", "Nothing is lifted as far as the action list can be followed without its dynamics."]
        )
    else:
        loads_at_rest, loads = _ropes_at_rest(statics), []
    reached = HookReach(built).see_path(statics.states) if statics.states else ()
    first = [*loads_at_rest, charts_used(reached)]
    then = [table for table in rigging(built, uses, ran=False) if table.rows]
    loads += _printed(first)
    if statics.why and not rows:
        ends = _ends(statics)
        loads += ["", f"No rest is known{f' after {ends[-1].stage}' if ends else ''}: {statics.why}"]
    listed, line = _limits(built, checks), line_of(checks)
    verdict, ramps = f"checks at rest: {line}", _swing_free(built)
    mobile = (f"  {line}" for line in mobility.lines)
    lines = (size, *mobile, *configured, *loads, *listed, *ramps, *_printed(then), "", verdict)
    known = [*governing(checks), *_lines(checks), *open_checks(checks), *scope(checks)]
    brief = (size, *configured, *loads, *ramps, "", verdict, *known, "", "all checks: --verbose")
    checked = tuple(uses), tuple(checks), line, state_of(checks)
    tables = (table_of(checks), *(table for table in (*first, *then) if table.rows))
    return SceneReport(built.name, *counts, mobility, tuple(rows), lines, brief, *checked, tables=tables)


def _printed(tables: Sequence[Table]) -> list[str]:
    return [line for table in tables if table.rows for line in ("", *part_text(table).splitlines())]


def _mobility(built: plan.Plan) -> "Mobility":
    """Return the numbers of bodies and degrees of freedom, as counted by the kernel."""
    from heavylift.kernel.model.program import Program
    from heavylift.kernel.model.reactions.mobility import mobility  # needs NumPy, which declaring a scene does not
    from heavylift.nodes.models import system

    return mobility(Program(system(built)))


def _many(n: int, word: str) -> str:
    one = {"bodies": "body", "degrees of freedom": "degree of freedom"}
    return word if n != 1 else one.get(word, word[:-1])


def _rows(built: plan.Plan, path: Followed) -> list[HookLoadRow]:
    """Return the hook loads at the end of each stage with a suspended load, and every 30 degrees during a turn."""
    found, rigging = [], {x.subject: x.rigging for x in built.limits if x.quantity == "hook load"}
    for state, after in zip(path.states, (*path.states[1:], None), strict=True):
        stage = _turned(built, state)
        if state.grounded or not (stage or after is None or after.action != state.action):
            continue
        for machine in built.machines:
            for hook in sorted(machine.hooks, key=lambda hook: hook.rope):
                on_rope = state.tensions[hook.rope] / built.gravity
                below = on_rope - hook.block_mass + rigging.get(hook.rope, 0.0)
                load = sling_load(built, state, hook)
                found.append(HookLoadRow(stage or state.stage, hook.rope, load, below, on_rope, below / hook.capacity))
    return found


def _turned(built: plan.Plan, state: StaticState) -> str:
    """Return the title of a state in which the load is turned by a multiple of 30 degrees; "" for other states."""
    action = built.actions[state.action - 1] if state.action else None
    if action is None or not any(isinstance(order, Turn) for order in action.orders):
        return ""
    theta = state.references["turn"]
    shown = abs(theta / SHOWN - round(theta / SHOWN)) < ROUND and abs(theta - built.start) > ROUND
    return f"{state.stage}, {180.0 / pi * theta:.0f} deg" if shown else ""


def sling_load(built: plan.Plan, state: StaticState, hook: plan.Hoist) -> float:
    """Return the load of a hook [kg] as the vertical pull of its slings.

    If its slings bend over edges or hang on frames, it is the vertical pull of its rope."""
    lugs, ties = lug_places(built.machines), [*ties_on(built.machines, hook)]
    straight = {rope.name for machine in built.machines for rope in machine.system.straight_ropes}
    ends = [(tie, lugs.get(state.hooked.get(tie.rope, "")) or tie.lower) for tie in ties]
    carried = {point.body for point in lugs.values()}
    if any(tie.rope not in straight or (tie.lower and tie.lower.body not in carried) for tie in ties):
        ropes = (rope for machine in built.machines for rope in machine.system.ropes if rope.name == hook.rope)
        lines = next((rope.lines for rope in ropes), ())
        distances = [(world(state, x.a.body, x.a.p), world(state, x.b.body, x.b.p)) for x in lines]
        distance = [sum(a[i] - b[i] for a, b in distances) for i in range(3)]
        up = distance[2] / sqrt(sum(d * d for d in distance)) if lines else 1.0
        return max(0.0, state.tensions[hook.rope] * up / built.gravity - (hook.below or hook.block_mass))
    total = 0.0
    for tie, lug in ends:
        if lug is not None and tie.rope in state.hooked and (tension := state.tensions[tie.rope]) > 0.0:
            a, b = world(state, tie.upper.body, tie.upper.p), world(state, lug.body, lug.p)
            distance = [p - q for p, q in zip(a, b, strict=True)]
            total += tension * distance[2] / sqrt(sum(d * d for d in distance)) / built.gravity
    return total


def _page(rows: list[HookLoadRow]) -> list[Table]:
    """Return the table of sling loads [t] by hook and stage, with rows only where they change, and the table of the
    largest loads."""
    hooks = list(dict.fromkeys(row.hook for row in rows))
    loads: list[tuple[Cell, ...]] = []
    for stage, group in groupby(rows, key=lambda row: row.stage):
        loads.append((stage, *(round(row.sling_load / 1e3, 1) for row in [*group][-len(hooks) :])))  # at its end
    largest = [max((r for r in rows if r.hook == hook), key=lambda r: r.on_rope) for hook in hooks]
    most: tuple[tuple[Cell, ...], ...] = (
        ("load of the rope [t]", *(x.on_rope / 1e3 for x in largest)),
        ("below the hook block [t]", *(x.below_hook / 1e3 for x in largest)),
        ("utilisation of the hook [%]", *(100.0 * x.use for x in largest)),
    )
    heads = [Column(hook, digits=1) for hook in hooks]
    return [
        Table("", (Column("static sling load [t]"), *heads), _changes(loads)),
        Table("", (Column("largest"), *heads), most if rows else ()),
    ]


def _changes(rows: Sequence[tuple[Cell, ...]]) -> tuple[tuple[Cell, ...], ...]:
    """Return the rows whose numbers differ from those in the row before."""
    return tuple(row for i, row in enumerate(rows) if not i or row[1:] != rows[i - 1][1:])


def _limits(built: plan.Plan, checks: Sequence[Check]) -> list[str]:
    """Return as lines of text: the checks, worst first, and the dynamic amplification factors that standards give."""
    lines = _printed([table_of(checks, title="Checks on the path at rest")]) or [""]
    required = dynamics_required(built)
    lines += [f"  dynamic amplification foreseen: {required[0]:g} ({required[1]})"] if required else []
    lines += [f"  {line}" for line in (*hoisting_factors(built), *shared(built))]
    return lines + _lines(checks)


def _swing_free(built: plan.Plan) -> list[str]:
    """Return the chosen ramps without swing as lines of text; equal moves in a stage share a line."""
    found: dict[tuple[str, str], list[str]] = {}
    angular = {name for mechanism in built.machines for name in turning(mechanism.system)}
    for number, action in enumerate(built.actions, 1):
        for x in action.orders:
            if isinstance(x, Move) and x.pulses:
                chosen = _chosen(x, "rad/s2" if x.actuator in angular else "m/s2")
                found.setdefault((action.stage or f"action {number}", chosen), []).append(plan.driven(x.actuator))
    lines = [f"  {stage}: {', '.join(names)}: {chosen}" for (stage, chosen), names in found.items()]
    return ["", "Ramps without swing:", *lines] if lines else []


def _chosen(move: Move, unit: str) -> str:
    distance, ramps = None if move.by is None else abs(move.by), []
    speed, *_ = times(move.pulses, distance, abs(move.speed), move.accel, move.periods)  # that is reached
    for period in move.periods:
        accel = speed / period if move.pulses == 1 else move.accel
        lasts = ramp(move.pulses, speed, accel, period)[-1][0]
        how = f"{accel:.4g} {unit}{' in two pulses' * (move.pulses == 2)}"
        ramps.append(f"{how}, {lasts:.2f} s (a swing of {period:.2f} s)")
    same = ramps[0] == ramps[1]
    left = f"; as lengths change, about {degrees(move.left):.2g} deg of swing is left" if move.left else ""
    return (f"{ramps[0]}, to start and to stop" if same else f"{ramps[0]}, to start; {ramps[1]}, to stop") + left


def _lines(checks: Sequence[Check]) -> list[str]:
    return [f"{x.word}: {x.message}" for x in likewise(findings(checks))]


def _ends(statics: Followed) -> list[StaticState]:
    """Return the states at the ends of actions."""
    return [a for a, b in pairwise(statics.states) if a.action != b.action] + list(statics.states[-1:])


def _ropes_at_rest(statics: Followed) -> list[Table]:
    """Return the table of static tensions at the end of each action, for the first ropes of a mechanism."""
    ends = _ends(statics)
    ropes = list(ends[0].tensions)[:COLUMNS] if ends else []
    rows: list[tuple[Cell, ...]] = [
        (x.stage, *(round(x.tensions[name] / 1e3, 1) for name in ropes)) for x in ends if ropes
    ]
    heads = (Column("rope tension at rest [kN]"), *(Column(name, digits=1) for name in ropes))
    return [Table("", heads, _changes(rows))]
