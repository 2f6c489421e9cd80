"""Turns by cranes of unlike types: three hooks hold a block at the ordered angle; from two it hangs by its weight."""

from __future__ import annotations

from math import atan2, degrees

import pytest
from heavylift.coordinator.record import play
from heavylift.nodes.scene import LoadedScene, parse

APART, ASIDE = 60.0, 20.0  # of the second crane's hook along and across the rails [m]
RAILS = "at: {x} m, rails: [-300 m, 300 m], upper trolley: {y} m, lower trolley: {low} m"
TWIN = "at: {x} m, span: 150 m, girder: [6 m, 144 m], rails: [-300 m, 300 m], upper: {y} m, lower: {low} m"
HALL = "at: {x} m, span: 200 m, trolley: {y} m, reach: [2 m, 198 m], runway: [-300 m, 300 m]"
CRANES = {  # parameters, hooks along the rails from the crane
    "goliath-900": (RAILS, {"H1": -6.0, "H2": 6.0}),
    "twin-hook-600": (TWIN, {"H1": -6.0, "H2": 6.0}),
    "overhead-100": (HALL, {"main": 0.0}),
}
HOLDS = [("goliath-900", "overhead-100"), ("twin-hook-600", "goliath-900"), ("twin-hook-600", "overhead-100")]


def turned(first: str, second: str, hooks: int, to: float, then: str = "wait: 1 s") -> LoadedScene:
    """A block on some hooks of one crane and the first hook of another one, hoisted and turned [deg]."""
    places = [("c0", name, x, 76.0) for name, x in [*CRANES[first][1].items()][:hooks]]
    name, x = next(iter(CRANES[second][1].items()))
    places.append(("c1", name, APART + x, 76.0 - ASIDE))
    cx, cy = (sum(p[i] for p in places) / len(places) for i in (2, 3))
    lugs, slings = [], []
    for i, (crane, hook, x, y) in enumerate(places):
        lugs += [f"{lug}{i}: [{x - cx + d} m, {y - cy} m, 1.3 m]" for lug, d in (("P", -1.0), ("Q", 1.0))]
        slings.append(f"  s{i}: {{on: {crane} {hook}, to: [P{i}, Q{i}], length: 4 m, slack: 0.05 m}}")
    at = [(x, 76.0 if i == 0 else 76.0 - ASIDE) for i, x in enumerate((0.0, APART))]
    cranes = [
        f"  c{i}: {{type: {kind}, {CRANES[kind][0].format(x=x, y=y, low=y - 14.0)}}}"
        for i, (kind, (x, y)) in enumerate(zip((first, second), at, strict=True))
    ]

    def each(order: str) -> str:
        return ", ".join(f"{crane} {hook}: {order}" for crane, hook, *_ in places)

    orders = [f"stage: step {i}, {each(order)}" for i, order in enumerate(("hoist 0.3 m/min until lifted",
              "hoist 1 m/min by 6 m"))]  # fmt: skip
    return parse("\n".join([
        "heavylift: 1", "name: turned",
        f"block: {{mass: 30 t, size: [90 m, 40 m, 2 m], at: [{cx} m, {cy} m, 2 m], lugs: {{{', '.join(lugs)}}}, "
        "supports: {height: 1 m, at: [[-44 m, -19 m], [-44 m, 19 m], [44 m, -19 m], [44 m, 19 m]]}}",
        "cranes:", *cranes, "rigging:", *slings, "actions:", *(f"  - {{{order}}}" for order in orders),
        f"  - {{stage: turn, block: turn 10 deg/min to {to} deg}}", f"  - {{{then}}}", "",
    ]), "turned.yaml", passing=True)  # fmt: skip


@pytest.mark.parametrize(("first", "second"), HOLDS)
def test_three_hooks_of_two_different_cranes_turn_a_block_to_the_ordered_angle(first: str, second: str) -> None:
    scene = turned(first, second, 2, 8.0)
    _, R = scene.statics.states[-1].poses["block"]
    assert degrees(atan2(R[1][2], R[2][2])) == pytest.approx(8.0, abs=0.5)
    assert not [x for x in scene.checks if x.quantity == "turn"]


@pytest.mark.parametrize(("first", "second"), HOLDS)
def test_a_turn_that_two_hooks_cannot_hold_gives_a_red_check_at_rest_and_in_a_run(first: str, second: str) -> None:
    scene = turned(first, second, 1, 8.0)
    _, R = scene.statics.states[-1].poses["block"]
    assert abs(degrees(atan2(R[1][2], R[2][2])) - 8.0) > 4.0
    for checks in (scene.checks, play(scene.plan).verdict.checks):
        assert [(x.subject, x.state) for x in checks if x.quantity == "turn"] == [("block", "red")]


@pytest.mark.parametrize("then", ["when: after 5 s, stage: later, wait: 100 s", "when: after 5 s, wait: 100 s"])
def test_a_turn_over_is_checked_at_its_end_and_not_when_the_next_action_begins(then: str) -> None:
    for hooks, red in ((2, []), (1, ["red"])):
        scene = turned(*HOLDS[0], hooks, 8.0, then)
        for checks in (scene.checks, play(scene.plan).verdict.checks):
            assert [x.state for x in checks if x.quantity == "turn"] == red
