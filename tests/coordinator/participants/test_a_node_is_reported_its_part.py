"""A node gets of a plan what its models need, however many others there are, and builds of it what all would give."""

from __future__ import annotations

import pytest
from heavylift.coordinator.participants import wiring
from heavylift.nodes.models import build, divided, subscriptions
from heavylift.nodes.plan import Plan, decode, encode
from heavylift.nodes.scene import load, parse

YARD = "heavylift: 1\nname: yard\nlifts:\n"


def yard(lifts: int, scene: str = "hall") -> Plan:
    """So many lifts of one scene side by side."""
    rows = [f"  l{i}: {{extends: {scene}, at: [0 m, {400 * i} m]}}\n" for i in range(lifts)]
    return parse(YARD + "".join(rows), overrides=["samples=5 Hz"]).plan


@pytest.mark.parametrize("scene", ["turnover", "damper", "crawler", "yard"])
def test_the_models_that_a_node_builds_alone_equal_those_built_from_the_whole_plan(scene: str) -> None:
    plan = load(scene).plan
    models, wires = build(plan), wiring(plan).all
    for name, part in zip(models, divided(plan, [[name] for name in models]), strict=True):
        message = decode(encode(part))
        own = build(message, [name])
        assert own[name].declare() == models[name].declare()
        assert subscriptions(message, own) == subscriptions(plan, {name: models[name]})
        assert {*own[name].ports} == {*models[name].ports}
        theirs = [x for x in wiring(message).all if name in (x.source, x.target)]
        assert theirs == [x for x in wires if name in (x.source, x.target)]


@pytest.mark.parametrize("scene", ["hall", "crawler", "spreader", "lift", "jib", "edge", "tandem"])
def test_the_configuration_of_one_machine_does_not_grow_with_the_number_of_machines(scene: str) -> None:
    size = {}
    for lifts in (1, 4):
        plan = yard(lifts, scene)
        first = next(machine.name for machine in plan.machines if machine.name.startswith("l0-"))
        size[lifts] = len(encode(next(divided(plan, [[first]]))))
    assert size[4] == size[1] < 12_000


def test_the_commander_model_of_one_action_list_receives_only_the_plan_of_its_lift() -> None:
    lists = build(yard(9))["commander"].children
    assert {len(lists[f"l{i}"].plan.machines) for i in range(9)} == {2}
    assert [lists[f"l{i}"].plan.first for i in range(3)] == [0, 7, 14]
    assert [action.stage for action in lists["l8"].plan.actions][:2] == ["l8: take up", "l8: lift off"]
    assert {*lists["l8"].owners.values()} == {"l8-hall"}
