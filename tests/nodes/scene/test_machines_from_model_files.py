"""`from: robot.urdf` and `from: model.xml` of a machine: the parts are those that MuJoCo reads."""

from dataclasses import replace
from pathlib import Path

import heavylift
import mujoco
import numpy as np
import pytest
from heavylift import from_mujoco
from heavylift.kernel import SceneError
from heavylift.kernel.description import System
from heavylift.kernel.multibody import build_graph
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.plan import Mechanism
from heavylift.nodes.scene import load, restored

SCENE = "heavylift: 1\nname: robot\nend: 0.5 s\n"
MACHINE = SCENE + "machines:\n  arm:\n    from: {}\n"
ROUNDING = 1e-9  # relative: rotations are written as three angles
CORNERS = 0.3  # [m] by which rays at random miss the corners of a shape of 5 m


def written(folder: Path, model: str, scene: str = MACHINE, name: str = "model.xml") -> Path:
    (folder / name).write_text(model)
    file = folder / "scene.yaml"
    file.write_text(scene.format(name))
    return file


def machine(scene: Path, *settings: str) -> Mechanism:
    return load(scene, settings).plan.machines[0]


def accelerations(system: System, seed: int, base: int = 0) -> np.ndarray:
    """At random velocities; `base`: how many joints of the system come before the first one of the model."""
    graph = build_graph(system)
    speeds = np.random.default_rng(seed).normal(size=graph.nv)
    at = {k.joint.name: replace(k.joint, v0=tuple(speeds[k.v])) for k in graph.links}
    simulation = Simulation(replace(system, joints=tuple(at[j.name] for j in system.joints)))
    simulation.start()
    p = simulation.program
    return simulation.native.part("f")[p.nq : p.nq + p.nv].copy()


def random_tree(seed: int) -> str:
    """Bodies on hinges, slides, balls and a free joint, askew, with springs, dampers, limits, motors, ropes, struts."""
    r = np.random.default_rng(seed)

    def n(size: int) -> str:
        return " ".join(f"{x:.9g}" for x in r.normal(size=size))

    def body(i: int) -> str:
        kind = "free" if i == 0 and seed % 2 else ["hinge", "slide", "ball"][int(r.integers(3))]
        only = kind in ("hinge", "slide")
        more = f'axis="{n(3)}" stiffness="{r.uniform(0, 9):.5f}" damping="{r.uniform():.5f}"' if only else ""
        place = f'pos="{n(3)}"' if kind != "free" else ""
        joint = f'<joint name="j/{i}" type="{kind}" {place} {more}/>'
        a, b, c = np.sort(r.uniform(0.5, 1.0, 3))
        inertial = f'<inertial pos="{n(3)}" quat="{n(4)}" mass="{r.uniform(0.5, 4):.5f}" diaginertia="{a} {b} {c}"/>'
        inner = "".join(body(2 * i + k) for k in (1, 2) if i < 3)
        site = f'<site name="s{i}" pos="{n(3)}"/>'
        return f'<body name="b/{i}" pos="{n(3)}" quat="{n(4)}">{joint}{inertial}{site}{inner}</body>'

    world = body(0)
    through = "".join(f'<site site="s{i}"/>' for i in r.permutation(7)[:4])
    ends = "".join(f'<site site="s{i}"/>' for i in r.permutation(7)[:2])
    return (
        f'<mujoco><option gravity="0 0 -9.80665"/><worldbody>{world}</worldbody><tendon>'
        f'<spatial name="rope" stiffness="{r.uniform(1, 5):.5f}" springlength="0 0.3">{through}</spatial>'
        f'<spatial name="strut" stiffness="3" damping="0.2" springlength="0.7">{ends}</spatial></tendon></mujoco>'
    )


@pytest.mark.parametrize("seed", range(6))
def test_a_machine_from_a_model_file_has_the_accelerations_of_the_imported_system(seed, tmp_path):
    scene = written(tmp_path, random_tree(seed))
    ours, theirs = machine(scene).system, from_mujoco(tmp_path / "model.xml").system
    want = accelerations(theirs, seed)
    assert accelerations(ours, seed) == pytest.approx(want, abs=ROUNDING * np.abs(want).max())


URDF = """<robot name="arm"><link name="base"/>
<link name="upper"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/>
<inertia ixx=".2" iyy=".2" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><box size="0.2 0.2 1"/></geometry></collision></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="1" velocity="1"/></joint></robot>
"""


