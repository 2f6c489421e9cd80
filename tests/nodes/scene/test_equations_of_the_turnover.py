"""The printed equations of the scene `turnover` include every body, rope and pad under its own name."""

from heavylift.kernel.equations import equations
from heavylift.nodes.models import system
from heavylift.nodes.scene import load

READABLE = 8000  # signs of the longest line


def test_every_body_and_law_of_the_scene_turnover_is_printed_once() -> None:
    turnover = system(load("turnover", []).plan)
    text = equations(turnover)
    coordinates = text[text.index("IN COORDINATES") :]
    left = [line.split(" = ")[0].strip() for line in coordinates.splitlines() if line.startswith("  ")]
    assert len(left) == len(set(left))
    for rope in turnover.ropes:
        assert f"T({rope.name})" in left
    for body in turnover.bodies:
        assert f"f({body.name}).z" in left
    for pad in turnover.supports:
        assert f"N({pad.name})" in left
    for drive in turnover.drives:
        assert f"tau({drive.name})" in left
    assert max(map(len, text.splitlines())) < READABLE
