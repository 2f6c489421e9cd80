"""Loading a scene by path or name: its plan is built from its text (`building`) or read from the cache.

The cache key consists of the scene's text, its settings and heavylift's code, and the state of each file that the scene
names. A second start therefore neither reads nor checks the scene again; the modules that validate scenes are not even
imported.
"""

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
from heavylift.kernel.cache import contents, read_cached, sources, write_cached
from heavylift.kernel.description.findings import Check
from heavylift.kernel.errors import SceneError, path_text
from heavylift.nodes.plan.limit import Use
from heavylift.nodes.plan.plan import Plan, functions
from heavylift.nodes.scene.text.files import files_read, scene_file, scene_text, state
from heavylift.nodes.scenes import bundled

from .loaded_scene import LoadedScene, SceneFacts

if TYPE_CHECKING:
    from .report import SceneReport


def load(
    scene: str | Path, overrides: str | Sequence[str] | Mapping[str, object] = (), **settings: object
) -> LoadedScene:
    """Load a scene by path, or a bundled one by name, with settings applied in order.

    load("lift", "block.mass=280 t"), load("lift", ["block.mass=280 t", "end=30 s"]),
    load("lift", {"block.mass": "280 t"}), load("lift", block={"mass": "280 t"}, end="30 s")
    """
    given = [*_settings(overrides), *_settings(settings)]
    if not isinstance(scene, str | Path):
        raise SceneError(
            f"{scene!r} is not the name of a scene; give its path as text or as a Path, or the name of a bundled scene"
        )
    path = scene_file(str(scene))
    name = path.name if path in bundled().values() else path_text(scene)
    return replace(_kept(path, name, scene_text(path, name), given), typed=str(scene))


def _settings(given: object, within: str = "") -> list[str]:
    """Return settings, given in any form, as texts `key=value`."""
    if isinstance(given, str):
        return [given]
    if isinstance(given, Mapping):
        pairs = ((f"{within}{key}", x) for key, x in given.items())
        return [y for key, x in pairs for y in (_settings(x, f"{key}.") if isinstance(x, Mapping) else [_said(key, x)])]
    listed = [*given] if isinstance(given, Iterable) else [given]
    if len(texts := [x for x in listed if isinstance(x, str)]) == len(listed):
        return texts
    raise SceneError(
        f"{given!r:.60} are not settings; write 'block.mass=280 t', a list of such texts, or a dict of key: value"
    )


def _said(key: str, x: object) -> str:
    try:
        return f"{key}={x}" if isinstance(x, str) else f"{key}={json.dumps(x, default=lambda y: y.tolist())}"
    except (TypeError, ValueError, AttributeError):
        raise SceneError(
            f"{key}: {x!r:.60} is not a valid value of a setting; give text, numbers, or lists of them"
        ) from None


def loaded(scene: LoadedScene | str | Path) -> LoadedScene:
    """Return the scene if it is loaded already, or load it by path or name; raises SceneError if loading fails."""
    if isinstance(scene, LoadedScene):
        return scene
    if isinstance(scene, str | Path):
        return load(scene)
    raise SceneError(f"{scene!r} is not a scene; give its path, the name of a bundled scene, or the result of `load`")


def parse(
    text: str, name: str = "scene.yaml", overrides: Sequence[str] = (), passing: bool = False, followed: bool = True
) -> LoadedScene:
    """Return the scene of a YAML text.

    `passing`: the scene is one of many variants and is not cached; `followed`: compute the equilibrium path."""
    from .building import build

    return replace(build(Path(name), name, text, overrides, passing, followed), typed=name)


def restored(built: Plan, text: str, merged: str, name: str) -> LoadedScene:
    """Return the scene of a recorded plan, without reading any file."""
    from .building import facts
    from .keys.validate import validated

    scene = validated(merged or text, name)
    return LoadedScene(built, text, Path(name), facts(scene), merged=merged, keys=scene, chosen=True)


def check(scene: LoadedScene | str | Path, near: Sequence[Check | Use] = ()) -> "SceneReport":
    """Return the report of a scene: sizes, static loads, utilisations and findings.

    `near`: clearances on its equilibrium path."""
    from .report import report

    scene = loaded(scene)
    return report(scene.plan, scene.statics, scene.uses, scene.checked(near))


class _CachedScene(msgspec.Struct):
    """The part of a loaded scene that is stored in the cache."""

    plan: Plan
    facts: SceneFacts
    merged: str
    files: dict[str, str]  # that it names -> their state


def _kept(path: Path, name: str, text: str, overrides: Sequence[str]) -> LoadedScene:
    """Load the scene from the cache if it was built from the same text, settings and files before; else build it."""
    answer = repr((name, text, [*overrides], str(path.parent.resolve()))).encode()
    file = f"{hashlib.sha256(sources() + _code() + answer).hexdigest()}.scene"
    if data := read_cached(file):
        with suppress(msgspec.MsgspecError):
            x = _decoded(data)
            if all(state(at) == known for at, known in x.files.items()):
                return LoadedScene(x.plan, text, path, x.facts, x.merged, settings=tuple(overrides))
    from .building import build

    with files_read() as files:
        loaded = build(path, name, text, overrides)
    if not functions(loaded.plan) and not loaded.apart:  # paths of several lifts follow from the scenes of each
        kept = _CachedScene(loaded.plan, loaded.facts, loaded.merged, files)
        write_cached(file, msgspec.msgpack.encode(kept))
    return loaded


@lru_cache(8)
def _decoded(data: bytes) -> _CachedScene:
    return msgspec.msgpack.decode(data, type=_CachedScene)


@cache
def _code() -> bytes:
    """Return the contents of all source files and machine types that determine a plan."""
    return contents(Path(__file__).parent.parent, ".py", ".yaml")
