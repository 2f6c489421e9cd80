"""Rigid contacts from the scene file to the recording: a crate on a ramp, in processes as in one."""

from math import asin, cos, sin
from pathlib import Path

import numpy as np
import pytest
from chain import channel, play
from heavylift.kernel import SceneError
from heavylift.kernel.description import Ball, Box, Contact, Plane
from heavylift.nodes.scene import load

G = 9.80665
LEAN = asin(0.6)  # rad

SCENE = """\
heavylift: 1
name: ramp
accuracy: 1e-4 %
samples: 50 Hz
end: 2 s
mechanism:
  bodies:
    crate: {mass: 4 t, inertia: [5 t m2, 5 t m2, 5 t m2]}
  joints:
    float: {type: free, child: crate, at: [0.6 m, 0, 0.8 m], attitude: [0, 0.316227766016838, 0, 0.948683298050514]}
  contacts:
    ramp: {body: crate, box: [2 m, 3 m, 2 m], against: {normal: [0.6, 0, 0.8]}, friction: 0.5, restitution: 10 %}
"""


def written(folder: Path, *changes: tuple[str, str]) -> Path:
    text = SCENE
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    path = folder / "ramp.yaml"
    path.write_text(text)
    return path


def test_a_crate_slides_down_its_ramp(tmp_path: Path) -> None:
    one, many = (play(tmp_path, SCENE, in_process=here) for here in (True, False))
    assert one.result["digest"] == many.result["digest"]
    t, x = channel(one, "pose/crate", "x")
    a = G * (sin(LEAN) - 0.5 * cos(LEAN))
    assert x - x[0] == pytest.approx(0.8 * a * t * t / 2, abs=1e-6)
    _, force = channel(one, "contact/force", "ramp")
    assert force == pytest.approx(np.full(len(force), 4000.0 * G * 0.8), rel=1e-6)


def test_contacts_can_be_written_as_boxes_balls_points_and_planes(tmp_path: Path) -> None:
    lid = "{body: lid, box: [1 m, 1 m, 1 m]}"
    more = f"  contacts:\n    top: {{body: crate, radius: 20 cm, at: [0, 0, 2 m], against: {lid}}}\n"
    bodies = "    lid: {mass: 1 t, inertia: [1 t m2, 1 t m2, 1 t m2]}\n  joints:\n"
    bodies += "    up: {type: free, child: lid, at: [0, 0, 9 m]}\n"
    path = written(tmp_path, ("  joints:\n", bodies), ("  contacts:\n", more))
    contacts = load(str(path)).plan.machines[0].system.contacts
    assert contacts == (
        Contact("ramp", Box("crate", (2.0, 3.0, 2.0)), Plane("world", normal=(0.6, 0.0, 0.8)), 0.5, 0.1),
        Contact("top", Ball("crate", (0.0, 0.0, 2.0), 0.2), Box("lid", (1.0, 1.0, 1.0))),
    )


MISTAKES = [
    (("body: crate, box", "body: crat, box"), "there is no body 'crat'"),
    (("friction: 0.5", "friction: 5 m"), "ramp.yaml:12"),
    (("restitution: 10 %", "restitution: 110 %"), "restitution is 1.1; it must lie between 0 and 1"),
    (("[0.6, 0, 0.8]}", "[0, 0, 0]}"), "the normal of its plane is zero"),
    (("box: [2 m, 3 m, 2 m]", "box: [2 m, 3 m]"), "ramp.yaml:12"),
]


@pytest.mark.parametrize(("change", "words"), MISTAKES, ids=[w for _, w in MISTAKES])
def test_mistakes_in_contacts_are_reported_with_their_line_in_the_scene(
    tmp_path: Path, change: tuple[str, str], words: str
) -> None:
    with pytest.raises(SceneError) as e:
        load(str(written(tmp_path, change)))
    assert words in str(e.value)
    assert "ramp.yaml:12" in str(e.value)
