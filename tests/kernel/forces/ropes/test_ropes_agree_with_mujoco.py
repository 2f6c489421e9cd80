"""Accelerations of the two-crane scene agree with MuJoCo for winches, any rest lengths and slack ropes.

There a rope is a tendon with a pulling actuator of its own: force k (l - ctrl) + c l', never pushing.  A drum that
turns is ctrl = L0 + c/k L0', a stiffness that changes with the length is written into the actuator.
"""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from goliath import HINGE_DAMPING, KP, KV, G, scene
from heavylift.kernel.simulation import Simulation

SAME = 1e-9  # relative to the largest acceleration
N_ROPES = 6


def mjcf(system):
    """The same scene for MuJoCo, bodies in the same order."""
    bodies = {b.name: b for b in system.bodies}
    sites = {f"{r.name}{e}": getattr(r.lines[0], e) for r in system.ropes for e in "ab"}

    def numbers(x):
        return " ".join(repr(float(e)) for e in x)

    def body(joint):
        b = bodies[joint.child]
        inertia = numbers(b.inertia[i][i] for i in range(3))
        if joint.kind == "free":
            move = "<freejoint/>"
        else:
            kind = "slide" if joint.kind == "prismatic" else "hinge"
            k, d = (KP, KV) if joint.kind == "prismatic" else (0.0, HINGE_DAMPING)
            move = f'<joint type="{kind}" axis="{numbers(joint.axis)}" stiffness="{k}" damping="{d}"/>'
        marks = [f'<site name="{n}" pos="{numbers(p.p)}"/>' for n, p in sites.items() if p.body == b.name]
        carried = [body(j) for j in system.joints if j.parent == b.name]
        place = joint.q0[:3] if joint.kind == "free" else joint.p_PJ
        return (
            f'<body name="{b.name}" pos="{numbers(place)}">{move}'
            f'<inertial pos="{numbers(b.com)}" mass="{b.mass}" diaginertia="{inertia}"/>'
            f"{''.join(marks)}{''.join(carried)}</body>"
        )

    world = "".join(body(j) for j in system.joints if j.parent == "world")
    tendons = "".join(
        f'<spatial name="{r.name}"><site site="{r.name}a"/><site site="{r.name}b"/></spatial>' for r in system.ropes
    )
    winches = "".join(
        f'<general tendon="{r.name}" gaintype="fixed" biastype="affine" forcerange="-1e12 0"/>' for r in system.ropes
    )
    return (
        f'<mujoco><option gravity="0 0 -{G}"><flag contact="disable"/></option><compiler angle="radian"/>'
        f"<worldbody>{world}</worldbody><tendon>{tendons}</tendon><actuator>{winches}</actuator></mujoco>"
    )


class Peer:
    """MuJoCo with the kernel's coordinates: quaternions end with w, a free body's velocity is in its own axes."""

    def __init__(self, system, graph):
        self.model = mujoco.MjModel.from_xml_string(mjcf(system))
        self.data = mujoco.MjData(self.model)
        block = next(k for k in graph.links if k.joint.kind == "free")
        self.q, self.v = block.q.start, block.v.start
        names = [self.model.body(i + 1).name for i in range(len(graph.links))]
        assert names == [k.body.name for k in graph.links]

    def acceleration(self, q, v, L0, dL0, EA, c):
        k = EA / L0
        self.model.actuator_gainprm[:, 0] = k
        self.model.actuator_biasprm[:, 1], self.model.actuator_biasprm[:, 2] = -k, -c
        self.data.ctrl[:] = L0 + c / k * dL0
        self.data.qpos[:], self.data.qvel[:] = q, v
        x, y, z, w = q[self.q + 3 : self.q + 7]
        self.data.qpos[self.q + 3 : self.q + 7] = w, x, y, z
        R = np.zeros(9)
        mujoco.mju_quat2Mat(R, np.array([w, x, y, z]))
        R, own = R.reshape(3, 3), slice(self.v, self.v + 3)
        self.data.qvel[own] = R @ v[own]
        mujoco.mj_forward(self.model, self.data)
        a = self.data.qacc.copy()
        a[own] = R.T @ a[own] - np.cross(v[self.v + 3 : self.v + 6], v[own])
        return a, -self.data.actuator_force


@pytest.fixture(scope="module")
def simulation():
    system = scene()
    return Simulation(replace(system, ropes=tuple(replace(r, winch=True) for r in system.ropes)))


def test_ropes_over_turning_drums_have_the_accelerations_of_mujoco_at_random_states(simulation):
    program, layout = simulation.program, simulation.method.layout
    n = program.nq + program.nv
    peer = Peer(program.system, program.graph)
    random = np.random.default_rng(3)
    EA, c = program.system.ropes[0].EA, program.system.ropes[0].damping
    slack, taut = 0, 0
    for _ in range(200):
        y = program.initial_state()[:n] + 0.05 * random.standard_normal(n)
        at = slice(peer.q + 3, peer.q + 7)
        y[at] /= np.linalg.norm(y[at])
        L0 = np.array([r.L0 for r in program.system.ropes]) + 0.2 * random.standard_normal(N_ROPES)
        dL0 = 0.2 * random.standard_normal(N_ROPES)
        simulation.state[:n] = y
        for name, length, rate in zip((r.name for r in program.system.ropes), L0, dL0, strict=True):
            simulation.P[program.parameters.at["rope", name]][3] = 0.0
            simulation.P[program.parameters.at["reference", name]] = [0.0, length, rate, 0.0, 0.0, 1e9, 0.0, 0.0]
        simulation.native.call("refresh")
        for i, name in enumerate(r.name for r in program.system.ropes):
            simulation.P[program.parameters.at["rope", name]][3] = simulation.X[layout.at["G"]][i] < 0.0
        simulation.native.call("refresh")
        T, got = simulation.X[layout.at["T"]], simulation.X[layout.at["f"]][program.nq : n]
        want, tension = peer.acceleration(y[: program.nq], y[program.nq :], L0, dL0, EA, c)
        if ((T == 0.0) != (tension == 0.0)).any():
            continue  # a slack rope that MuJoCo's damper would pull before it is straight
        slack, taut = slack + (T == 0.0).sum(), taut + (T > 0.0).sum()
        assert np.abs(T - tension).max() <= SAME * np.abs(tension).max()
        assert np.abs(got - want).max() < SAME * np.abs(want).max()
    assert slack > 300
    assert taut > 300
    assert slack + taut > 0.9 * 200 * N_ROPES, "hardly any state was left out"
