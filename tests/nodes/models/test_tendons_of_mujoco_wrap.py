"""Tendons around cylinders and spheres: lengths and accelerations as in MuJoCo, in many poses."""

import mujoco
import numpy as np
import pytest
from heavylift import from_mujoco
from heavylift.kernel.forces.reeving import ReevingLaw
from mujoco_peer import accelerations, placed

G = '<option gravity="0 0 -9.80665"/><default><geom contype="0" conaffinity="0"/></default>'
WRAPPED = 1e-5  # [m] by which a rope is longer than the line between its ends; rounding is 1e-15
EXACT = 1e-9  # relative: both are closed forms of the pose


RANGES = 'limited="true" range="-35 52"'


def planar_arm(seed: int, limits: str = RANGES) -> str:
    """Two links in a plane askew, with ropes around cylinders and a sphere on them, past eyes and beside side sites."""
    r = np.random.default_rng(seed)
    turn = " ".join(f"{x:.6f}" for x in r.normal(size=4))
    R1, R2 = r.uniform(0.08, 0.12, 2)
    sphere = f'<geom name="knee" type="sphere" size="{R2:.6f}" mass="0"/>'
    pin = f'<geom name="knee" type="cylinder" size="{R2:.6f} .05" mass="0"/>'
    return f"""<mujoco>{G}<worldbody><body name="base" quat="{turn}">
    <site name="s0" pos="-0.3 0.02 0"/><site name="x0" pos="0 -0.25 0"/>
    <body name="upper"><joint name="hip" axis="0 0 1" {limits}/>
    <inertial pos="0.2 0 0" mass="2" diaginertia=".1 .1 .1"/>
    <geom name="hip" type="cylinder" size="{R1:.6f} .05" mass="0"/><site name="s1" pos="0.25 0.08 0"/>
    <site name="s2" pos="0.25 -0.08 0"/><site name="x1" pos="0.5 -0.2 0"/>
    <body name="lower" pos="0.5 0 0"><joint name="knee" axis="0 0 1" {limits}/>
    <inertial pos="0.2 0 0" mass="1" diaginertia=".1 .1 .1"/>{sphere if seed % 2 else pin}
    <site name="s3" pos="0.3 {0.06 + 0.01 * r.random():.6f} 0"/><site name="s4" pos="0.3 -0.06 0"/></body></body>
    </body></worldbody><tendon>
    <spatial name="flexes" stiffness="300" springlength="0 0.2"><site site="s0"/><geom geom="hip" sidesite="x0"/>
    <site site="s2"/></spatial>
    <spatial name="both" stiffness="200" springlength="0 0.3"><site site="s0"/><geom geom="hip" sidesite="x0"/>
    <site site="s2"/><geom geom="knee" sidesite="x1"/><site site="s4"/></spatial>
    </tendon></mujoco>"""


SLIDES = "".join(
    f'<joint type="slide" axis="{axis}" limited="true" range="-{most} {most}"/>'
    for axis, most in (("1 0 0", 0.1), ("0 1 0", 0.2), ("0 0 1", 0.05))
)


def around_a_cylinder(seed: int, joints: str = SLIDES) -> str:
    """A body that hangs on a rope across a cylinder askew: the rope slides along it in a helix."""
    r = np.random.default_rng(seed)
    axis = " ".join(f"{x:.5f}" for x in (0.05 * r.normal(), 1.0, 0.05 * r.normal()))
    return f"""<mujoco>{G}<worldbody><site name="a" pos="-0.5 {0.1 * r.normal():.5f} 0"/>
    <geom name="pin" type="cylinder" size="{r.uniform(0.05, 0.1):.5f} .2" zaxis="{axis}" pos="0 0 -0.13"/>
    <body name="load" pos="0.5 {0.3 * r.normal():.5f} -0.2">{joints}
    <inertial pos="0 0 0" mass="3" diaginertia=".1 .2 .3"/><site name="b" pos="0.01 0.02 0.05"/></body></worldbody>
    <tendon><spatial name="rope" stiffness="500" springlength="0 0.5"><site site="a"/>
    <geom geom="pin"/><site site="b"/></spatial></tendon></mujoco>"""


