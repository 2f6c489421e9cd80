"""Lifting frames are type files: the bundled one under other names, and ones of a user."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from heavylift import simulate
from heavylift.kernel import SceneError
from heavylift.nodes.scene import load, parse, uncertain_inputs
from heavylift.nodes.scene.inputs import inputs
from heavylift.nodes.scenes import bundled, frames_folder
from lifting import unstated

LIFT = unstated(bundled()["lift"].read_text())
LOADER = (frames_folder() / "block-loader.yaml").read_text()
FOUR = """
frame type: 1
name: four-slings
parameters: {mass: 12 t, wide: 4 m, deep: 2 m}
eye: {body: beam, apart: 2 m}
slings:
  - {body: beam, at: [=-wide/2, 1 m, =-deep]}
  - {body: beam, at: [=wide/2, 1 m, =-deep]}
  - {body: beam, at: [=wide/2, -1 m, =-deep]}
  - {body: beam, at: [=-wide/2, -1 m, =-deep]}
bodies: {beam: {mass: =mass, com: [0 m, 0 m, =-deep/2], box: [=wide, 2 m, =deep]}}
"""
HUNG = """
heavylift: 1
name: four
block:
  mass: 120 t
  size: [10 m, 8 m, 4 m]
  at: [34 m, 70 m, 3 m]
  lugs: {P: [-2 m, 1 m, 2.3 m], Q: [2 m, 1 m, 2.3 m], R: [2 m, -1 m, 2.3 m], S: [-2 m, -1 m, 2.3 m]}
  supports: {height: 1 m, at: [[-3 m, -3 m], [3 m, -3 m], [-3 m, 3 m], [3 m, 3 m]]}
cranes: {west: {type: goliath-900, at: 40 m}}
rig: {slack: 0.1 m, loaders: {one: {type: four.yaml, hook: west H1, sling: 8 m, lugs: [P, Q, R, S], mass: 14 t}}}
actions:
  - all hooks: hoist 0.3 m/min until all slings taut
  - all hooks: hoist 0.3 m/min until lifted
  - stage: up
    all hooks: hoist 1 m/min by 1 m
  - stage: down
    all hooks: lower 1 m/min until landed
  - all hooks: lower 0.3 m/min until all slings slack
  - all hooks: unhook
  - all hooks: hoist 1 m/min by 1 m
"""


def written(folder: Path, text: str, **files: str) -> Path:
    for name, data in files.items():
        (folder / f"{name}.yaml").write_text(data)
    (folder / "scene.yaml").write_text(text)
    return folder / "scene.yaml"


def test_the_bundled_frame_type_under_other_names_gives_the_same_lift(tmp_path: Path) -> None:
    names = {"upper": "yoke", "lower": "traverse", "hinge": "pin", "hinge.damper": "oil", "hinge.lock": "pawl"}
    own = LOADER
    for old in reversed(names):  # the longer ones first; parameters keep theirs
        own = re.sub(rf"(?<![=-])(?<!- )\b{re.escape(old)}(?=[:,}}\]](?! \d))", names[old], own)
    scene = load(written(tmp_path, LIFT.replace("{hook: crane", "{type: yoke.yaml, hook: crane"), yoke=own))
    plain = load("lift")
    a, b = simulate(plain), simulate(scene)
    assert a["rope/tension"].values.tobytes() == b["rope/tension"].values.tobytes()
    for old, new in (("upper", "yoke"), ("lower", "traverse")):
        assert a[f"pose/loader-1.{old}"].values.tobytes() == b[f"pose/loader-1.{new}"].values.tobytes()
    assert [x.sentence for x in a.verdict.findings] == [x.sentence for x in b.verdict.findings]


def test_a_lifting_frame_of_one_body_with_four_slings_lifts_and_sets_down_and_unhooks(tmp_path: Path) -> None:
    scene = load(written(tmp_path, HUNG, four=FOUR))
    (machine,) = (m for m in scene.plan.machines if m.name == "one")
    assert [body.mass for body in machine.system.bodies] == [14e3 + 25e3], "with the hook block"
    assert not machine.latches
    result = simulate(scene)
    tension = result["rope/tension"]
    up = next(stage.end for stage in result.stages if stage.name == "up")
    i = int(np.searchsorted(tension.t, up))
    slings = np.array([tension[f"one.sling-{i}"] for i in (1, 2, 3, 4)])
    assert slings[:, i] == pytest.approx(120e3 * 9.80665 / 4, rel=0.02)
    assert not slings[:, -1].any()
    assert tension["west.H1"][-1] == pytest.approx(39e3 * 9.80665, rel=0.02)


def test_parameters_of_a_frame_type_are_inputs(tmp_path: Path) -> None:
    scene = load(written(tmp_path, HUNG.replace("mass: 14 t", "mass: 14 t +- 1 t"), four=FOUR))
    (one,) = uncertain_inputs(scene)
    assert (one.name, one.value, one.half) == ("rig.loaders.one.mass", 14e3, pytest.approx(1e3))
    (other,) = inputs(scene, ["rig.loaders.one.deep"])
    assert other.value == 2.0
    heavier = load(written(tmp_path, HUNG, four=FOUR), ["rig.loaders.one.mass=20 t"])
    assert next(m for m in heavier.plan.machines if m.name == "one").system.bodies[0].mass == 45e3


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("type: four.yaml", "type: goliath-900", "'goliath-900' is not known here"),
        ("type: four.yaml", "type: none.yaml", "the type file 'none.yaml' cannot be read"),
        (
            "type: four.yaml",
            "type: jib.yaml",
            "'jib.yaml' is not a frame type: such a file begins with 'frame type: 1'",
        ),
        ("type: four.yaml", "type: [four.yaml]", "the name of a type is needed here, or of a file of one"),
        ("mass: 14 t", "parts: {}", "unknown key 'parts'"),
        ("mass: 14 t", "masses: 14 t", "unknown key 'masses'"),
        ("mass: 14 t", "mass: 14 m", "'14 m' does not fit"),
        ("lugs: [P, Q, R, S]", "lugs: [P, Q]", "4 slings hang on it: name a lug for each of them"),
        ("mass: 14 t", "mass: -14 t", "must be"),
        ("sling: 8 m", "sling: 300 m", "m too long for the height of the crane above the block"),
    ],
)
def test_faults_of_a_lifting_frame_in_a_scene_are_reported_in_one_sentence(
    tmp_path: Path, old: str, new: str, told: str
) -> None:
    path = written(tmp_path, HUNG.replace(old, new, 1), four=FOUR, jib="machine type: 1\n")
    with pytest.raises(SceneError) as caught:
        load(path)
    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("eye: {body: beam,", "eye: {body: bean,", "there is no body 'bean'"),
        ("box: [=wide, 2 m, =deep]}}", "box: [=wide, 2 m, =deep]}}\nlocked while empty: [pawl]", "no brake 'pawl'"),
        ("bodies: {", "bodies: {spare: {mass: 1 t}, ", "no joint carries the body 'one.spare'"),
    ],
)
def test_faults_of_a_lifting_frame_type_are_reported_in_one_sentence(
    tmp_path: Path, old: str, new: str, told: str
) -> None:
    with pytest.raises(SceneError) as caught:
        load(written(tmp_path, HUNG, four=FOUR.replace(old, new)))
    assert told in str(caught.value)


def test_a_lifting_frame_without_a_stated_type_has_the_bundled_type() -> None:
    named = parse(LIFT.replace("{hook: crane", "{type: block-loader, hook: crane"), "lift.yaml")
    assert [x.system for x in named.plan.machines] == [x.system for x in parse(LIFT, "lift.yaml").plan.machines]
