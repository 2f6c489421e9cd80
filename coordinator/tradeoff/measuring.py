"""The reference and how far it has converged, then every setting that the budget allows, cheapest first.

Reference: the richest rung at a tight tolerance; a tighter tolerance, and for a yard ropes of twice as many lumps, show
what it is worth.  One process, one core, one run at a time; short runs are repeated, the least time counts and the
spread is told.  Speeds come from CPU time, which other work on the machine does not stretch as it does wall time.
"""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import ceil, floor, log10
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
from heavylift.coordinator.run.in_memory import CUT
from heavylift.coordinator.run.pool import cores
from heavylift.kernel.description.joint_table import JOINTS
from heavylift.kernel.errors import HeavyliftError, SceneError
from heavylift.kernel.version import __version__
from heavylift.nodes.fidelity.lifts import lift_of
from heavylift.nodes.plan.actions import Wait

from .planning import Planner
from .playing import Played, play, prepared
from .quantities import askable, asked, default_limit, errors, farthest
from .settings import METHODS, Rung, Setting, chosen, ladder
from .verdict import Row, Verdict, judge

if TYPE_CHECKING:
    from heavylift.nodes.plan.fidelity import Asked
    from heavylift.nodes.scene import LoadedScene

    from .communication import Distributed, Held

TIGHT, TIGHTER = 1e-8, 1e-9  # tolerances of the reference and of what shows its convergence
SCOUT = 1e-4
MORE = 4.0  # times the scout's seconds that a tight run of high order takes
SHARE = 0.6  # of the budget that the reference may take
SPARE = 1.1  # what a budget has to spare that is asked for: the next scout may be slower by so much
SHORT, RUNS = 0.5, 3  # [s] a run below it is repeated, so often
PATIENCE, SLOWER = 0.03, 5.0  # of the budget, or times what was predicted, that a run may take before it is cut


@dataclass(frozen=True)
class Machine:
    """Processor, cores that a process may use, load of the last minute (other work on it), versions."""

    processor: str
    cores: int
    load: float
    python: str
    heavylift: str


@dataclass(frozen=True)
class Measured:
    """All that the report tells: `commands` by row; `converged`: what each refinement changes the reference by."""

    scene: str
    ask: tuple[Asked, ...]
    limit: float
    budget: float
    spent: float
    rungs: list[Rung]
    commands: dict[str, str]
    rows: list[Row]
    verdict: Verdict
    reference: Setting
    converged: dict[str, dict[Asked, float]]
    true: Played
    shown: dict[str, Played]  # the pick and the next faster that fails
    left_out: int
    settled: int
    machine: Machine
    unit: str = "m"
    not_asked: dict[Asked, str] = field(default_factory=dict)
    held: list[Held] = field(default_factory=list)
    distributed: list[Distributed] = field(default_factory=list)

    def words(self, row: Row) -> str:
        """What a user types to run the scene as in a row."""
        return self.commands[str(row)]


def measure(
    scene: LoadedScene, ask: str = "", limit: float | None = None, budget: float = 300.0,
    say: Callable[[str], None] = lambda told: None, start: float = 0.0,
) -> Measured:  # fmt: skip
    """Measure a scene within `budget` seconds; `ask`: quantities, by default the scene's own or all that it shows;
    `limit` of their errors: by default the scene's accuracy if it asks, else 1 %; `start`: seconds that each run needs
    besides, until its scene is read.

    Raises SceneError for what cannot be asked of it, and for a budget that is too small for the reference.
    """
    began = time.perf_counter()
    wanted = asked(ask, scene.scene.ask)
    limit = default_limit(scene) if limit is None else limit
    scene = long_enough(scene, wanted, say)
    rungs, finer = ladder(scene)
    reference = Setting(rungs[-1], "dop853", TIGHT)
    say(f"reference: {reference}")
    true, refined = _reference(scene, reference, finer, budget)
    known = askable(true.shown)
    able = tuple(q for q, why in known.items() if not why)
    for quantity in wanted:
        if known[quantity]:
            other = ", ".join(able) or "nothing: its parts stand still"
            raise SceneError(f"--ask '{quantity}': {known[quantity]}; ask {other}")
    questions = wanted or able
    if not questions:
        raise SceneError(f"{scene.path.name}: nothing in it moves that a setting could be judged by")
    converged = {name: errors(run.shown, true.shown, questions) for name, run in refined.items()}
    rungs = [*chosen(scene, questions, limit), *rungs]
    planner = Planner(rungs, [*METHODS], limit)
    rows, commands, kept = list[Row](), dict[str, str](), dict[str, Played]()
    while (left := budget - (time.perf_counter() - began)) > 0.0 and (following := planner.next(left)) is not None:
        setting, predicted = following
        allowed = min(left, max(PATIENCE * budget, SLOWER * predicted))
        row, played = _row(scene, setting, true, questions, allowed, start)
        rows.append(row)
        if played is None:
            planner.tell(setting, 0.0, predicted, None, cut=CUT in row.reason)
        else:
            commands[str(row)], kept[str(row)] = setting.words(scene), played
            planner.tell(setting, played.prepared_s, row.wall_s * row.runs, row.worst)
        say(f"{row}: {row.reason or f'{row.waits_s:.3g} s to wait, worst error {row.worst:.2e}'}")
    unit = unit_of(scene)
    verdict = judge(rows, limit, unit)
    drawn = {str(row): kept[str(row)] for row in (verdict.pick, verdict.next_faster) if row is not None}
    return Measured(
        scene.plan.name, questions, limit, budget, time.perf_counter() - began, rungs, commands, rows, verdict,
        reference, converged, true, drawn, planner.left, planner.settled, _machine(), unit,
        {q: why for q, why in known.items() if why},
    )  # fmt: skip


