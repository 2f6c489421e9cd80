"""Edits of a scene's text: the value is there and all else stays, or a sentence says why not."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from heavylift.coordinator.workbench import edited, reordered, version_of, write
from heavylift.kernel import SceneError
from heavylift.nodes.scene import bundled, json_schema
from heavylift.nodes.scene.text import read

LIFT = bundled()["lift"].read_text()
VALUES = ("40.5 m", "[1 m, 2 m, 3 m]", "{a: 1, b: 2 t}", "lift: by hand", "it's #1", "true", "7")


def comments(text: str) -> list[str]:
    return [line.partition("#")[2] for line in text.splitlines() if "#" in line]


def test_editing_a_value_changes_only_its_line() -> None:
    changed = edited(LIFT, ["block", "mass"], "310 t")
    assert changed == LIFT.replace("mass: 300 t", "mass: 310 t")
    changed = edited(LIFT, ["cranes", "crane", "at"], "41 m")
    assert changed == LIFT.replace("at: 40 m}  ", "at: 41 m}  ")


def test_the_workbench_adds_scene_keys_at_their_place_and_removes_them_without_a_trace() -> None:
    added = edited(LIFT, ["block", "com"], "[0 m, 0 m, 1 m]")
    assert read(added, "x").data["block"] == {**read(LIFT, "x").data["block"], "com": ["0 m", "0 m", "1 m"]}  # type: ignore[dict-item]
    assert added.splitlines()[23:25] == ["    R2: [2 m, 6 m, 4.3 m]", "  com: [0 m, 0 m, 1 m]"]
    assert edited(added, ["block", "com"], None) == LIFT
    assert edited(LIFT, ["rig", "loaders", "loader-2"], None) == LIFT.replace(
        "    loader-2: {hook: crane H2, sling: 10 m, lugs: [Q1, Q2], capacity: 300 t}\n", ""
    )
    assert edited(LIFT, ["factors", "wind"], None) == LIFT.replace("wind: 10 m/s, ", "")
    assert "    wait: 20 s\n  - {wait: 5 s}\n" in edited(LIFT, ["actions", 5], "{wait: 5 s}")


def test_a_new_top_level_key_of_a_scene_is_inserted_in_the_order_of_the_schema() -> None:
    order = list(json_schema()["properties"])
    for name in ("lift", "crawler", "in-turn", "edge"):
        text = bundled()[name].read_text()
        for key in sorted({"block", "obstacles", "wind", "end", "actions"} - set(read(text, name).data)):
            found = list(read(edited(text, [key], "some value"), name).data)
            before, after = found[: found.index(key)], found[found.index(key) + 1 :]
            assert order.index(before[-1]) < order.index(key), (name, key)
            assert not [x for x in after if x in order and order.index(x) < order.index(key)], (name, key)
    added = edited(edited(LIFT, ["blocks", "b", "mass"], "1 t"), ["blocks", "b", "at"], "2 m")
    assert "\nblocks:\n  b:\n    mass: 1 t\n    at: 2 m\n" in added


@pytest.mark.parametrize("name", ["lift", "turnover", "in-turn"])
def test_the_workbench_moves_actions_in_a_list_together_with_their_comments(name: str) -> None:
    text, rng = bundled()[name].read_text(), random.Random(name)
    actions = read(text, "x").data["actions"]
    assert isinstance(actions, list)
    for _ in range(3):
        at, to = rng.randrange(len(actions)), rng.randrange(len(actions))
        changed = reordered(text, ["actions", at], to)
        assert read(changed, "x").data["actions"] == [
            *(rest := actions[:at] + actions[at + 1 :])[:to],
            actions[at],
            *rest[to:],
        ]
        assert sorted(filter(str.strip, changed.splitlines())) == sorted(filter(str.strip, text.splitlines()))
        assert read(reordered(changed, ["actions", to], at), "x").data == read(text, "x").data


@pytest.mark.parametrize("name", ["lift", "crawler", "jib", "linkage", "edge"])
def test_a_random_edit_of_a_bundled_scene_changes_one_value_and_keeps_comments(name: str) -> None:
    text, rng = bundled()[name].read_text(), random.Random(name)
    paths = [path for path in read(text, "x").values if path]
    for path in rng.sample(paths, min(12, len(paths))):
        value = rng.choice(VALUES)
        changed = edited(text, path, value)  # which reads it back, and compares all other values
        assert changed != text or value in text
        gone = comments(edited(text, path, None))
        assert set(gone) <= set(comments(text))
        nested = [other for other in paths if other[: len(path)] == path and other != path]
        if not nested:
            assert [comment for comment in comments(text) if f"#{comment}" not in changed] == []


@pytest.mark.parametrize(
    ("path", "value", "why"),
    [
        (["block", "mass"], "[1 t,", "no"),
        (["block", "mass"], "1 t\nname: other", "single line"),
        (["block", "mass", "of"], "3 t", "is a value"),
        (["actions", 17], "{wait: 5 s}", "the number of an item"),
        (["block", "colour"], None, "the scene has no such entry to remove"),
        ([], "3", "name the key"),
    ],
)
def test_the_workbench_refuses_with_one_sentence_to_edit_a_value_that_cannot_be_written(
    path: list[str | int], value: str | None, why: str
) -> None:
    with pytest.raises(SceneError, match=why) as refused:
        edited(LIFT, path, value)
    assert "\n" not in str(refused.value)


def test_an_edit_of_a_file_that_has_changed_meanwhile_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "lift.yaml"
    path.write_text(LIFT)
    write(path, "heavylift: 1\n", version_of(LIFT))
    with pytest.raises(SceneError, match="changed elsewhere"):
        write(path, LIFT, version_of(LIFT))
    assert path.read_text() == "heavylift: 1\n"
    assert [x.name for x in tmp_path.iterdir()] == ["lift.yaml"], "nothing is left beside it"
