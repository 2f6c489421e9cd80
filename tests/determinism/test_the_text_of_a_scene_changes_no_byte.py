"""The digest depends on what a scene means: not on how it is written, what its file is called, or its `name:`.

Plans of random texts are compared without their places, and runs of some by their digests, which are test data.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import msgspec
import pytest
from digests import digest, stored
from heavylift.coordinator.run import run
from heavylift.nodes.plan import Plan, decode, encode
from heavylift.nodes.scene import LoadedScene, bundled, load, parse
from heavylift.recordings import Recording
from rewritten import apart, block, commented, data, flow, other_units, shuffled

LARGE = {  # runs, or choices of levels, of many seconds
    *("dock", "ramp", "turnover", "turnover-untuned", "single-turn", "tandem", "wind-tandem", "in-turn"),
}
SHORT = {"edge", "floating", "pendulum", "spreader"}  # runs of less than one


@pytest.fixture
def seeds(request: pytest.FixtureRequest) -> range:
    """Of the texts of each kind."""
    return range(5 if request.config.getoption("full") else 1)


def text(name: str) -> str:
    return bundled()[name].read_text(encoding="utf-8")


@cache
def own(name: str) -> str:
    """The digest of a bundled scene as it is written."""
    return digest(load(name))


def placeless(plan: Plan) -> Any:
    """The plan without its name, without places, and without the words of conditions, which are quoted in sentences."""

    def without(x: Any) -> Any:
        if isinstance(x, dict):
            return {key: without(value) for key, value in x.items() if key not in ("where", "marks", "text")}
        return [without(each) for each in x] if isinstance(x, list) else x

    return without(msgspec.json.decode(encode(plan)) | {"name": ""})


REWRITTEN: dict[str, Callable[[str, Random], str]] = {
    "keys in another order": lambda given, random: block(shuffled(data(given), random), random),
    "in one line": lambda given, random: flow(shuffled(data(given), random)),
    "with comments": commented,
    "in other units": lambda given, random: flow(other_units(data(given))),
    "under another name": lambda given, random: flow(data(given) | {"name": f"lift-{random.randrange(99)}"}),
}
NAMES, KINDS = sorted(bundled()), [*REWRITTEN]
TURNS = [(KINDS[(i + turn) % len(KINDS)], name) for turn in range(len(KINDS)) for i, name in enumerate(NAMES)]


@pytest.mark.parametrize(("kind", "name"), TURNS)
@pytest.mark.large(beyond=len(NAMES))
def test_equivalent_texts_of_a_scene_give_the_same_plan(name: str, kind: str, seeds: range) -> None:
    want = placeless(load(name).plan)
    for seed in seeds:
        found = placeless(parse(REWRITTEN[kind](text(name), Random(seed)), f"text-{seed}.yaml").plan)
        assert found == want, f"seed {seed}"


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.large(beyond=10)
def test_a_scene_split_into_two_files_has_the_plan_of_the_whole(name: str, tmp_path: Path, seeds: range) -> None:
    for seed in seeds:
        found = load(apart(data(text(name)), Random(seed), tmp_path))
        assert placeless(found.plan) == placeless(load(name).plan), f"seed {seed}"


@pytest.mark.parametrize("name", [pytest.param(x, marks=[pytest.mark.large] if x in LARGE else []) for x in NAMES])
def test_bundled_scenes_have_their_stored_digests(name: str) -> None:
    """After a change that is meant: python tests/determinism/digests.py."""
    assert own(name) == stored()[name]


@pytest.mark.parametrize("name", [pytest.param(x, marks=[] if x in SHORT else [pytest.mark.large]) for x in NAMES])
def test_an_equivalent_text_of_a_scene_gives_the_same_digest(name: str) -> None:
    assert digest(everything(name)) == own(name)


def everything(name: str, seed: int = 1) -> LoadedScene:
    """A bundled scene in another order, with comments, in other units, under another name, in another file."""
    random = Random(seed)
    given = shuffled(other_units(data(text(name))), random) | {"name": "another"}
    return parse(block(given, random), "elsewhere.yaml")


def test_no_recorded_message_contains_a_file_name_or_line(tmp_path: Path) -> None:
    """Orders and stages tell their numbers, by which the plan tells their lines."""
    run(load("lift"), tmp_path / "lift.mcap", in_process=True)
    recording = Recording(tmp_path / "lift.mcap")
    events = recording.events()
    assert not [event for event in events if "yaml" in str(event.value)]
    orders = [e.value for e in events if e.source == "commander" and e.port == "order_crane" and e.type == "Run"]
    plan = decode(recording.attachments["resolved.json"])
    listed = [plan.actions[action].orders[order] for action, order in (value["at"] for value in orders)]
    assert [value["actor"] for value in orders] == [order.actuator for order in listed]  # type: ignore[union-attr]
    assert all(order.where.startswith("lift.yaml:") for order in listed)


def test_the_digests_of_all_bundled_scenes_are_stored() -> None:
    assert sorted(stored()) == sorted(bundled())


def test_a_change_of_gravity_in_a_scene_changes_its_digest() -> None:
    assert digest(load("pendulum", ["gravity=9.8 m/s2"])) != own("pendulum")
