"""A setting may name one number of any list that a scene leaves to its default: the others keep their defaults."""

from __future__ import annotations

import random
from collections.abc import Iterator
from copy import deepcopy

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.scene import load, parse
from heavylift.nodes.scene.inputs import inputs
from heavylift.nodes.scene.keys import below, listed, override
from heavylift.nodes.scene.keys.validate import validate
from heavylift.nodes.scene.text import Path, SourceText, gather, read
from heavylift.nodes.scenes import bundled
from lifting import cargo

SCENES = ("spreader", "jib", "wind-tandem", "arm")


def unwritten(source: SourceText) -> Iterator[tuple[Path, list[object]]]:
    """Path and values of each list of a scene that stands in no line of it."""

    def look(at: object, kind: object, path: Path) -> Iterator[tuple[Path, list[object]]]:
        values = listed(at, kind) if isinstance(at, tuple | list) else None
        if values and source.at(path) is None and path[:1] != ("machines",):  # which types write
            yield path, list(values)
        for key, (value, inner) in below(at, kind).items():
            yield from look(value, inner, (*path, key))

    trial = deepcopy(source)
    gather(trial)
    yield from look(validate(trial), None, ())


TEXTS = {name: bundled()[name].read_text() for name in ("lift", "turnover", *SCENES)}


@pytest.mark.parametrize("name", SCENES)
def test_every_single_number_in_a_list_of_default_values_can_be_set(name: str) -> None:
    found = list(unwritten(read(TEXTS[name], name)))
    assert found, "there are such lists"
    for path, values in random.Random(1).sample(found, min(6, len(found))):
        i = random.Random(2).randrange(len(values))
        dotted = ".".join(map(str, path))
        for place in (f"{dotted}[{i}]", f"{dotted}.{i}", *([f"{dotted}.{'xyz'[i]}"] if len(values) == 3 else [])):
            source = read(TEXTS[name], name)
            override(source, f"{place}={values[i]}")
            assert not source.faults, place
            assert source.at(path) == [*values[:i], source.at((*path, i)), *values[i + 1 :]]
            whole = read(TEXTS[name], name)
            override(whole, f"{dotted}=[{', '.join(map(str, values))}]")
            scenes = []
            for each in (source, whole):
                gather(each)
                scenes.append(validate(each))
            assert scenes[0] == scenes[1], place


def test_a_path_in_settings_and_varied_inputs_has_three_equivalent_spellings() -> None:
    text = TEXTS["lift"]
    plans = [
        parse(text, "lift.yaml", [f"{path}=0.1 m"]).plan for path in ("block.com[0]", "block.com.x", "block.com.0")
    ]
    assert plans[0] == plans[1] == plans[2]
    assert cargo(plans[0]).com == (0.1, 0.0, 0.0)
    distances = {one.path for one in (inputs(load("lift"), [name])[0] for name in ("block.com[0]", "block.com.x"))}
    assert distances == {("block", "com", 0)}


@pytest.mark.parametrize("setting", ["block.com[5]=1 m", "block.com.w=1 m", "block.mass[0]=1 t", "block.lugs[0]=1 m"])
def test_a_setting_for_a_path_that_does_not_exist_in_the_scene_is_refused(setting: str) -> None:
    with pytest.raises(SceneError, match=r"--set:1:1|no place|block"):
        parse(TEXTS["lift"], "lift.yaml", [setting])
