"""`extends` lays a load case over a scene; errors point into the file in which they were written."""

from pathlib import Path

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.scene import load
from heavylift.nodes.scene.text import read
from lifting import cargo, machine

HEAVIER = """\
heavylift: 1
extends: lift
name: heavier
block: {mass: 350 t}
"""


def test_a_bundled_scene_can_be_extended_by_its_name(tmp_path: Path) -> None:
    (tmp_path / "heavier.yaml").write_text(HEAVIER)
    scene = load(tmp_path / "heavier.yaml")
    assert scene.plan.name == "heavier"
    assert scene.text == HEAVIER
    assert cargo(scene.plan).mass == 350e3
    assert len(cargo(scene.plan).lugs) == 6
    assert machine(scene.plan, "block").where == "heavier.yaml:4:1"
    assert scene.plan.actions[0].where.startswith("lift.yaml:")


def test_the_plan_of_a_scene_does_not_depend_on_how_its_file_path_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "heavier.yaml").write_text(HEAVIER)
    (tmp_path / "slow.yaml").write_text("heavylift: 1\nextends: heavier.yaml\nname: slow\n")
    monkeypatch.chdir(tmp_path)
    for name in ("heavier.yaml", "slow.yaml"):
        absolute, relative, dotted = (load(path).plan for path in (tmp_path / name, name, f"../{tmp_path.name}/{name}"))
        assert absolute == relative == dotted
        assert relative.actions[0].where.startswith("lift.yaml:")


def test_scenes_can_extend_a_chain_of_files_with_settings_on_top(tmp_path: Path) -> None:
    (tmp_path / "heavier.yaml").write_text(HEAVIER)
    (tmp_path / "slow.yaml").write_text("heavylift: 1\nextends: heavier.yaml\nname: slow\nseed: 3\n")
    scene = load(tmp_path / "slow.yaml", ["seed=7", "actions.2.all hooks=hoist 1 m/min by 0.5 m"])
    assert (scene.plan.name, scene.plan.seed) == ("slow", 7)
    assert cargo(scene.plan).mass == 350e3
    assert [getattr(order, "by", None) for order in scene.plan.actions[2].orders] == [-0.5] * 3


def test_errors_in_an_extended_scene_are_reported_with_the_right_file(tmp_path: Path) -> None:
    base, case = tmp_path / "base.yaml", tmp_path / "case.yaml"
    base.write_text("heavylift: 1\nname: base\nend: 3 s\nsamples: 5\n")
    case.write_text("heavylift: 1\nextends: base.yaml\nname: case\nsed: 4\nend: 4\n")
    with pytest.raises(SceneError) as refusal:
        load(case)
    heads = [line for line in str(refusal.value).splitlines() if ": error: " in line]
    assert heads == [
        f"{case}:4:1: error: sed: unknown key 'sed'",
        f"{case}:5:6: error: end: missing unit: write '4 s' or '0.06666666667 min'",
        f"{base}:4:10: error: samples: missing unit: write '5 Hz' or '5 /s'",
    ]


def test_a_scene_that_extends_itself_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("heavylift: 1\nextends: b.yaml\n")
    (tmp_path / "b.yaml").write_text("heavylift: 1\nextends: a.yaml\n")
    with pytest.raises(SceneError, match=r"b.yaml:2:10: error: extends: 'a.yaml' extends itself in a circle"):
        load(tmp_path / "a.yaml")


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("turnovr", "there is no scene 'turnovr', neither a file nor a bundled one: did you mean 'turnover'?"),
        ("yard/none.yaml", "there is no scene file 'yard/none.yaml'"),
    ],
)
def test_a_missing_file_of_a_base_scene_is_reported(name: str, told: str) -> None:
    with pytest.raises(SceneError) as refusal:
        load(name)
    assert str(refusal.value) == told


def test_a_scene_file_that_is_not_text_is_reported(tmp_path: Path) -> None:
    (tmp_path / "run.yaml").write_bytes(b"\x89MCAP\xff\xfe")
    with pytest.raises(SceneError, match="cannot be read: it is not UTF-8 text"):
        load(tmp_path / "run.yaml")


def test_a_yaml_anchor_is_expanded_before_its_mapping_is_merged() -> None:
    text = "a: &a {x: 1, y: 2}\nb: {<<: *a, y: 3}\nc: &c {<<: [*a, {x: 5, z: 6}]}\nd: {q: 1, <<: *c}\n"
    found = read(f"{text}e: &e {{<<: *e, f: 1}}\n", "s")
    assert found.data["b"] == {"y": 3, "x": 1}
    assert (found.data["c"], found.data["d"]) == ({"x": 1, "y": 2, "z": 6}, {"q": 1, "x": 1, "y": 2, "z": 6})
    assert (found.data["e"], found.faults) == ({"f": 1}, [])
    assert (found.keys["b", "x"].line, found.keys["b", "y"].line) == (1, 2)
    (fault,) = read("g: {<<: 3}\n", "s").faults
    assert fault.sentence == "'<<' lays a mapping below this one, such as '<<: *name'"
    doubled = [f"a{i}: &a{i} {{<<: [*a{i - 1}, *a{i - 1}], k{i}: 1}}" for i in range(1, 60)]
    assert len(read("\n".join(["a0: &a0 {k0: 1}", *doubled]), "s").data["a59"]) == 60
