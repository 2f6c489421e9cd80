"""Settings take the paths that errors print, also for parts of a machine type, whose names have dots."""

from __future__ import annotations

import random
from collections.abc import Iterator

import pytest
from heavylift.coordinator.sweeps import axes_of
from heavylift.kernel import SceneError
from heavylift.nodes.scene import load, parse, settings
from heavylift.nodes.scene.inputs import inputs
from heavylift.nodes.scene.keys import below, quantity
from heavylift.nodes.scene.text import Path, made, path_in, read, shown
from heavylift.nodes.scenes import bundled

SCENES = ("jib", "crawler")
TEXTS = {name: bundled()[name].read_text(encoding="utf-8") for name in SCENES}


def numbers(at: object, kind: object, path: Path = ()) -> Iterator[Path]:
    """The paths of all quantities that have a value, save those in lists."""
    if isinstance(at, float) and quantity(kind):
        yield path
    for key, (value, inner) in below(at, kind).items():
        if isinstance(key, str):
            yield from numbers(value, inner, (*path, key))


@pytest.mark.parametrize("name", SCENES)
def test_every_path_that_is_printed_for_a_machine_type_can_be_set(name: str) -> None:
    scene, source = load(name), read(TEXTS[name], name)
    found = [path for path in numbers(scene.scene, None) if path[0] == "machines"]
    assert len(found) > 20
    for path in random.Random(1).sample(found, 10):
        assert path_in(source, shown(path)) == path
    written = [path for path in found if made(source).at(path) is not None]
    some = inputs(scene, [shown(path) for path in random.Random(2).sample(written, 5)])
    same = settings(some, [f"{x.value / x.factor!r} {x.unit}" for x in some])
    assert parse(TEXTS[name], f"{name}.yaml", same, passing=True).scene == scene.scene


def test_a_setting_for_a_part_overrides_the_value_in_its_machine_type() -> None:
    scene = parse(TEXTS["jib"], "jib.yaml", ["machines.jib.hooks.jib.main.at.x=39 m"], passing=True).scene
    assert scene.machines["jib"].hooks["jib.main"].at == (39.0, 0.0, 0.0)
    assert scene.machines["jib"].hooks["jib.main"].falls == 8


def test_a_scene_may_override_a_part_of_a_machine_type() -> None:
    written = parse(
        "extends: jib\nname: own\nmachines: {jib: {hooks: {jib.main: {block: 3 t}}}}\n", "scene.yaml", passing=True
    )
    assert written.scene.machines["jib"].hooks["jib.main"].block == 3000.0


BAD = {
    "machines.jib.hooks.jib.main.speed=30": "--set:1:35: error: machines.jib.hooks.jib.main.speed: missing unit",
    "machines.jib.bodies.jib.bom.mass=30 t": "the type jib-60 makes no 'jib'",
    "machines.jib.bodies.mast={mass: 3 t}": "the type jib-60 makes no 'mast'",
}


@pytest.mark.parametrize("setting", BAD)
def test_settings_for_parts_that_a_machine_type_does_not_have_are_reported(setting: str) -> None:
    with pytest.raises(SceneError) as error:
        parse(TEXTS["jib"], "jib.yaml", [setting], passing=True)
    assert BAD[setting] in str(error.value)


@pytest.mark.parametrize("path", ["nosuch", "block.maß", "machines.jib.hooks.jib.main.sped"])
def test_an_unknown_path_of_a_varied_input_is_reported_before_the_missing_step_is_requested(path: str) -> None:
    with pytest.raises(SceneError, match="unknown key"):
        axes_of(load("jib"), [f"{path}=3 t..4 t"], sampling=False)
