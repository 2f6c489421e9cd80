"""Two joints with a massless body between them move like MuJoCo's combined joint."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from heavylift import simulate
from heavylift.kernel import SceneError
from heavylift.nodes.scene import parse

SCENE = """\
heavylift: 1
name: joined
tolerance: 1e-10
samples: 1 Hz
end: 1 s
mechanism:
  bodies:
    between: {{mass: 0 kg}}
    part: {{mass: 30 kg, com: [0.2 m, 0.1 m, -0.6 m], inertia: [4 kg m2, 5 kg m2, 3 kg m2]}}
  joints:
    first: {{child: between, {first}}}
    last: {{parent: between, child: part, {last}}}
{laws}"""
PART = "{mass: 30 kg, com: [0.2 m, 0.1 m, -0.6 m], inertia: [4 kg m2, 5 kg m2, 3 kg m2]}"
X, Y, Z = "[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]"
STRUT = "  springs:\n    strut: {joint: first, coordinate: travel, stiffness: 20 kN/m, damping: 300 N s/m}\n"
JOINTS = {  # what it is here; in MuJoCo, joints of one body with their axes, initial speeds, and a spring's numbers
    "hinge-2": (
        f"type: cylindrical, axis: {Z}, speed: [0.3 m/s, 0.7 rad/s]",
        f"type: revolute, axis: {Y}, speed: 5 rad/s",
        STRUT,
        [("slide", (0, 0, 1), 0.3, 20e3, 300.0), ("hinge", (0, 0, 1), 0.7, 0, 0), ("hinge", (0, 1, 0), 5.0, 0, 0)],
    ),
    "PR": (
        f"type: prismatic, axis: {X}, speed: 0.5 m/s",
        f"type: revolute, axis: {Y}, speed: 2 rad/s",
        "",
        [("slide", (1, 0, 0), 0.5, 0, 0), ("hinge", (0, 1, 0), 2.0, 0, 0)],
    ),
    "PU": (
        f"type: prismatic, axis: {X}, speed: 0.5 m/s",
        f"type: universal, axis: {Y}, second axis: {X}, speed: [2 rad/s, -1 rad/s]",
        "",
        [("slide", (1, 0, 0), 0.5, 0, 0), ("hinge", (0, 1, 0), 2.0, 0, 0), ("hinge", (1, 0, 0), -1.0, 0, 0)],
    ),
}


def in_mujoco(joints: list[tuple[str, tuple[float, ...], float, float, float]]) -> np.ndarray:
    """(7,) pose of the body after a second, quaternion x y z w, in steps of 0.1 ms of RK4."""
    spec = mujoco.MjSpec()
    spec.option.gravity, spec.option.timestep = [0.0, 0.0, -9.80665], 1e-4
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    body = spec.worldbody.add_body(name="part")
    body.explicitinertial, body.mass, body.ipos, body.inertia = True, 30.0, [0.2, 0.1, -0.6], [4.0, 5.0, 3.0]
    for kind, axis, _, stiffness, damping in joints:
        j = body.add_joint(type=getattr(mujoco.mjtJoint, f"mjJNT_{kind.upper()}"), axis=axis)
        several = isinstance(j.stiffness, np.ndarray)  # in MuJoCo 3.4 and later
        j.stiffness = [stiffness, 0.0, 0.0] if several else stiffness
        j.damping = [damping, 0.0, 0.0] if several else damping
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qvel[:] = [speed for _, _, speed, _, _ in joints]
    for _ in range(10_000):
        mujoco.mj_step(model, data)
    mujoco.mj_kinematics(model, data)
    return np.array([*data.xpos[1], *np.roll(data.xquat[1], -1)])


@pytest.mark.parametrize("name", JOINTS)
def test_two_joints_connected_by_a_massless_body_move_as_in_mujoco(name: str) -> None:
    first, last, laws, joints = JOINTS[name]
    pose = simulate(parse(SCENE.format(first=first, last=last, laws=laws)))["pose/part"].values[-1]
    want = in_mujoco(joints)
    want[3:] *= np.sign(want[3:] @ pose[3:])
    assert pose == pytest.approx(want, rel=1e-6, abs=1e-7)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (PART, "{mass: 0 kg}", "scene.yaml:8:5: error: mechanism.bodies.between: body 'between': it can move without"),
        ("{mass: 0 kg}", "{mass: -1 kg}", "scene.yaml:8:21: error: mechanism.bodies.between.mass: a mass must be"),
        (
            "parent: between, child: part",
            "child: part",
            "scene.yaml:8:5: error: mechanism.bodies.between: body 'between': it can move without inertia",
        ),
    ],
)
def test_a_massless_body_that_can_move_without_inertia_is_refused(old: str, new: str, told: str) -> None:
    scene = SCENE.format(first=JOINTS["PR"][0], last=JOINTS["PR"][1], laws="")
    assert old in scene
    with pytest.raises(SceneError) as e:
        parse(scene.replace(old, new))
    assert told in str(e.value)


COUPLER = """\
heavylift: 1
name: coupled
tolerance: 1e-9
samples: 1 Hz
end: 1 s
mechanism:
  bodies:
    crank: {mass: 3 kg, com: [0.5 m, 0, 0], inertia: [0.1 kg m2, 0.3 kg m2, 0.3 kg m2]}
    rod: {mass: 0 kg}
    slide: {mass: 5 kg, inertia: [1 kg m2, 1 kg m2, 1 kg m2]}
  joints:
    axle: {type: revolute, axis: [0, 1, 0], child: crank, start: -30 deg}
    pin: {type: revolute, axis: [0, 1, 0], parent: crank, child: rod, at: [1 m, 0, 0], start: 60 deg}
    rail: {type: prismatic, axis: [1, 0, 0], child: slide, start: 1.7320508075688772 m}
    CLOSES
"""


CARRIES = "end: {type: revolute, axis: [0, 1, 0], parent: rod, child: slide, at: [1 m, 0, 0], start: -30 deg}"
CARRIED = "end: {type: revolute, axis: [0, 1, 0], parent: slide, child: rod, at child: [1 m, 0, 0]}"


def test_a_slider_crank_with_a_massless_rod_conserves_energy() -> None:
    """Crank and rod of 1 m: the slide is at x = 2 cos(angle) and goes at -2 sin(angle) times the crank's rate."""
    run = simulate(parse(COUPLER.replace("CLOSES", CARRIES)))
    x = run["pose/slide"]["x"]
    rate = run["joint/velocity"]["axle.rate"]
    down = run["joint/position"]["axle.angle"]
    assert x == pytest.approx(2.0 * np.cos(down), abs=1e-9)
    moving = 0.5 * (0.3 + 3.0 * 0.25 + 5.0 * 4.0 * np.sin(down) ** 2) * rate**2
    assert rate[-1] > 1.0
    assert moving - 3.0 * 9.80665 * 0.5 * np.sin(down) == pytest.approx(3.0 * 9.80665 * 0.25, rel=1e-7)
    with pytest.raises(SceneError, match="body 'rod': it can move without inertia"):  # it must carry the mass
        parse(COUPLER.replace("CLOSES", CARRIED))
