"""Random closed loops with renamed joints are accepted or refused as before and move as before."""

import json
import re
from random import Random

import numpy as np
import pytest
from heavylift.coordinator.record import play
from heavylift.kernel import HeavyliftError
from heavylift.nodes.scene import parse

TURNS, SLIDES = ("revolute", "screw"), ("prismatic",)
KINDS = (*TURNS, *SLIDES, "universal", "constant-velocity", "spherical", "cylindrical", "planar")
APART = 1e-6  # [m or 1] of poses after END: the order of equations rounds differently
END = "0.2 s"


def joint(random, parent, child, place):
    """A joint of any kind, which fits where both bodies stand; some ask for another start."""
    kind, axis = random.choice(KINDS), random.choice([[1, 0, 0], [0, 1, 0], [0, 0, 1]])
    across, P = [axis[1], axis[2], axis[0]], [random.uniform(-2, 2) for _ in range(3)]
    at, at_child = ([f"{x - y:.6f} m" for x, y in zip(P, place[b], strict=True)] for b in (parent, child))
    message = {"type": kind, "child": child, "at": at, "at child": at_child}
    message |= {} if parent == "world" else {"parent": parent}
    directions = {"spherical": (), "constant-velocity": ("shaft", "bend axis"), "planar": ("normal",)}
    message |= dict(zip(directions.get(kind, ("axis", "second axis")), (axis, across), strict=False))
    if kind not in ("universal", "constant-velocity"):
        message.pop("second axis", None)
    if kind == "screw":
        message["lead"] = "0.2 m"
    if random.random() < 0.4:
        turn, slide = (f"{random.uniform(-5, 5):.1f} deg" for _ in range(2)), f"{random.uniform(-0.1, 0.1):.2f} m"
        if kind in TURNS or kind in SLIDES:
            message["start"] = slide if kind in SLIDES else next(turn)
        elif kind in ("universal", "constant-velocity"):
            message["start"] = list(turn)
    return message


def mechanism(random):
    """Bodies in a chain from the world that is closed by a last joint."""
    names = [f"body-{i}" for i in range(random.randint(2, 4))]
    place = {"world": [0.0, 0.0, 0.0], **{b: [random.uniform(-2, 2) for _ in range(3)] for b in names}}
    ends = [
        *zip(["world", *names], names, strict=False),
        (random.choice(["world", *names[: len(names) - 2]]), names[-1]),
    ]
    joints = [joint(random, parent, child, place) for parent, child in ends]
    return {b: {"mass": "10 kg", "inertia": ["1 kg m2"] * 3} for b in names}, joints


def answer(bodies, joints, names):
    """Last poses of a run, or the sentence that refuses the scene with the first names."""
    mechanism = {"bodies": bodies, "joints": dict(zip(names, joints, strict=True))}
    scene = json.dumps({"heavylift": 1, "name": "loop", "end": END, "mechanism": mechanism})
    try:
        run = play(parse(scene).plan)
    except HeavyliftError as error:
        at = {f"'{name}'": f"'{i}'" for i, name in enumerate(names)}
        return sorted(re.findall(r"[a-z]{3,}|'\d'", re.sub(r"'joint-\d'", lambda m: at[m[0]], str(error))))
    columns = [f"{c.topic}/{name}" for c in run.layout.channels for name in c.names]
    return run.rows[-1, [i for i, c in enumerate(columns) if c.startswith("pose/")]]


@pytest.mark.parametrize("seed", range(40))
@pytest.mark.large(beyond=8)
def test_renaming_joints_changes_no_result(seed):
    bodies, joints = mechanism(Random(seed))
    names = [f"joint-{i}" for i in range(len(joints))]
    first = answer(bodies, joints, names)
    for other in (names[::-1], Random(seed).sample(names, len(names))):
        found = answer(bodies, joints, other)
        assert isinstance(found, list) == isinstance(first, list), (first, found)
        if isinstance(first, list):
            assert found == first
        else:
            assert np.abs(found - first).max() < APART, [j["type"] for j in joints]