def test_the_scene_may_move_and_extend_a_machine_that_is_read_from_a_urdf_file(tmp_path):
    more = (
        "    joints: {{arm.base: {{at: [4 m, 0 m, 3 m]}}, arm.shoulder: {{start: 0.3 rad}}}}\n"
        "    drives: {{arm.turn: {{joint: arm.shoulder, type: prescribed, ramp: 1 rad/s2}}}}\n"
        "actions:\n  - arm.turn: drive 1 rad/s by 0.2 rad\n"
    )
    scene = written(tmp_path, URDF, MACHINE + more, "arm.urdf")
    result = heavylift.simulate(load(scene, "end=2 s"))
    assert result["joint/position"]["arm.shoulder.angle"][-1] == pytest.approx(0.5, abs=1e-6)
    assert result["pose/arm.upper"]["z"] == pytest.approx(3.0)
    assert result["pose/arm.upper"]["x"] == pytest.approx(4.0)


def test_actuators_with_feedback_in_a_model_file_become_drives_and_others_become_forces(tmp_path):
    model = """<mujoco><option gravity="0 0 -9.80665"/><worldbody><body name="b"><joint name="j" axis="0 1 0"/>
    <inertial pos="0 0 -1" mass="2" diaginertia="1 1 1"/><body name="c" pos="0 0 -2"><joint name="k" type="slide"/>
    <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></body></worldbody>
    <actuator><position name="j" joint="j" kp="30" kv="4"/><velocity name="v" joint="k" kv="7" gear="2"/>
    <motor name="k" joint="k" gear="3"/></actuator></mujoco>"""
    made = machine(written(tmp_path, model), "machines.arm.forces.arm.k-force.factor=2")
    hold, speed = made.system.drives
    assert (hold.name, hold.kind, hold.kp, hold.kv) == ("arm.j-drive", "servo", 30.0, 4.0)
    assert (speed.name, speed.kind, speed.kv) == ("arm.v", "speed", 28.0)
    (push,) = made.system.forces
    assert (push.name, push.effort, push.signal.value) == ("arm.k-force", (3.0, 3.0), 2.0)
    text = [x.message for x in load(tmp_path / "scene.yaml").findings if x.quantity == "model file"]
    assert any("actuators without feedback are forces of factor 0" in x for x in text)


def test_rounding_residues_in_model_files_are_read_as_zero(tmp_path):
    model = """<mujoco><worldbody><body name="b" pos="0 1e-33 0"><joint name="j"/><inertial pos="0 0 3e-31" mass="1"
    diaginertia="1e-5 2e-5 2e-5" quat="1 1e-27 0 0"/></body></worldbody></mujoco>"""
    (body,) = (x for x in machine(written(tmp_path, model)).system.bodies if x.name == "arm.b")
    assert body.com == (0.0, 0.0, 0.0)
    assert body.inertia[1][2] == 0.0


def test_features_of_a_model_file_that_are_not_converted_are_listed_as_warnings_by_check(tmp_path):
    model = """<mujoco><option gravity="0 0 -1.62"/><worldbody><body name="b">
    <joint name="j" armature="0.1" axis="0 1 0"/><geom size="0.1" mass="1"/></body></worldbody></mujoco>"""
    warned = [x for x in load(written(tmp_path, model)).findings if x.quantity == "model file"]
    assert {(x.state, x.sentence, x.where) for x in warned} >= {
        ("amber", "not converted: joint 'j': armature", "scene.yaml:5:3"),
        ("amber", "not converted: 1 geoms that collide", "scene.yaml:5:3"),
        ("amber", "not converted: gravity of 1.62 m/s2: that of the scene acts, key `gravity`", "scene.yaml:5:3"),
    }


@pytest.mark.parametrize("seed", range(4))
def test_collision_boxes_of_an_imported_body_enclose_its_geoms_closely(seed, tmp_path):
    """Surface points of all shapes, by rays of MuJoCo from outside."""
    r = np.random.default_rng(seed)
    corners = r.normal(size=(30, 3))
    mesh = " ".join(f"{x:.5g}" for x in corners.ravel())
    kinds = ("sphere", "capsule", "ellipsoid", "cylinder", "box")
    kind = [*kinds, "mesh"][seed + 2] if seed + 2 < 6 else "mesh"
    own = f'type="{kind}" size="0.3 0.5 0.7"' if kind != "mesh" else 'type="mesh" mesh="m"'
    geom = f'<geom {own} pos="{r.normal():.4g} 0.2 0.3" quat="{r.normal():.4g} {r.normal():.4g} 0.3 0.2" mass="1"/>'
    model = f"""<mujoco><asset><mesh name="m" vertex="{mesh}"/></asset><worldbody>
    <body name="b"><freejoint/>{geom}</body></worldbody></mujoco>"""
    boxes = machine(written(tmp_path, model)).shapes
    m = mujoco.MjModel.from_xml_string(model)
    data = mujoco.MjData(m)
    mujoco.mj_forward(m, data)
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    centre = data.geom_xpos[0]
    for ray in r.normal(size=(4000, 3)):
        ray /= np.linalg.norm(ray)
        distance = mujoco.mj_ray(m, data, centre + 9.0 * ray, -ray, None, 1, -1, np.array([-1], dtype=np.int32))
        if distance < 0.0:
            continue
        p = centre + (9.0 - distance) * ray
        low, high = np.minimum(low, p), np.maximum(high, p)
        assert any((np.abs(p - box.centre) <= 0.5 * np.array(box.size) + 1e-6).all() for box in boxes)
    bounds = [[np.array(x.centre) + s * 0.5 * np.array(x.size) for x in boxes] for s in (-1.0, 1.0)]
    assert np.min(bounds[0], axis=0) == pytest.approx(low, abs=CORNERS)
    assert np.max(bounds[1], axis=0) == pytest.approx(high, abs=CORNERS)


