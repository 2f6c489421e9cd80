"""The rung follows from what a scene asks and how accurately; what the scene names itself stays as named."""

import pytest
from heavylift.nodes.scene import check, load


def fidelity(accuracy: str, *settings: str, ask: str = "[rope tension]", scene: str = "lift"):
    return load(scene, [f"ask={ask}", f"accuracy={accuracy}", *settings]).plan.fidelity


def test_a_scene_that_asks_nothing_is_modelled_as_it_is_written():
    assert load("lift").plan.fidelity == load("lift", ["fidelity={ropes: elastic, girder: rigid}"]).plan.fidelity


@pytest.mark.parametrize(
    ("accuracy", "ropes", "girder"),
    [("5 %", "elastic", "rigid"), ("0.5 %", "elastic", "elastic"), ("0.01 %", "massive", "elastic")],
)  # fmt: skip
def test_the_rung_rises_with_the_accuracy(accuracy, ropes, girder):
    chosen = fidelity(accuracy)
    assert (chosen.ropes, chosen.girder) == (ropes, girder)


def test_swing_needs_no_girder_and_the_time_of_lift_off_does():
    assert fidelity("10 %", ask="[swing]", scene="tandem").girder == "rigid"
    assert fidelity("3 %", ask="[lift-off time]").girder == "elastic"


def test_a_mirrored_lift_moves_in_its_plane_and_another_in_space():
    assert fidelity("1 %").motion == "across"
    assert fidelity("1 %", "block.com=[0.5 m, 0 m, 0 m]").motion == "spatial"
    assert fidelity("1 %", scene="turnover").motion == "spatial"


def test_an_idle_crane_breaks_no_symmetry():
    assert fidelity("1 %", "cranes.idle={type: goliath-900, at: 140 m}").motion == "across"


def test_what_the_scene_names_stays_as_named():
    chosen = fidelity("5 %", "fidelity={ropes: massive, lumps: 3, motion: spatial}")
    assert (chosen.ropes, chosen.lumps, chosen.motion, chosen.girder) == ("massive", 3, "spatial", "rigid")


def test_the_report_names_every_rule_with_its_prediction():
    text = str(check(load("lift", ["ask=[rope tension]", "accuracy=1 %"])))
    for rule in (
        "two lumps",
        "lumped ropes",
        "rigid girder",
        "planar motion",
        "locked drives",
        "locked hinges",
        "rigid ropes",
    ):
        assert rule in text
    assert "predicted in all: rope tension" in text


def test_every_choice_can_be_named_otherwise():
    """What is named counts as named; the rest is chosen round it."""
    loaded = load("lift", ["ask=[rope tension]", "accuracy=1 %", "fidelity.pads=all", "fidelity.locked=[]"])
    outcomes = {d.choice.rule: d.outcome for d in loaded.verdict.decided}
    assert {outcomes[r] for r in ("standing pads", "locked drives", "locked hinges")} == {"named"}
    assert loaded.plan.fidelity.pads == "all"


def test_the_report_is_data_too():
    told = load("lift", ["ask=[rope tension]", "accuracy=5 %"]).verdict.data()
    assert told["predicted"]["rope tension"] <= 0.05
    assert told["cost"]["chosen"]["states"] < told["cost"]["richest"]["states"]
    assert {c["rule"] for c in told["choices"]} >= {"lumped ropes", "standing pads"}
