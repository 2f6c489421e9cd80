"""A body on a fixed joint is merged with its parent body: same motion, no extra operations."""

from dataclasses import replace

import numpy as np
import pytest
from heavylift.kernel.analysis import reactions
from heavylift.kernel.description import Body, Joint, System
from heavylift.kernel.model import Program
from scipy.spatial.transform import Rotation
from small_scenes import started

R = tuple(map(tuple, Rotation.from_rotvec([0.3, -0.5, 0.9]).as_matrix().tolist()))
TURN = tuple(map(tuple, Rotation.from_rotvec([-0.2, 0.1, 0.4]).as_matrix().tolist()))
ARM = Body("arm", 3.0, (0.1, 0.0, -0.4), ((0.5, 0.0, 0.0), (0.0, 0.6, 0.1), (0.0, 0.1, 0.3)))
TOOL = Body("tool", 2.0, (0.0, 0.2, 0.1), ((0.2, 0.05, 0.0), (0.05, 0.3, 0.0), (0.0, 0.0, 0.25)))
PIN = Joint("pin", "spherical", "world", "arm", v0=(0.5, -1.0, 2.0))
GRIP = Joint("grip", "fixed", "arm", "tool", (0.3, -0.1, 0.7), R, p_CJ=(0.05, 0.1, 0.0), R_CJ=TURN)
SAME = 1e-12  # relative: the sums are rounded in another order


def welded() -> Body:
    """Both as one body, by the parallel-axis theorem."""
    R_PB = np.array(R) @ np.array(TURN).T
    at = np.array(GRIP.p_PJ) - R_PB @ np.array(GRIP.p_CJ)
    parts = [(ARM.mass, np.array(ARM.com), np.array(ARM.inertia))]
    parts.append((TOOL.mass, at + R_PB @ np.array(TOOL.com), R_PB @ np.array(TOOL.inertia) @ R_PB.T))
    mass = sum(m for m, _, _ in parts)
    com = sum(m * c for m, c, _ in parts) / mass
    inertia = sum(I + m * (((c - com) @ (c - com)) * np.eye(3) - np.outer(c - com, c - com)) for m, c, I in parts)
    return Body("arm", mass, tuple(com.tolist()), tuple(map(tuple, inertia.tolist())))


def operations(system: System) -> int:
    """Additions, products and the like in the accelerations of the only tree."""
    ((_, shared),) = Program(system).instances
    return sum(n.op != "in" for n in shared.accelerate.nodes)


def test_two_bodies_on_a_fixed_joint_move_as_one_body():
    held, one = (started(s) for s in (System((ARM, TOOL), (PIN, GRIP)), System((welded(),), (PIN,))))
    for s in (held, one):
        s.run(2_000_000_000)
        s.interrupt(2_000_000_000)
    n = one.program.nq + one.program.nv
    assert held.state[:n] == pytest.approx(one.state[:n], rel=SAME)


def test_a_body_on_a_fixed_joint_adds_no_code():
    one, held = System((welded(),), (PIN,)), System((ARM, TOOL), (PIN, GRIP))
    assert operations(held) == operations(one)


def test_a_fixed_joint_still_reports_its_reaction():
    s = started(System((ARM, TOOL), (replace(PIN, v0=(0.0,) * 3), GRIP)))
    assert np.linalg.norm(reactions(s)["grip"].force) > 0.5 * TOOL.mass * 9.8