def test_a_recorded_scene_runs_without_its_model_file(tmp_path):
    loaded = load(written(tmp_path, URDF, name="arm.urdf"))
    (tmp_path / "arm.urdf").unlink()
    again = restored(loaded.plan, loaded.text, loaded.merged, "scene.yaml")
    assert [*again.scene.machines["arm"].joints] == ["arm.base", "arm.shoulder"]


@pytest.mark.parametrize(
    ("model", "scene", "sentence"),
    [
        ("<mujoco><worldbody>", MACHINE, "model.xml:1:1: error: machines.arm.from: the file is not valid XML:"),
        ("<mujoco><worldbody>\n<bodi/></worldbody></mujoco>", MACHINE, "model.xml:2:1: error: machines.arm.from: XML"),
        ('<mujoco><include file="../other.xml"/></mujoco>', MACHINE, "'other.xml' is outside of the scene's folder"),
        ("<mujoco/>", SCENE + "machines: {{arm: {{from: model.txt}}}}\n", "'model.txt' is not a .urdf, .xml or .mjcf"),
        ("<mujoco/>", SCENE + "machines: {{arm: {{from: none.xml}}}}\n", "the model 'none.xml' cannot be read: No"),
        (
            '<mujoco>\n<worldbody>\n<body name="b"><joint name="slide" type="slide"/><geom size="1"/></body>\n'
            "</worldbody></mujoco>",
            MACHINE + "    joints: {{arm.slide: {{child: arm.c}}}}\n",
            "scene.yaml:7:",
        ),
        (
            '<mujoco>\n<worldbody>\n<body name="b"><joint name="slide" type="slide"/><geom size="1"/></body>\n'
            '</worldbody><actuator>\n <motor name="m" joint="slide"/></actuator></mujoco>',
            MACHINE + "    drives: {{arm.slide: {{joint: arm.slide, type: speed, ramp: 1 m/s2, damping: 1 N s/m}}}}\n",
            "the name 'arm.slide' is given twice",
        ),
    ],
)  # fmt: skip
def test_invalid_model_files_are_reported_with_file_and_line(model, scene, sentence, tmp_path):
    (tmp_path / "other.xml").write_text("<mujoco/>")
    (tmp_path / "in").mkdir()
    file = written(tmp_path / "in", model, scene)
    with pytest.raises(SceneError) as error:
        load(file)
    assert sentence.format(file=tmp_path / "in" / "model.xml") in str(error.value)


def test_a_fault_in_a_part_of_an_imported_machine_names_the_line_of_the_model_file(tmp_path):
    model = '<mujoco>\n<worldbody>\n<body name="b">\n <joint name="j"/><geom size="1"/></body></worldbody></mujoco>'
    scene = written(tmp_path, model, MACHINE + "    joints: {{arm.j: {{friction: {{travel: {{dry: 1 N}}}}}}}}\n")
    with pytest.raises(SceneError, match="has no coordinate 'travel'"):
        load(scene)
    with pytest.raises(SceneError, match=r"--set:1:19: .*name the model file in the scene"):
        load(scene, ["machines.arm.from=other.xml"])
    tendon = """<mujoco><worldbody><site name="s"/><body name="b"><joint name="j"/><geom size="1"/>
    <site name="t" pos="0 0 2"/></body></worldbody><tendon>
    <spatial name="wire" stiffness="1e9" springlength="0 1"><site site="s"/><site site="t"/></spatial></tendon>
    </mujoco>"""
    with pytest.raises(
        SceneError, match=r"model\.xml:3:5: error: machines\.arm\.ropes\.arm\.wire\.length: the rope begins"
    ):
        load(written(tmp_path, tendon))
