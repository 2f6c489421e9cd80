"""Signals of loads on joints and bases against MuJoCo's gravity torques and mass matrix and against sums of weights."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import Body, Joint, Line, Point, Rope, ScalarSignal, System, guard_of, merge
from heavylift.kernel.islands import islands_of
from heavylift.kernel.simulation.native import reader
from small_scenes import G, started

BASE = (1.0, 0.0, 6.0, 5.0)  # not slewed; length and width


def arm(seed: int) -> tuple[System, str]:
    """A tree of four bodies on hinges at random places, and the same tree for MuJoCo."""
    random = np.random.default_rng(seed)
    parents, bodies, joints, text = ["world", "b0", "b1", "b1"], [], [], {}
    for i, parent in enumerate(parents):
        mass, com, at = random.uniform(1.0, 9.0), random.normal(size=3), random.normal(size=3)
        inertia = np.diag(random.uniform(2.0, 3.0, 3))
        axis = random.normal(size=3)
        axis /= np.linalg.norm(axis)
        bodies.append(Body(f"b{i}", mass, tuple(com), tuple(map(tuple, inertia))))
        joints.append(Joint(f"j{i}", "revolute", parent, f"b{i}", tuple(at), axis=tuple(axis)))
        own, where, about = (" ".join(map(repr, map(float, x))) for x in (com, at, axis))
        main = " ".join(map(repr, map(float, np.diag(inertia))))
        text[f"b{i}"] = (
            parent,
            (
                f'<body name="b{i}" pos="{where}"><joint name="j{i}" axis="{about}"/>'
                f'<inertial pos="{own}" mass="{float(mass)!r}" diaginertia="{main}"/>'
            ),
        )

    def below(name: str) -> str:
        return "".join(x + below(body) + "</body>" for body, (parent, x) in text.items() if parent == name)

    return System(tuple(bodies), tuple(joints), gravity=G), (
        f'<mujoco><option gravity="0 0 {-G!r}"/><worldbody>{below("world")}</worldbody></mujoco>'
    )


@pytest.mark.parametrize("seed", range(5))
def test_static_moments_about_the_joints_of_an_arm_agree_with_mujoco(seed: int) -> None:
    """Torque of gravity; with a ramp the diagonal of the mass matrix, of an arm without ropes."""
    system, text = arm(seed)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    M = np.zeros((model.nv, model.nv))
    for row, unit in zip(M, np.eye(model.nv), strict=True):
        mujoco.mj_mulM(model, data, row, unit)
    ramp = 0.3
    signals = [ScalarSignal("joint moment", of=f"j{i}") for i in range(4)]
    signals += [ScalarSignal("starting moment", of=f"j{i}", numbers=(ramp,)) for i in range(4)]
    simulation = started(replace(system, thresholds=tuple(guard_of(f"g{i}", x) for i, x in enumerate(signals))))
    found = [reader(simulation.program, x)(simulation.native.raw().tolist()) for x in signals]
    order = [model.joint(f"j{i}").dofadr[0] for i in range(4)]
    torque = np.abs(data.qfrc_bias[order])
    assert found[:4] == pytest.approx(torque.tolist(), rel=1e-9)
    assert found[4:] == pytest.approx((torque + ramp * np.diag(M)[order]).tolist(), rel=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_a_base_carries_the_weight_of_its_machine_and_the_pull_of_attached_ropes(seed: int) -> None:
    """Of a machine on a deck: not the deck, and of a rope to the ground its pull; four corners share as of a plate."""
    random = np.random.default_rng(seed)
    (deck, crane, load), at = random.uniform(1.0, 9.0, 3) * 1e3, random.uniform(-1.0, 1.0, 2)
    bodies = Body("deck", deck), Body("crane", crane, (0.3, 0.2, 2.0)), Body("load", load)
    joints = (
        Joint("sea", "prismatic", "world", "deck"),
        Joint("stands", "fixed", "deck", "crane", (0.0, 0.0, 1.0)),
        Joint("hangs", "fixed", "crane", "load", (*at, 1.5)),
    )
    rope = Rope("stay", (Line(Point("world", (2.0, 1.0, -3.0)), Point("crane", (0.0, 0.0, 3.0))),), 1e6, 5.0)
    system = System(bodies, joints, ropes=(rope,), gravity=G)
    corners = [(a, b) for a in (1.0, -1.0) for b in (1.0, -1.0)]
    base = {"point": Point("crane")}
    signals = [ScalarSignal("corner load", **base, numbers=(*BASE, *x, 1.0, 0.0)) for x in corners]
    simulation = started(system)
    row = simulation.native.raw().tolist()
    found = [reader(simulation.program, x)(row) for x in signals]
    tension = reader(simulation.program, ScalarSignal("tension", ropes=("stay",)))(row)
    pull = tension * np.array([2.0, 1.0, -7.0]) / np.linalg.norm([2.0, 1.0, -7.0])
    top = np.array([0.0, 0.0, 3.0])
    forces = [(np.array([0.3, 0.2, 2.0]), crane), (np.array([*at, 1.5]), load)]
    moments = sum(np.cross(p, [0.0, 0.0, -G * m]) for p, m in forces) + np.cross(top, pull)
    V = G * (crane + load) - pull[2]
    x, y = moments[1] / V, -moments[0] / V
    assert found == pytest.approx([V / 4 * (1 + 2 * a * x / 6.0 + 2 * b * y / 5.0) for a, b in corners], rel=1e-9)


def test_guards_on_joint_loads_leave_separate_arms_in_separate_islands() -> None:
    """Two separate arms stay two islands, each with its own guard; a rope from one to the other couples them."""
    arms = []
    for name in "ab":
        text = arm(1)[0]
        bodies = tuple(replace(b, name=f"{name}{b.name}") for b in text.bodies)
        own = {"world": "world"} | {b.name: f"{name}{b.name}" for b in text.bodies}
        joints = tuple(
            replace(j, name=f"{name}{j.name}", parent=own[j.parent], child=own[j.child]) for j in text.joints
        )
        guard = guard_of(f"{name}-guard", ScalarSignal("joint moment", of=f"{name}j1"))
        arms.append(System(bodies, joints, thresholds=(guard,)))
    both = merge(arms, G)
    islands = islands_of(both)
    assert [[x.name for x in island.thresholds] for island in islands] == [["a-guard"], ["b-guard"]]
    rope = Rope("tie", (Line(Point("ab3"), Point("bb3")),), 1e6, 9.0)
    assert len(islands_of(replace(both, ropes=(rope,)))) == 1


@pytest.mark.parametrize(
    ("signal", "message"),
    [
        (ScalarSignal("joint moment"), "a joint moment needs a joint"),
        (ScalarSignal("starting moment", of="j1"), "a starting moment needs 1 values in `numbers`, not 0"),
        (ScalarSignal("tipping", numbers=(*BASE, 0.0)), "a tipping needs a point"),
        (ScalarSignal("joint moment", of="j9"), "there is no joint 'j9'"),
    ],
)
def test_a_load_signal_that_names_no_existing_joint_or_base_is_reported(signal: ScalarSignal, message: str) -> None:
    system, _ = arm(0)
    with pytest.raises(KernelError, match=message):
        started(replace(system, thresholds=(guard_of("it", signal),)))
