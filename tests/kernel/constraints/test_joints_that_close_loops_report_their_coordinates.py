"""Coordinates and speeds of loop closing joints equal those of tree joints, against SciPy's rotations."""

from dataclasses import replace
from random import Random

import numpy as np
import pytest
from heavylift.kernel.constraints import CLOSURES, closed_coordinates, closed_rates
from heavylift.kernel.description import JOINTS, WORLD, Body, Joint, System
from heavylift.kernel.model import evaluate
from heavylift.kernel.multibody import rates
from linkages import looped
from scipy.spatial.transform import Rotation
from small_scenes import started

KINDS = sorted(k for k in CLOSURES if JOINTS[k].n_q and k != "free")
CLOSE, STEP = 1e-9, 1e-5


def frame(random):
    return Rotation.random(random_state=random.randrange(2**31))


def moved(joint, q, axes):
    """Rotation and displacement of the child's side in the parent's, in the joint's own frame."""
    if joint.kind == "spherical":
        return Rotation.from_quat(q), np.zeros(3)
    slid, turned = np.zeros(3), Rotation.identity()
    for m in JOINTS[joint.kind].motions:
        x = q[m.coordinate] * (joint.pitch if m.factor is None else m.factor)
        if m.turns:
            turned = turned * Rotation.from_rotvec(x * axes[m.axis])
        else:
            slid = slid + x * axes[m.axis]
    return turned, slid


def drawn(kind, seed):
    """A joint with random frames, its coordinates and speeds, and where its sides are when the coordinates are q."""
    random = Random(f"{kind} {seed}")
    of = JOINTS[kind]
    E, R_PJ, R_CJ, R_A = (frame(random) for _ in range(4))
    axes = E.as_matrix().T
    q = [random.uniform(-1.5, 1.5) for _ in of.coordinates]
    if kind == "spherical":
        q = Rotation.random(random_state=seed).as_quat(canonical=True).tolist()
    p_PJ, p_CJ, o_A = (np.array([random.uniform(-2, 2) for _ in range(3)]) for _ in range(3))
    joint = Joint(
        "x", kind, "a", "b", tuple(p_PJ), tuple(map(tuple, R_PJ.as_matrix())), tuple(axes[0]), tuple(axes[1]),
        p_CJ=tuple(p_CJ), R_CJ=tuple(map(tuple, R_CJ.as_matrix())), pitch=0.3 if kind == "screw" else 0.0,
        q0=tuple(x + random.uniform(-0.3, 0.3) for x in q),
    )  # fmt: skip
    v = [random.uniform(-1.5, 1.5) for _ in of.velocities]
    spin, drift = (np.array([random.uniform(-2, 2) for _ in range(3)]) for _ in range(2))

    def sides(t):
        """Rotation and origin of A and B, of which A moves, too, after t seconds."""
        at = (Rotation.from_quat(q) * Rotation.from_rotvec(np.multiply(v, t))).as_quat() if kind == "spherical" else (
            np.add(q, np.multiply(v, t)))  # fmt: skip
        turned, slid = moved(joint, at, axes)
        R, o = Rotation.from_rotvec(spin * t) * R_A, o_A + drift * t
        R_B = R * R_PJ * turned * R_CJ.inv()
        return (R, o), (R_B, o + R.apply(p_PJ + R_PJ.apply(slid)) - R_B.apply(p_CJ))

    return joint, q, v, sides


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(20))
def test_a_loop_closing_joint_reports_the_coordinates_and_speeds_that_it_would_have_in_a_tree(kind, seed):
    joint, q, v, sides = drawn(kind, seed)
    ends = []
    for (R, o), (before, p), (after, s) in zip(sides(0.0), sides(-STEP), sides(STEP), strict=True):
        twist = [*(after * before.inv()).as_rotvec() / (2 * STEP), *(s - p) / (2 * STEP)]
        r = np.array([0.3, -0.2, 0.5])  # from the tree's point, where its twist is, to the body's origin
        twist[3:] -= np.cross(twist[:3], r)
        ends.append(np.concatenate([R.as_matrix().ravel(), o - r, r, twist]))
    assert closed_coordinates(joint, *ends) == pytest.approx(q, abs=CLOSE)
    assert closed_rates(joint, *ends) == pytest.approx(v, abs=1e-7)


