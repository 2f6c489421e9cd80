"""`floor:` and `obstacles:`: blocks stop at contact, and each scene has the contacts of its bodies."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.kernel import SceneError
from heavylift.kernel.description import Ball, Box, Plane
from heavylift.nodes.models import system
from heavylift.nodes.scene import parse
from heavylift.recordings import Recording

BLOCK = """
  mass: 60 t
  size: [6 m, 4 m, 3 m]
  at: [0 m, %g m, 2 m]
  lugs: {N1: [0 m, 0 m, 1.6 m]}
  supports: {height: 0.5 m, at: [[-2 m, -1.5 m], [2 m, -1.5 m], [-2 m, 1.5 m], [2 m, 1.5 m]], friction: 0, damping: 0}
"""
PUSHED = f"""
heavylift: 1
name: wall
end: 2 s
samples: 20 Hz
accuracy: 0.01 %
block: {BLOCK % 0.0}
mechanism:
  name: winch
  forces: {{push: {{type: load, body: block, force: [0 N, 30 kN, 0 N]}}}}
obstacles:
  wall: {{box: [10 m, 1 m, 4 m], at: [0 m, 2.75 m, 2 m], meets: corners}}
"""
TWO = f"""
heavylift: 1
name: two
end: 1 s
blocks:
  left: {(BLOCK % 0.0).replace(chr(10), chr(10) + "  ")}
  right: {(BLOCK % 9.0).replace(chr(10), chr(10) + "  ")}
floor: {{height: -1 m, friction: 0.3}}
"""


def test_a_block_pushed_against_a_wall_stops_there(tmp_path: Path) -> None:
    """30 kN on 60 t take it over a gap of 0.25 m in 1 s; then the wall holds what pushes."""
    run(parse(PUSHED), tmp_path / "wall.mcap", in_process=True)
    recording = Recording(tmp_path / "wall.mcap")
    y, force = recording["pose/block"], recording["contact/force"]
    assert y.values[:, 1] == pytest.approx(np.minimum(0.25 * y.t**2, 0.25), abs=2e-3)
    assert np.mean(force.values[force.t > 1.5].sum(axis=1)) == pytest.approx(30e3, rel=0.02)


def test_every_block_contacts_the_floor_and_every_other_block() -> None:
    """Of two blocks: each with the floor, and one pair."""
    contacts = {c.name: c for c in system(parse(TWO).plan).contacts}
    assert set(contacts) == {"left-floor", "right-floor", "left-right"}
    assert contacts["left-floor"].b == Plane("world", (0.0, 0.0, -1.0))
    assert contacts["left-right"].a == Box("left", (6.0, 4.0, 3.0))
    assert contacts["right-floor"].mu == 0.3


@pytest.mark.parametrize(("meets", "corners"), [("corners", 8), ("lower corners", 4)])
def test_corners_of_a_tilted_block_touch_an_obstacle_one_after_another(meets: str, corners: int) -> None:
    """Points at half the edges of the block; lower ones at its lower face only."""
    text = PUSHED.replace("meets: corners", f"meets: {meets}")
    contacts = system(parse(text).plan).contacts
    balls = [c.a for c in contacts if isinstance(c.a, Ball)]
    assert len(contacts) == len(balls) == corners
    assert {tuple(map(abs, ball.p)) for ball in balls} == {(3.0, 2.0, 1.5)}
    assert sum(ball.p[2] < 0.0 for ball in balls) == 4


def test_obstacles_on_a_vessel_move_with_it() -> None:
    """Its foot is fixed on the vessel; a wrong name is asked back, as is a scene without a block."""
    vessel = "vessels: {barge: {mass: 9000 t, size: [90 m, 30 m, 6 m], draught: 3 m, responses: {}}}\n"
    on = PUSHED.replace("meets: corners}", "on: barge}") + vessel
    foot = next(j for j in system(parse(on).plan).joints if j.name == "wall.foot")
    assert (foot.kind, foot.parent, foot.p_PJ) == ("fixed", "barge", (0.0, 2.75, 2.0))
    with pytest.raises(SceneError, match=r"obstacles\.wall\.on: there is no vessel 'bargee'"):
        parse(on.replace("on: barge", "on: bargee"))
    with pytest.raises(SceneError, match="there is no block that could meet it"):
        parse("heavylift: 1\nname: bare\nend: 1 s\nfloor: {}\n" + vessel)


@pytest.mark.parametrize("meets", ["boxes", "corners", "lower corners"])
@pytest.mark.parametrize("deep", [1e-5, 0.25, 2.0])
def test_a_block_that_starts_inside_an_obstacle_is_refused(meets: str, deep: float) -> None:
    """Its face lies 2 m from its middle, the wall's 0.5 m; a wall within the block is met by no corner."""
    wall = PUSHED.replace("2.75 m, 2 m], meets: corners", f"{2.5 - deep:.6f} m, 2 m], meets: {meets}")
    if meets == "boxes" or deep < 1.0:
        with pytest.raises(SceneError, match=rf"scene\.yaml:18:.*'block' begins {deep:g} m inside of 'wall'"):
            parse(wall)
    else:
        parse(wall)
    parse(wall.replace(f"{2.5 - deep:.6f} m", "2.5 m"))


def test_a_block_that_starts_inside_the_floor_or_another_block_is_refused() -> None:
    with pytest.raises(SceneError, match=r"scene\.yaml:20:.*inside of the floor"):
        parse(TWO.replace("height: -1 m", "height: 0.7 m"))
    with pytest.raises(SceneError, match=r"scene\.yaml:13:.*'left' begins 0.5 m inside of 'right'"):
        parse(TWO.replace("[0 m, 9 m, 2 m]", "[0 m, 3.5 m, 2 m]"))
