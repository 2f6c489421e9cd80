"""Beams, sliders and matrices in a scene file become flexible bodies; faults are reported at their place."""

from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel import SceneError
from heavylift.kernel.description import Beam, Flexible
from heavylift.kernel.multibody.flexible import beam_matrices, nodes_of
from heavylift.nodes.scene import load, parse

SCENE = """\
heavylift: 1
name: boom
end: 1 s
mechanism:
  bodies:
    boom:
      beam: {length: 30 m, mass per length: 0.2 t/m, EI y: 900 MN m2, EI z: 400 MN m2, modes: 4, loads: [30 m]}
    jib: {mass: 1 t, inertia: [1 t m2, 1 t m2, 1 t m2]}
    trolley: {mass: 2 t}
  joints:
    foot: {type: fixed, child: boom}
    tip: {type: fixed, parent: boom, child: jib, at: 30 m}
    rail: {type: slider, parent: boom, child: trolley, start: 10 m, speed: 6 m/min, at: [0, 0, -1 m]}
  ropes:
    stay: {start: {body: boom, at: 25 m}, end: {body: world, at: [0, 0, 20 m]}, EA: 100 MN, length: 40 m}
"""


def test_flexible_bodies_written_in_a_scene_reach_the_kernel_unchanged() -> None:
    system = parse(SCENE).plan.machines[0].system
    assert system.bodies[0].flexible == Flexible(4, Beam(30.0, 200.0, 9e8, 4e8), loads=(30.0,))
    assert (system.bodies[0].mass, system.bodies[1].flexible) == (0.0, None)
    rail, tip = system.joints[1:]
    assert (tip.p_PJ, rail.kind, rail.q0, rail.v0) == ((30.0, 0.0, 0.0), "slider", (10.0,), (0.1,))
    assert system.ropes[0].lines[0].a.p == (25.0, 0.0, 0.0)


@pytest.mark.parametrize("form", ["csv", "npz"])
def test_matrices_of_a_scene_are_read_from_files_in_the_folder_of_the_scene(tmp_path: Path, form: str) -> None:
    beam = Beam(30.0, 200.0, 9e8, elements=4)
    M, K = beam_matrices(beam)
    arrays = {"nodes": nodes_of(beam), "mass": M, "stiffness": K}
    files = {key: "boom.npz" if form == "npz" else f"{key}.csv" for key in arrays}
    np.savez(tmp_path / "boom.npz", **arrays)
    for key, array in arrays.items():
        np.savetxt(tmp_path / f"{key}.csv", array, delimiter=",", fmt="%.17g")
    held = [d for d in range(30) if d < 6 or d % 6 not in (2, 4)]
    keys = ", ".join(f"{key}: {file}" for key, file in files.items())
    lines = SCENE.splitlines()
    lines[6] = f"      matrices: {{{keys}, held: {held}, modes: 2}}"
    lines[12] = ""  # a slider needs a beam
    text = "\n".join(line for line in lines if "trolley" not in line).replace("25 m", "22.5 m")
    (tmp_path / "scene.yaml").write_text(text)
    flexible = load(tmp_path / "scene.yaml").plan.machines[0].system.bodies[0].flexible
    assert flexible is not None
    assert flexible.nodal is not None
    assert np.array_equal(np.array(flexible.nodal.mass), M)
    assert flexible.nodal.nodes[-1] == (30.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("mass per length: 0.2 t/m, ", "", "bodies.boom.beam: a beam has either 'mass' or 'mass per length'"),
        (
            "900 MN m2",
            "900 MN",
            "beam.EI y: '900 MN' is not a valid bending stiffness: 'MN' is a unit of force; use MN m2,",
        ),
        ("at: 30 m}", "at: 31 m}", "joints.tip.at: 31 m is not on the beam of 'boom', which reaches from 0 to 30 m"),
        ("start: 10 m", "start: -1 m", "joints.rail.start: -1 m is not on the beam of 'boom'"),
        (
            "parent: boom, child: trolley",
            "child: trolley",
            "a slider moves along a flexible beam, but 'world' has none",
        ),
        ("at: 25 m", "at: 35 m", "ropes.stay.start.at: 35 m is not on the beam of 'boom'"),
        ("loads: [30 m]", "loads: [40 m]", "boom.beam: body 'boom': a load at 40 m lies beyond its ends"),
        ("trolley: {mass: 2 t}", "trolley: {}", "bodies.trolley.mass: the key 'mass' is missing"),
        ("beam: {length: 30 m", "matrices: {nodes: n.txt", "'n.txt' is neither a .csv nor an .npz file"),
        (
            "jib: {mass: 1 t",
            "jib: {matrices: {nodes: n.csv, mass: m.csv, stiffness: k.csv}, mass: 1 t",
            "there is no file 'n.csv'",
        ),
    ],
)
def test_faults_of_flexible_bodies_are_reported_with_their_line_in_the_scene(old: str, new: str, told: str) -> None:
    assert old in SCENE
    with pytest.raises(SceneError) as e:
        parse(SCENE.replace(old, new))
    assert told in str(e.value)
    line = next(i for i, text in enumerate(SCENE.replace(old, new).splitlines(), 1) if new in text and (new or i == 7))
    assert f"scene.yaml:{line}:" in str(e.value) or f"scene.yaml:{line - 1}:" in str(e.value)
