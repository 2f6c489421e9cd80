"""From a scene's path or name to its plan: read, lay over, validate, build, check.

All errors of one step are reported at once; a later step starts only when the earlier ones found nothing.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import msgspec
from heavylift.kernel.cache import remembered
from heavylift.kernel.errors import SceneError
from heavylift.nodes.fidelity import Question, Verdict, choose, unpromised
from heavylift.nodes.limits.geometry import geometry_findings
from heavylift.nodes.limits.judging import judge, uses_on_path
from heavylift.nodes.limits.telling import sorted_findings
from heavylift.nodes.models import node_names
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.finding import Finding
from heavylift.nodes.plan.limit import Use
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.plan.planar import planar
from heavylift.nodes.scene.checks.geometry import start_checks, step_checks
from heavylift.nodes.scene.checks.orders import held_orders, order_checks
from heavylift.nodes.scene.checks.overloads import overloads
from heavylift.nodes.scene.construction.limiting import build_limits
from heavylift.nodes.scene.construction.machines import build_fidelity, build_machines, check_parts
from heavylift.nodes.scene.construction.mechanisms import build_mechanisms
from heavylift.nodes.scene.construction.own_models import build_models, check_models
from heavylift.nodes.scene.construction.resolve import build_actions
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.keys.nodes import placement_faults
from heavylift.nodes.scene.keys.validate import validate
from heavylift.nodes.scene.text.extending import extended, scene_file, scene_text
from heavylift.nodes.scene.text.faults import raise_faults
from heavylift.nodes.scene.text.machine_types import gather
from heavylift.nodes.scene.text.overlay import override
from heavylift.nodes.scene.text.source import Fault, Source, read
from heavylift.nodes.scene.text.tables import tabled
from heavylift.nodes.scenes import bundled
from heavylift.nodes.statics import Followed, Following, StaticState, follow, following, goal_states
from heavylift.nodes.statics.action_preview import plan_key
from heavylift.nodes.statics.findings import path_findings
from heavylift.nodes.statics.static_state import standing
from heavylift.nodes.statics.swinging import swing_free

from .report import Report, report


@dataclass(frozen=True)
class LoadedScene:
    """A scene that can be run: its plan, its text as it stands in the file, its path, its keys."""

    plan: plan.Plan
    text: str
    path: Path
    scene: schema.Scene
    verdict: Verdict | None = None  # what is modelled, where the scene asks for something
    merged: str = ""  # text of the whole scene as JSON where it extends another one or has settings laid over it
    typed: str = ""  # its path or the name of a bundled scene, as it was given
    settings: tuple[str, ...] = ()  # laid over it
    passing: bool = False  # one of many that nobody loads again
    whole: Plan | None = None  # the plan before what is asked left anything out

    @property
    def placement(self) -> dict[str, str]:
        """Node -> process, for the nodes that the scene places."""
        return {node: process for process, hosting in self.scene.placement.items() for node in hosting.nodes}

    @property
    def remote(self) -> list[str]:
        """Processes that the scene places on other hosts."""
        return [process for process, hosting in self.scene.placement.items() if hosting.host == "remote"]

    @cached_property
    def statics(self) -> Followed:
        """The action list followed at rest, as far as that goes."""
        return follow(self.plan, keep=not self.passing)

    @cached_property
    def followed(self) -> Following | None:
        """The same as the states of a lift; None where no goliath lifts a block."""
        return following(self.plan, self.statics) if self.plan.lift else None

    @property
    def states(self) -> Sequence[StaticState]:
        """The points of the path at rest along the action list; none without a block."""
        return self.statics.states if self.plan.lift else ()

    @cached_property
    def _as_written(self) -> LoadedScene:
        if self.whole is None:
            return self
        scene = replace(self, plan=self.whole, whole=None)
        scene.__dict__["statics"] = self.statics
        return scene

    def answering(self, question: Question) -> Verdict:
        """What would be modelled if that were asked."""
        scene, followed = self.scene, self._as_written.followed
        if followed is None or self.plan.models:
            what = "a scene with models of its own" if self.plan.models else "a mechanism"
            return unpromised(question, self.plan.fidelity, f"{what} is modelled as it is written")
        built = self._as_written.plan
        named, steps = frozenset(scene.fidelity.model_fields_set), frozenset(scene.model_fields_set)

        def chosen() -> Verdict:
            return choose(built, followed, question, named, steps)

        asked = repr((plan_key(built), question, sorted(named), sorted(steps)))
        name = f"{hashlib.sha256(asked.encode()).hexdigest()}.verdict"
        return chosen() if self.passing else remembered(name, Verdict, chosen)

    def modelled(self, verdict: Verdict) -> Plan:
        """The plan with what a question requires."""
        built, question = self._as_written.plan, verdict.question
        if self._as_written.followed is None or built.models:
            return built
        built = msgspec.structs.replace(built, fidelity=planar(verdict.fidelity, built.loaders, built.cranes))
        if verdict.steps:
            steps = verdict.steps[0]
            only = built.tensions_only or (steps.method in plan.TENSION_METHODS and question.ask == ("rope tension",))
            built = msgspec.structs.replace(built, method=steps.method, tolerance=steps.tolerance, tensions_only=only)
        return built

    @cached_property
    def uses(self) -> list[Use]:
        """The worst of each limit on that path, of a lift also where its moves are to lead."""
        if not self.plan.limits or (self.plan.lift and not self.states):
            return []
        goals = goal_states(self.plan, self.statics) if self.plan.lift else []
        return uses_on_path(self.plan, [*self.statics.states, *goals])

    @cached_property
    def findings(self) -> list[Finding]:
        """What is beyond a limit on that path, or should be reported."""
        judged = judge(self.plan, self.uses, dynamic=False)
        return sorted_findings([*geometry_findings(self.plan), *judged, *path_findings(self.plan, self.statics)])


def load(scene: str | Path, overrides: Sequence[str] = ()) -> LoadedScene:
    """The scene of a path, or a bundled one by name, with `key=value` settings laid over it."""
    if not isinstance(scene, str | Path):
        raise SceneError(f"{scene!r} names no scene; give its path as text or as a Path, or the name of a bundled one")
    path = scene_file(str(scene))
    name = path.name if path in bundled().values() else str(scene)
    return replace(_build(path, name, scene_text(path, name), overrides), typed=str(scene))


def loaded(scene: LoadedScene | str | Path) -> LoadedScene:
    """The scene given, or that at a path or of a name; raises SceneError for anything else."""
    if isinstance(scene, LoadedScene):
        return scene
    if isinstance(scene, str | Path):
        return load(scene)
    raise SceneError(f"{scene!r} is no scene; give its path, the name of a bundled one, or what `load` returns")


def parse(text: str, name: str = "scene.yaml", overrides: Sequence[str] = (), passing: bool = False) -> LoadedScene:
    """The scene of a YAML text that stands in no file yet; `passing`: one of many that nobody loads again."""
    return replace(_build(Path(name), name, text, overrides, passing), typed=name)


def begun(name: str, like: str) -> str:
    """The text of a scene of this name that begins as a copy of a bundled one; its recording has that name, too."""
    path = scene_file(like)
    text = re.sub(r"^name: \S+", lambda _: f"name: {name}", scene_text(path, like), count=1, flags=re.M)
    return re.sub(rf"(?<!\S){re.escape(path.stem)}\.mcap\b", lambda _: f"{name}.mcap", text)


def restored(built: plan.Plan, text: str, merged: str, name: str) -> LoadedScene:
    """The scene of a plan that was made before, for it to be run again; needs no other file."""
    source = read(merged or text, name)
    scene = validate(source)
    raise_faults(source, source.faults)
    assert scene is not None
    return LoadedScene(built, text, Path(name), scene, merged=merged)


def check(scene: LoadedScene | str | Path) -> Report:
    """Sizes, static loads, use of limits and findings of a scene."""
    scene = loaded(scene)
    return report(scene.plan, scene.statics, scene.followed, scene.uses, scene.findings, str(scene.verdict or ""))


def _build(path: Path, name: str, text: str, overrides: Sequence[str], passing: bool = False) -> LoadedScene:
    source = extended(path, name, text, path.parent)
    if not source.data:
        raise_faults(source, source.faults)
    for setting in overrides:
        override(source, setting)
    tabled(source)
    gather(source)
    whole = json.dumps(source.data) if overrides or source.data != read(text, name).data else ""
    scene = validate(source)
    raise_faults(source, source.faults)
    assert scene is not None
    yard = build_machines(source, scene)
    check_parts(source, scene)
    lift = plan.Plan(
        name=scene.name,
        gravity=scene.gravity,
        cranes=tuple(yard.cranes),
        loaders=tuple(yard.loaders),
        block=yard.block,
        rig=plan.Rig(hook_ropes=tuple(yard.ropes), slings=tuple(yard.slings)),
        fidelity=build_fidelity(yard),
    )
    mechanisms = build_mechanisms(source, scene, lift)
    raise_faults(source, source.faults)
    loaded = LoadedScene(
        msgspec.structs.replace(
            lift,
            tolerance=scene.tolerance or min(scene.wanted_accuracy * plan.TOLERANCE_OF_ACCURACY, plan.LOOSEST),
            method=scene.method,
            step=scene.step,
            tensions_only=scene.tolerance_of == "rope tension",
            seed=scene.seed,
            microsteps=scene.microsteps,
            samples_hz=scene.samples,
            end=scene.end,
            mechanisms=mechanisms,
            models=build_models(yard, mechanisms),
            limits=build_limits(yard, mechanisms),
            actions=build_actions(yard, mechanisms),
        ),
        text,
        path,
        scene,
        merged=whole,
        settings=tuple(overrides),
        passing=passing,
    )
    check_models(source, loaded.plan)
    raise_faults(source, [*source.faults, *placement_faults(source, scene.placement, node_names(loaded.plan))])
    shaped, unknown = swing_free(loaded.plan, keep=not passing)
    raise_faults(source, [Fault(source.path_of(where), sentence) for where, sentence in unknown])
    loaded = replace(loaded, plan=shaped)
    raise_faults(source, _impossible(source, loaded))
    if loaded.followed is not None:
        rests = replace(loaded, plan=standing(loaded.plan, loaded.statics))
        rests.__dict__["statics"] = loaded.statics  # the same path: it begins at that rest
        loaded = rests
    return _pruned(loaded)


def _pruned(loaded: LoadedScene) -> LoadedScene:
    """With the fidelity and the integration steps that the scene's question requires."""
    if not loaded.scene.ask:
        return loaded
    verdict = loaded.answering(Question(loaded.scene.ask, loaded.scene.wanted_accuracy))
    return replace(loaded, plan=loaded.modelled(verdict), verdict=verdict, whole=loaded.plan)


def _impossible(source: Source, loaded: LoadedScene) -> list[Fault]:
    """What cannot be built or carried out, or would be overloaded; loads are judged only where everything fits."""
    scene, built = loaded.scene, loaded.plan
    if not built.lift:
        judged = any(machine.hooks for machine in built.mechanisms)
        found = overloads(built, loaded.statics, loaded.uses) if judged else []
        return [Fault(source.path_of(where), sentence, on_key=True) for where, sentence in found]
    found = start_checks(scene, built) or held_orders(built)
    if not found:
        assert loaded.followed is not None
        found = order_checks(scene, built, loaded.followed) or step_checks(scene, built, loaded.followed.steps)
    found = found or overloads(built, loaded.statics, loaded.uses)
    return [Fault(source.path_of(where), sentence, on_key=True) for where, sentence in found]
