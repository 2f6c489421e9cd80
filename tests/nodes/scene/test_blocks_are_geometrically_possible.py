"""Slings, lugs and blocks at impossible places are refused with their line, or red in check and run."""

from __future__ import annotations

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.limits import geometry_findings, outside, passes_through
from heavylift.nodes.scene import bundled, load, parse
from lifting import hook_ropes, slings, unstated

LIFT = unstated(bundled()["lift"].read_text())
ROUNDING = 1e-12


@pytest.mark.parametrize(
    ("a", "b", "inside"),
    [
        ((0.0, 0.0, 9.0), (0.0, 0.0, -9.0), 6.0),  # through the middle
        ((0.0, 0.0, 9.0), (0.0, 0.0, 0.0), 3.0),  # ends inside
        ((1.5, 0.0, 9.0), (1.5, 0.0, -9.0), 0.0),  # beside it
        ((1.0, 0.0, 9.0), (1.0, 0.0, -9.0), 0.0),  # along a face
        ((-2.0, 0.0, 1.0), (0.0, 2.0, 1.0), 0.0),  # past an edge
        ((-2.0, -2.0, 0.0), (2.0, 2.0, 0.0), 2 * 2**0.5),  # across
    ],
)
def test_a_straight_line_through_a_box_is_detected(
    a: tuple[float, float, float], b: tuple[float, float, float], inside: float
) -> None:
    assert passes_through(a, b, (1.0, 1.0, 3.0)) == pytest.approx(inside, abs=ROUNDING)
    assert passes_through(b, a, (1.0, 1.0, 3.0)) == pytest.approx(inside, abs=ROUNDING)


@pytest.mark.parametrize("face", [-5.0, -4.3, -16.0])
def test_a_sling_through_the_block_to_a_lug_below_is_refused_with_its_line_in_the_scene(face: float) -> None:
    text = LIFT.replace("R1: [-2 m, 6 m, 4.3 m]", f"R1: [-2 m, 6 m, {face} m]")
    text = text.replace("R2: [2 m, 6 m, 4.3 m]", f"R2: [2 m, 6 m, {face} m]")
    with pytest.raises(SceneError) as error:
        parse(text.replace("H3, sling: 10 m", "H3, sling: 30 m"), "deep.yaml")
    assert "deep.yaml:31:32" in str(error.value)
    assert "loader-3.sling-1 would go through 8 m of the block on its straight way to the lug R1" in str(error.value)


def test_a_sling_that_passes_the_end_wall_of_a_block_without_touching_is_accepted() -> None:
    load("turnover")
    text = LIFT.replace("R1: [-2 m, 6 m, 4.3 m]", "R1: [-2 m, 8.3 m, -3 m]")
    text = text.replace("R2: [2 m, 6 m, 4.3 m]", "R2: [2 m, 8.3 m, -3 m]").replace("H3, sling: 10 m", "H3, sling: 18 m")
    parse(text)


def test_a_rope_that_begins_overloaded_is_refused_with_its_tension() -> None:
    heavy = LIFT.replace("H1, sling: 10 m", "H1, upper mass: 500 t, sling: 10 m")
    with pytest.raises(
        SceneError, match=r"lift.yaml:29:16: .*the rope crane.H1 begins stretched with 5247 kN, rated for"
    ):
        parse(heavy, "lift.yaml")


def test_a_sling_without_slack_hangs_from_the_stretched_rope() -> None:
    built = parse(LIFT.replace("slack: 50 mm", "slack: 0 mm")).plan
    assert slings(built)["loader-1.sling-1"][0].lug == "P1"
    with pytest.raises(SceneError, match="is 31 mm too short for the lug P1"):
        parse(LIFT.replace("H1, sling: 10 m", "H1, rope: 78.65 m, sling: 10 m"))


def test_a_short_sling_that_begins_beyond_its_rated_tension_is_refused() -> None:
    """4 mm are little for 10 m of sling and far too much for half a metre."""
    scene = LIFT.replace("H1, sling: 10 m", "H1, sling: 0.5 m")
    rope = hook_ropes(parse(scene).plan)["crane.H1"]
    text = scene.replace("H1, sling", f"H1, rope: {rope.L0 - 0.054:.6f} m, sling")
    with pytest.raises(
        SceneError, match=r"loader-1.sling-1 begins stretched by 4.01 mm with 35\d\d kN, rated for 1286 kN"
    ):
        parse(text)


def test_a_mechanism_rope_of_impossible_strength_is_refused() -> None:
    text = """
heavylift: 1
name: hanging
end: 1 s
mechanism:
  bodies: {load: {mass: 1 t}}
  joints: {slide: {type: prismatic, child: load, axis: [0, 0, 1], start: 5 m}}
  ropes: {r: {start: {body: world, at: [0, 0, 10 m]}, end: {body: load}, EA: 100 MN, length: LENGTH}}
"""
    parse(text.replace("LENGTH", "4.95 m"))
    with pytest.raises(
        SceneError, match=r"the rope begins stretched by 5\.3% with 5263 kN, where wire ropes break at 2%"
    ):
        parse(text.replace("LENGTH", "4.75 m"))
    parse(text.replace("LENGTH", "4.75 m").replace("100 MN", "10 kN"))


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("P1: [-8 m, -6 m, 4.3 m]", "P1: [-8 m, -6 m, 5.2 m]", "the lug P1 is 1.2 m away from the block"),
        ("R1: [-2 m, 6 m, 4.3 m]", "R1: [-2 m, 9.5 m, 4.8 m]", "the lug R1 is 1.7 m away from the block"),
        ("size: [20 m, 16 m, 8 m]", "com: [0 m, 0 m, 30 m]\n  size: [20 m, 16 m, 8 m]", "is 26 m outside the block"),
        ("size: [20 m, 16 m, 8 m]", "com: [0 m, 0 m, -4.5 m]\n  size: [20 m, 16 m, 8 m]", "is 0.5 m outside the block"),
    ],
)
def test_lugs_and_centres_of_mass_off_the_block_give_a_red_finding_with_their_line_in_the_scene(
    old: str, new: str, told: str
) -> None:
    text = LIFT.replace(old, new).replace("slack: 50 mm", "slack: 1.5 m").replace("sling: 10 m", "sling: 12 m")
    scene = parse(text)
    (found,) = geometry_findings(scene.plan)
    assert (found.word, found.quantity) == ("red", "geometry")
    assert told in found.sentence
    wanted = "com:" if "com:" in new else new.partition(":")[0] + ":"
    line = int(found.where.split(":")[1])
    assert found.where.startswith("scene.yaml:")
    assert wanted in text.splitlines()[line - 1], "the line at which the place itself is written"
    assert found in scene.findings, "check tells it"


def test_bundled_lifts_have_their_lugs_on_their_blocks() -> None:
    for name in ("lift", "tandem", "turnover"):
        assert geometry_findings(load(name).plan) == []
    assert outside((1.0, 1.0, 1.0), (4.0, 5.0, 0.0)) == 5.0