def shafts(kind, name, asked):
    """Two shafts at 40 degrees in bearings, joined by a joint that closes the loop."""
    c, s = np.cos(np.radians(40.0)), np.sin(np.radians(40.0))
    bodies = tuple(Body(b, 1.0, (0.0, 0.0, 0.0), ((0.01, 0, 0), (0, 0.01, 0), (0, 0, 0.01))) for b in ("in", "out"))
    X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    joints = (
        Joint("b1", "revolute", WORLD, "in", axis=X),
        Joint("b2", "revolute", WORLD, "out", axis=X, R_PJ=((c, 0, s), (0, 1, 0), (-s, 0, c)), R_CJ=tuple(
            map(tuple, np.eye(3)))),
        Joint(name, kind, "in", "out", axis=Z if kind == "universal" else X, second=Y, q0=asked),
    )  # fmt: skip
    return System(bodies, joints)


@pytest.mark.parametrize("name", ["a", "z"])
@pytest.mark.parametrize(("kind", "asked", "told"), [
    ("universal", (0.1, 0.2), ("angle1 from 5.72958 degrees to 0 deg", "angle2 from 11.4592 degrees to 40 degrees")),
    ("constant-velocity", (0.1, 0.0), ("angle1 from 5.72958 degrees to 20 degrees",)),
    ("spherical", (0.0, 0.0, 0.0, 1.0), ("attitude from 0 degrees to 40 degrees",)),
])  # fmt: skip
def test_a_start_value_that_a_loop_closing_joint_cannot_keep_is_reported(kind, asked, told, name):
    (note,) = [n.sentence for n in started(shafts(kind, name, asked), native=False).notes if "start pose" in n.sentence]
    assert note.startswith(f"the start pose was changed so that the loops of joint '{name}' close: joint '{name}' ")
    assert all(f"joint '{name}' {x}" in note for x in told), note
    assert note.count(" from ") == len(told)


LOOPS = sorted(set(KINDS) - {"spherical"})


def used(s):
    """Speeds of all joints at the start; of those that close loops, central differences of their coordinates."""
    program = s.program
    y, v, P = s.state.copy(), s.state[program.nq :], program.parameters.initial
    ends = []
    for t in (-STEP, STEP):
        x = y.copy()
        for k in program.graph.links:
            if k.v.stop > k.v.start:
                x[k.q] += t * np.array(rates(k.joint.kind, y[k.q], v[k.v]), float)
        ends.append(evaluate(program, 0.0, x, P, forces=False).ends)
    found = {k.joint.name: tuple(v[k.v]) for k in program.graph.links}
    for j in program.constraints.loops:
        q = [np.array(closed_coordinates(j, *(e[program.graph.number(b)] for b in (j.parent, j.child)))) for e in ends]
        found[j.name] = tuple((q[1] - q[0]) / (2 * STEP))
    return found


def told_speeds(s):
    """What the note says of speeds, and its end."""
    message = [n.sentence for n in s.notes if n.sentence.startswith("the start speeds")]
    assert len(message) < 2
    message = "".join(message).partition(" allow: ")[2]
    return {
        " ".join(x.split()[:-5]): float(x.split()[-2]) for x in message.split("; give")[0].split("; ") if x
    }, message


@pytest.mark.parametrize("kind", LOOPS)
@pytest.mark.parametrize("seed", range(6))
def test_corrected_start_speeds_of_a_closed_loop_give_a_note_and_consistent_ones_give_none(kind, seed):
    random = Random(f"{kind} {seed}")
    system, *_ = looped(seed, (kind,), n=5)
    drawn = [tuple(random.uniform(-1.0, 1.0) for _ in JOINTS[j.kind].velocities) for j in system.joints]
    asked = replace(system, joints=tuple(replace(j, v0=v) for j, v in zip(system.joints, drawn, strict=True)))
    s = started(asked, native=False)
    speeds, (message, sentence) = used(s), told_speeds(s)
    for j in asked.joints:
        for c, x, z in zip(JOINTS[j.kind].velocities, j.v0, speeds[j.name], strict=True):
            where = f"joint '{j.name}'" + f" {c}" * (len(j.v0) > 1)
            assert (where in message) == (abs(x - z) > 1e-3), where
            assert message.get(where, z) == pytest.approx(z, rel=1e-5, abs=1e-5)
    (closing,) = s.program.constraints.loops
    assert sentence.endswith(f"; give other joints of the loop the speeds from which those of '{closing.name}' follow")
    fits = replace(asked, joints=tuple(replace(j, v0=speeds[j.name]) for j in asked.joints))
    assert told_speeds(started(fits, native=False)) == ({}, "")


def test_a_start_speed_stated_only_for_the_loop_closing_joint_is_reported():
    """Nothing else is asked to move, so that it does not."""
    at_rest = shafts("universal", "x", ())
    joints = (*at_rest.joints[:2], replace(at_rest.joints[2], v0=(2.0, 0.0)))
    _, sentence = told_speeds(started(replace(at_rest, joints=joints), native=False))
    assert sentence.startswith("joint 'x' rate1 from 2 to 0 rad/s; give other joints")
