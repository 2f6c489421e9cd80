"""A double pendulum whose upper link bends, against MuJoCo's chain of rigid segments on springs."""

import mujoco
import numpy as np
from heavylift.kernel.description import Beam, Body, Flexible, Joint, System
from small_scenes import SECOND, G, Y, column, hand_over, imbalance, started

LENGTH, PER_LENGTH, EI = 5.0, 20.0, 2.4e4
BOB, ARM, ABOUT = 50.0, 1.5, 20.0  # the lower link: mass, centre of mass, moment about it
SEGMENTS = 12
RIGID = 0.05  # [m] how far off a rigid link is, at least
ALIKE = 0.002  # [m] of twelve segments and three modes, while the link bows by 0.25 m
TIMES = np.arange(0.05, 1.55, 0.05)
ROUND = ((ABOUT, 0.0, 0.0), (0.0, ABOUT, 0.0), (0.0, 0.0, ABOUT))


def double_pendulum(flexible: bool) -> System:
    """Released at rest with both links level."""
    beam = Beam(LENGTH, PER_LENGTH, EI_y=EI if flexible else 0.0)
    bodies = (
        Body("upper", 0.0, flexible=Flexible(3 if flexible else 0, beam)),
        Body("lower", BOB, (ARM, 0.0, 0.0), ROUND),
    )
    joints = (
        Joint("shoulder", "revolute", "world", "upper", axis=Y),
        Joint("elbow", "revolute", "upper", "lower", (LENGTH, 0.0, 0.0), axis=Y),
    )
    return System(bodies, joints, gravity=G)


def elbow(flexible: bool) -> np.ndarray:
    """(n, 2) place of the elbow in the vertical plane."""
    s = started(double_pendulum(flexible), tolerance=1e-9, sample_ns=50_000_000)
    hand_over(s, int(1.52 * SECOND))
    assert not flexible or imbalance(s) < 1e-8
    t, x = column(s, "pose/lower")
    return np.array([x[np.argmin(np.abs(t - at))][[0, 2]] for at in TIMES])


def chain() -> np.ndarray:
    """The same place in MuJoCo: half a segment at both ends, springs EI/h between them."""
    h = LENGTH / SEGMENTS
    lengths = [h / 2, *([h] * (SEGMENTS - 1)), h / 2]
    xml, at = "", 0.0
    for n, l in enumerate(lengths):
        m = PER_LENGTH * l
        about = m * l * l / 12.0
        spring = f'stiffness="{EI / h}"' if n else ""
        xml += f'<body pos="{at} 0 0"><joint type="hinge" axis="0 1 0" {spring}/>'
        xml += f'<inertial pos="{l / 2} 0 0" mass="{m}" diaginertia="{about} {about} {about}"/>'
        at = l
    xml += f'<body name="lower" pos="{at} 0 0"><joint type="hinge" axis="0 1 0"/>'
    xml += f'<inertial pos="{ARM} 0 0" mass="{BOB}" diaginertia="{ABOUT} {ABOUT} {ABOUT}"/>' + "</body>" * (
        SEGMENTS + 2
    )
    option = f'<option gravity="0 0 -{G}" timestep="2e-4" integrator="RK4"/>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{option}<worldbody>{xml}</worldbody></mujoco>")
    data, out = mujoco.MjData(model), []
    for at in TIMES:
        while data.time < at - 1e-9:
            mujoco.mj_step(model, data)
        mujoco.mj_kinematics(model, data)
        out.append(data.body("lower").xpos[[0, 2]].copy())
    return np.array(out)


def test_a_flexible_pendulum_falls_like_a_chain_of_rigid_segments_in_mujoco():
    """The swing pulls at the link with twice its Euler load: without the shortening of a bent beam (geometric
    stiffness) it would end 0.19 m off."""
    bent, stiff, want = elbow(True), elbow(False), chain()
    assert np.abs(stiff - want).max() > RIGID
    assert np.abs(bent - want).max() < ALIKE