@pytest.mark.parametrize("seed", range(4))
def test_tendons_around_geoms_in_a_plane_have_mujocos_accelerations(seed, tmp_path):
    file = tmp_path / "arm.xml"
    file.write_text(planar_arm(seed))
    found = from_mujoco(file)
    assert [f.name for f in found.system.reevings] == ["flexes", "both"]
    assert found.missing == []
    model = mujoco.MjModel.from_xml_path(str(file))
    data, r = mujoco.MjData(model), np.random.default_rng(seed)
    for _ in range(5):
        data.qpos[:], data.qvel[:] = r.uniform(-0.6, 0.9, 2), r.normal(size=2)
        mujoco.mj_forward(model, data)
        ours = accelerations(placed(found.system, data.qpos, data.qvel, {}))
        assert ours == pytest.approx(data.qacc, rel=1e-7, abs=1e-7)


@pytest.mark.parametrize("seed", range(4))
def test_a_tendon_that_slides_along_a_cylinder_has_the_length_that_mujoco_computes(seed, tmp_path):
    file = tmp_path / "load.xml"
    file.write_text(around_a_cylinder(seed))
    found = from_mujoco(file)
    (rope,) = found.system.reevings
    assert rope.edges
    model = mujoco.MjModel.from_xml_path(str(file))
    data, r, more = mujoco.MjData(model), np.random.default_rng(seed), []
    for _ in range(20):
        data.qpos[:] = r.uniform(*model.jnt_range.T)
        mujoco.mj_forward(model, data)
        poses = {"world": (np.eye(3), np.zeros(3)), "load": (data.xmat[1].reshape(3, 3), data.xpos[1])}
        length = ReevingLaw().start_length(rope, poses.__getitem__)
        assert length == pytest.approx(data.ten_length[0], rel=EXACT)
        more.append(length - np.linalg.norm(data.site_xpos[1] - data.site_xpos[0]))
    assert max(more) > WRAPPED


INSIDE = f"""<mujoco>{G}<worldbody><site name="a" pos="0 0.3 0"/><geom name="ring" type="cylinder" size="0.2 0.1"/>
<site name="side" pos="0.05 0 0"/><body name="b"><joint type="slide" axis="0 1 0"/>
<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><site name="b" pos="0.01 -0.3 0"/></body></worldbody>
<tendon><spatial name="t" stiffness="1" springlength="0 0.1"><site site="a"/><geom geom="ring" sidesite="side"/>
<site site="b"/></spatial></tendon></mujoco>"""
SPACE = f"""<mujoco>{G}<worldbody><site name="a" pos="0.05 0.3 0"/><geom name="ball" type="sphere" size="0.2"/>
<body name="b"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><site name="b" pos="0.05 -0.3 0"/></body>
</worldbody><tendon><spatial name="t" stiffness="1" springlength="0 0.1"><site site="a"/><geom geom="ball"/>
<site site="b"/></spatial></tendon></mujoco>"""


@pytest.mark.parametrize("text", [planar_arm(1, ""), around_a_cylinder(1, "<freejoint/>")])
def test_mujoco_tendons_that_wrap_differently_in_some_poses_are_listed_as_not_converted(text, tmp_path):
    (tmp_path / "t.xml").write_text(text)
    found = from_mujoco(tmp_path / "t.xml")
    assert not found.system.reevings
    assert [x for x in found.missing if x.startswith("tendon '")]


@pytest.mark.parametrize("text", [INSIDE, SPACE])
def test_mujoco_tendons_inside_geoms_or_in_space_around_spheres_are_listed_as_not_converted(text, tmp_path):
    file = tmp_path / "t.xml"
    file.write_text(text)
    found = from_mujoco(file)
    assert not found.system.reevings
    assert any(x.startswith("tendon 't': tendons over joints or in space around geoms") for x in found.missing)