def communicating(scene: LoadedScene, measured: Measured) -> Measured:
    """The measured scene with what its processes would cost measured as well."""
    from .communication import distributed, held_forces  # all of a distributed run

    return replace(measured, held=held_forces(scene, measured.true.simulated_s), distributed=distributed(scene))


def long_enough(scene: LoadedScene, wanted: tuple[Asked, ...], say: Callable[[str], None]) -> LoadedScene:
    """The scene, to the end of its action list where it would cut it and is asked its swing."""
    end, path = scene.plan.end, scene.statics
    if "swing" not in wanted or end is None or not path.known or not path.acted:
        return scene
    waits = sum(order.seconds for order in scene.plan.actions[-1].orders if isinstance(order, Wait))
    if not path.cut and path.acted[-1].before.t + waits <= end:
        return scene
    plan = msgspec.structs.replace(scene.plan, end=None)
    longer = replace(scene, plan=plan, settings=(*scene.settings, "end=null"))
    if not longer.statics.known:
        return scene
    say(f"the scene ends after {end:g} s and cuts its action list: measured to the end of the list")
    return longer


def _reference(
    scene: LoadedScene, reference: Setting, finer: Rung | None, budget: float
) -> tuple[Played, dict[str, Played]]:
    """The reference and its refinements; a scout at a loose tolerance tells first whether they fit."""
    allowed, runs = SHARE * budget, 2.0 + 2.0 * (finer is not None)
    scout = _played(scene, replace(reference, tolerance=SCOUT), allowed, budget, runs * MORE)
    needed = runs * (scout.prepared_s + MORE * scout.wall_s)
    if needed > allowed:
        raise too_small(budget, f"the reference alone takes about {needed:.3g} s", needed / SHARE)
    ends = time.perf_counter() + allowed
    true = _played(scene, reference, allowed, budget)
    refined = {f"tolerance {TIGHTER:g}": replace(reference, tolerance=TIGHTER)}
    if finer is not None:
        refined[finer.name.removeprefix("+ ")] = replace(reference, rung=finer)
    return true, {name: _played(scene, x, ends - time.perf_counter(), budget) for name, x in refined.items()}


def _played(scene: LoadedScene, setting: Setting, allowed: float, budget: float, times: float = 2.0) -> Played:
    """A run of the reference; SceneError if it does not fit, then the budget should be so many times larger."""
    try:
        return play(setting.plan(scene.plan), max(allowed, 0.0))
    except HeavyliftError as error:
        if CUT in str(error):
            raise too_small(budget, "the reference does not come to its end", times * budget) from None
        raise


def too_small(budget: float, why: str, needed: float) -> SceneError:
    """Why a budget [s] does not do, and one that should, to two digits and with some to spare."""
    digit = 10.0 ** (floor(log10(needed)) - 1)
    enough = ceil(SPARE * needed / digit) * digit
    return SceneError(
        f"--budget {budget:.3g} s: too small, {why}; give it {enough:g} s or more, or a scene that ends earlier "
        "(--set end=...)"
    )


def unit_of(scene: LoadedScene) -> str:
    """Of places: of a block, or of the coordinates of all joints of a mechanism."""
    plan = scene.plan
    if lift_of(plan).block is not None:
        return "m"
    joints = [JOINTS[j.kind] for m in plan.mechanisms for j in m.system.joints]
    turns = {joint.turns(i) or i >= (joint.n_q if joint.quaternion is None else joint.quaternion)
             for joint in joints for i in range(joint.n_q)}  # fmt: skip
    return "m or rad" if len(turns) > 1 else "rad" if True in turns else "m"


def _row(
    scene: LoadedScene, setting: Setting, true: Played, ask: tuple[Asked, ...], allowed: float, start: float
) -> tuple[Row, Played | None]:
    named = setting.rung.name, setting.method, setting.how
    plan = setting.plan(scene.plan)
    try:
        played = play(plan, allowed)
        walls, cpus, starts = [played.wall_s], [played.cpu_s], [played.start_s]
        while played.wall_s < SHORT and len(walls) < RUNS:
            again = play(plan, allowed)
            walls.append(again.wall_s)
            cpus.append(again.cpu_s)
            starts.append(again.start_s)
        if len(starts) == 1:
            starts.append(prepared(plan))
    except HeavyliftError as error:
        return Row(*named, {}, reason=" ".join(str(error).split())), None
    row = Row(
        *named,
        errors(played.shown, true.shown, ask),
        position=farthest(played.shown, true.shown),
        simulated_s=played.simulated_s,
        start_s=start + min(starts),
        wall_s=min(walls),
        cpu_s=min(cpus),
        messages=played.messages,
        energy=played.energy,
        drift=played.drift,
        runs=len(walls),
        spread=max(cpus) / min(cpus) - 1.0,
        notes=played.notes,
    )
    return row, played


def _machine() -> Machine:
    """This one, now."""
    listed = Path("/proc/cpuinfo")
    lines = listed.read_text(encoding="utf-8").splitlines() if listed.exists() else []
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    processor = next(named, platform.processor() or platform.machine())
    return Machine(processor, cores(), os.getloadavg()[0], platform.python_version(), __version__)
