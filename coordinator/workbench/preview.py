"""Preview of a scene's text on pages: the start pose at once, then the static path and its checks.

The start pose is shown even if the actions cannot be carried out; a path that ends early is shown up to its end.
"""

from __future__ import annotations

import traceback
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from heavylift.coordinator.participants.mechanics_at import check_steps
from heavylift.coordinator.verdict.judging import near_at_rest
from heavylift.coordinator.verdict.worst_corners import with_worst_clearances
from heavylift.kernel.description.findings import clock
from heavylift.kernel.errors import HeavyliftError, PlacedFault, SceneError
from heavylift.kernel.model.program import Program
from heavylift.nodes.models import system
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.scene import LoadedScene, check as examine
from heavylift.nodes.scene.building import build
from heavylift.nodes.statics import StaticState, follow
from heavylift.nodes.statics.static_path import first_rest
from heavylift.recordings.sheets.sheet import table_html

from .handles import handles
from .picture import Picture
from .results import of_checks

Data = dict[str, Any]


class Step(NamedTuple):
    """Progress of a preview: a message for the pages, and the states to draw if there are new ones."""

    kind: str  # "picture", "faults", "checks"
    data: Data
    picture: Picture | None = None


def previewed(path: Path, text: str) -> Iterator[Step]:
    """Preview a scene without a run: yield its start, its equilibrium path, its checks, and any faults."""
    try:
        first = build(path, path.name, text, (), followed=False)
        grips = handles(text, first.plan)
        yield _pictured(first.plan, [_start(first)], "start", grips)
    except Exception as error:
        yield _faulty(error, path)
        return
    try:
        loaded = build(path, path.name, text, ())
        yield Step("faults", {"faults": []})
        yield from _path(loaded.plan, loaded.statics.states, grips)
        check_steps(loaded)
        yield _checked(loaded)
    except Exception as error:
        yield _faulty(error, path)
        with suppress(HeavyliftError):
            yield from _path(first.plan, follow(first.plan).states, grips)


def _start(scene: LoadedScene) -> StaticState:
    """Return the state at the start: a lift in equilibrium, a mechanism in the pose that the scene states."""
    if scene.apart:
        return scene.apart.states[0]
    if scene.lifts:
        return first_rest(scene.plan)
    program = Program(system(scene.plan))
    poses = {link.body.name: program.poses_at_start(link.body.name) for link in program.graph.links}
    return StaticState(
        0.0, 0, "at the start", "",
        {rope.name: 0.0 for rope in program.system.all_ropes},
        {support.name: 0.0 for support in program.system.supports},
        {name: (tuple(p.tolist()), tuple(map(tuple, R.tolist()))) for name, (R, p) in poses.items()},
        {}, {}, {}, {tie.rope: tie.lug for machine in scene.plan.machines for tie in machine.ties if tie.lug},
        False, None,
    )  # fmt: skip


def _pictured(plan: Plan, states: Sequence[StaticState], what: str, grips: Data) -> Step:
    picture = Picture(plan, states)
    content = {"title": plan.name, "what": what, **picture.content(), "drawings": picture.drawings(0), **grips}
    return Step("picture", content, picture)


def _path(plan: Plan, states: Sequence[StaticState], grips: Data) -> Iterator[Step]:
    if len(states) > 1:
        yield _pictured(plan, states, "path", grips)


def _checked(scene: LoadedScene) -> Step:
    """Return the verdict, checks, findings and tables of the static path as a message."""
    scene = with_worst_clearances(scene)
    report = examine(scene, near_at_rest(scene.plan, scene.statics))
    notes = [f"{clock(t, 1)}: {sentence}" for t, sentence in scene.statics.notes]
    found = of_checks(report.state, report.line, report.checks, map(table_html, report.tables[1:]))
    return Step("checks", found | {"notes": notes, "ends": scene.statics.why})


def _faulty(error: Exception, path: Path) -> Step:
    """Return the faults of an error as a message, each with its place in the text; faults without a place get the first
    line."""
    found = error.faults if isinstance(error, SceneError) else ()
    if not isinstance(error, HeavyliftError):
        traceback.print_exception(error)
        found = (PlacedFault(path.name, 1, 1, "", f"internal error, {type(error).__name__}: {error}"),)
    found = found or (PlacedFault(path.name, 1, 1, "", str(error)),)
    return Step("faults", {"faults": [fault._asdict() for fault in found]})
