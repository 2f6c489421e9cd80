"""From a scene's path or name to its plan: read, lay over, validate, build, check.

Errors of one step are told all at once; a later step starts only when the earlier ones found nothing.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from heavylift.kernel.errors import SceneError

from . import plan, schema
from .assemble import build_mechanism
from .capacity import capacity_checks
from .faults import raise_faults
from .follow import Following, follow
from .geometry import geometry_checks
from .machines import build_machines
from .resolve import build_actions
from .source import Fault, Source, override, read
from .validate import validate

SCALE = 1e-2  # integrator tolerance / accuracy of the tensions


@dataclass(frozen=True)
class LoadedScene:
    """A scene that can be run: its plan, its text as it stands in the file, its path."""

    plan: plan.Plan
    text: str
    path: Path
    scene: schema.Scene


def bundled() -> dict[str, Path]:
    """The scenes that come with heavylift, by name."""
    folder = Path(str(files("heavylift.nodes.scenes")))
    return {path.stem: path for path in sorted(folder.glob("*.yaml"))}


def load(scene: str | Path, overrides: Sequence[str] = ()) -> LoadedScene:
    """The scene of a path, or a bundled one by name, with `key=value` settings laid over it."""
    path = _find(str(scene))
    shown = path.name if path in bundled().values() else str(scene)
    text = _text(path, shown)
    return LoadedScene(*_build(_source(path, shown, text, ()), overrides), text=text, path=path)


def parse(text: str, name: str = "scene.yaml", overrides: Sequence[str] = ()) -> LoadedScene:
    """The scene of a YAML text; `extends` looks beside the working folder."""
    plan_, scene = _build_pair(_source(Path(name), name, text, ()), overrides)
    return LoadedScene(plan_, text, Path(name), scene)


def _build_pair(source: Source, overrides: Sequence[str]) -> tuple[plan.Plan, schema.Scene]:
    for setting in overrides:
        override(source, setting)
    scene = validate(source)
    raise_faults(source, source.faults)
    assert scene is not None
    yard = build_machines(source, scene)
    mechanism = build_mechanism(source, scene.mechanism, scene.gravity) if scene.mechanism else None
    taken = [*scene.cranes, *(scene.rig.loaders if scene.rig else ()), *(["block"] if scene.block else ())]
    if mechanism and mechanism.name in taken:
        told = f"the name '{mechanism.name}' is given twice: another machine has it, too"
        source.faults.append(Fault(("mechanism", "name"), told))
    actions = build_actions(yard, mechanism)
    raise_faults(source, source.faults)
    built = plan.Plan(
        name=scene.name,
        gravity=scene.gravity,
        tolerance=scene.accuracy * SCALE,
        seed=scene.seed,
        samples_hz=scene.samples,
        end=scene.end,
        cranes=tuple(yard.cranes),
        loaders=tuple(yard.loaders),
        block=yard.block,
        mechanisms=(mechanism,) if mechanism else (),
        rig=plan.Rig(hook_ropes=tuple(yard.ropes), slings=tuple(yard.slings)),
        actions=actions,
    )
    _check(source, scene, built)
    return built, scene
