"""Joints locked and freed during a run: inelastic impulses and the motion before, during and after the lock."""

from dataclasses import replace

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.compiler import emit as native
from heavylift.kernel.description import Body, Drive, Joint, Line, Lock, Point, Rope, System
from heavylift.kernel.model import Program
from heavylift.kernel.simulation import Simulation
from random_trees import random_system
from small_scenes import SECOND, G, X, Y, Z, column, hand_over, imbalance, started

TIGHT = 1e-11  # step tolerance
FOLLOWED = 1e-8  # relative: how two codes of one motion agree after two seconds at that tolerance
ROUNDED = 1e-12  # relative: an impulse is one solution of a linear system


def sphere(i):
    return ((i, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, i))


M, I, A, B = 40.0, 3.0, 1.2, 0.9  # two equal links: mass, inertia; length of the first; centre of the second


def double_pendulum(v0=(1.0, 2.0), gravity=0.0, **parts):
    """Two links about y; the second turns by its angle against the first."""
    bodies = (Body("upper", M, (0.0, 0.0, -A), sphere(I)), Body("lower", M, (0.0, 0.0, -B), sphere(I)))
    joints = (
        Joint("shoulder", "revolute", "world", "upper", axis=Y, q0=(0.3,), v0=v0[:1]),
        Joint("elbow", "revolute", "upper", "lower", (0.0, 0.0, -A), axis=Y, q0=(0.0,), v0=v0[1:]),
    )
    return System(bodies, joints, locks=(Lock("bolt", "elbow"),), gravity=gravity, **parts)


def at(system, t_ns, **options):
    s = started(system, tolerance=TIGHT, sample_ns=SECOND // 10, **options)
    hand_over(s, t_ns)
    return s


def test_locking_a_moving_elbow_conserves_the_angular_momentum_about_the_shoulder():
    """Stretched out: H = J1 w1 + J2 (w1 + w2) with arms about the shoulder; locked, both turn at H / (J1 + J2')."""
    s = at(double_pendulum(), 0)
    upper = I + M * A * A
    # v of the lower centre: A w1 + B (w1 + w2)
    momentum = upper * 1.0 + I * 3.0 + M * (A + B) * (A * 1.0 + B * 3.0)
    after = momentum / (upper + I + M * (A + B) ** 2)
    kinetic = 0.5 * (upper + I * 9.0 + M * (A + 3.0 * B) ** 2)
    lost = kinetic - 0.5 * momentum * after
    event = s.set_lock("bolt", True)
    assert (event.name, event.what, event.value) == ("bolt", "locked", pytest.approx(lost, rel=ROUNDED))
    s.settle()
    assert column(s, "joint/velocity")[1][-1] == pytest.approx([after, 0.0], rel=ROUNDED, abs=1e-15)
    hand_over(s, 2 * SECOND)
    s.settle()
    assert column(s, "joint/velocity")[1][-1] == pytest.approx([after, 0.0], rel=ROUNDED, abs=1e-15)
    assert column(s, "joint/position")[1][-1, 1] == 0.0
    _, accounts = column(s, "account")
    assert accounts[-1].tolist() == [event.value]
    assert imbalance(s) < ROUNDED


def test_a_locked_tree_moves_as_with_a_fixed_joint_and_continues_smoothly_when_unlocked():
    system = double_pendulum((0.0, 0.0), gravity=G)
    s = at(system, SECOND)
    s.set_lock("bolt", True)
    s.settle()
    q, v = s.row().q, s.row().v
    hand_over(s, 3 * SECOND)
    c, w = np.cos(q[1]), np.sin(q[1])
    bent = Joint("elbow", "fixed", "upper", "lower", (0.0, 0.0, -A), ((c, 0.0, w), (0.0, 1.0, 0.0), (-w, 0.0, c)))
    shoulder = replace(system.joints[0], q0=(q[0],), v0=(v[0],))
    stiff = at(replace(system, joints=(shoulder, bent), locks=()), 2 * SECOND)
    assert s.row().q == pytest.approx([stiff.row().q[0], q[1]], rel=FOLLOWED)
    assert s.row().v == pytest.approx([stiff.row().v[0], 0.0], rel=FOLLOWED)
    before = s.row().v.copy()
    assert s.set_lock("bolt", False).value == 0.0
    assert s.row().v.tolist() == before.tolist()
    s.settle()
    hand_over(s, 4 * SECOND)
    s.settle()
    assert abs(s.row().v[1]) > 0.1, "the elbow swings again"
    assert imbalance(s) < 1e-8
    assert [(t, e.what) for t, e in s.log] == [(SECOND, "locked"), (3 * SECOND, "freed")]


@pytest.mark.parametrize("seed", range(6))
def test_locking_joints_in_random_trees_of_bodies_conserves_momentum(seed):
    """Gauss: of all motions that obey the lock, the one after is nearest to the one before in the metric of H."""
    system = random_system(seed, 7, 2.0)
    moving = [j for j in system.joints if j.kind != "fixed"]
    joint = moving[int(np.random.default_rng(seed).integers(len(moving)))]
    rng = np.random.default_rng(seed)
    program = Program(system)
    v0 = rng.normal(size=program.nv)
    joints = tuple(replace(j, v0=tuple(v0[program.graph.joint(j.name).v])) for j in system.joints)
    s = started(replace(system, joints=joints, locks=(Lock("lock", joint.name),)), native=False)
    before = s.row()
    event = s.set_lock("lock", True)
    after = s.row()
    at_rest = program.graph.joint(joint.name).v
    assert after.v[at_rest].tolist() == [0.0] * (at_rest.stop - at_rest.start)
    assert before.kinetic - after.kinetic == pytest.approx(event.value, rel=1e-9)
    s.state[program.nq : program.nq + program.nv] = before.v - after.v
    assert s.row().kinetic == pytest.approx(event.value, rel=1e-9), "the jump is H-orthogonal to what is left"


def test_a_motor_that_keeps_turning_supplies_the_impulse_when_a_joint_is_locked():
    """A prescribed shoulder keeps its speed while the elbow is locked; its work and the lock's heat are accounted."""
    s = at(double_pendulum((0.0, 2.0), drives=(Drive("motor", "shoulder", "prescribed"),)), 0)
    s.references.set_profile("motor", 0, 1.0, 4.0, None)
    s.settle()
    hand_over(s, SECOND)
    speed = s.row().v
    s.set_lock("bolt", True)
    s.settle()
    assert s.row().v.tolist() == [speed[0], 0.0]
    hand_over(s, 2 * SECOND)
    s.settle()
    assert imbalance(s) < FOLLOWED


@pytest.mark.parametrize("kind", ["spherical", "free", "planar"])
def test_locking_a_joint_stops_all_of_its_degrees_of_freedom(kind):
    body = Body("a", M, (0.1, 0.2, 0.3), sphere(I))
    n = {"spherical": 3, "free": 6, "planar": 3}[kind]
    joint = Joint("j", kind, "world", "a", axis=Z, second=X, v0=(0.4,) * n)
    rope = Rope("rope", (Line(Point("world", (0.0, 0.0, 4.0)), Point("a")),), 1e5, 3.9)
    s = at(System((body,), (joint,), locks=(Lock("clamp", "j"),), ropes=(rope,), gravity=G), SECOND // 2)
    kinetic = float(s.row().kinetic)
    assert s.set_lock("clamp", True).value == pytest.approx(kinetic, rel=ROUNDED)
    s.settle()
    q = s.row().q.copy()
    hand_over(s, SECOND)
    assert s.row().q == pytest.approx(q, rel=1e-14, abs=1e-15)
    assert s.row().kinetic == 0.0
    s.set_lock("clamp", False)
    s.settle()
    hand_over(s, 2 * SECOND)
    s.settle()
    assert s.row().kinetic > 0.1
    assert imbalance(s) < 1e-7


def four_bar(v0, **parts):
    """A parallelogram of equal cranks about y that carries a coupler; its cranks keep parallel."""
    bar = Body("coupler", M, (0.5 * A, 0.0, 0.0), sphere(I))
    cranks = tuple(Body(n, M, (0.0, 0.0, -0.5), sphere(I)) for n in ("left", "right"))
    joints = (
        Joint("a", "revolute", "world", "left", axis=Y, v0=(v0,)),
        Joint("b", "revolute", "left", "coupler", (0.0, 0.0, -1.0), axis=Y, v0=(-v0,)),
        Joint("c", "revolute", "world", "right", (A, 0.0, 0.0), axis=Y, v0=(v0,)),
        Joint("d", "revolute", "right", "coupler", (0.0, 0.0, -1.0), axis=Y, p_CJ=(A, 0.0, 0.0)),
    )
    return System((*cranks, bar), joints, locks=(Lock("bolt", "a"),), gravity=G, **parts)


def test_a_lock_in_a_closed_loop_stops_everything_that_the_loop_couples():
    """A crank locked: the whole parallelogram stands; its kinetic energy is the lock's heat; freed, it swings again."""
    s = at(four_bar(2.0), SECOND // 10)
    kinetic = s.row().kinetic
    event = s.set_lock("bolt", True)
    assert event.value == pytest.approx(kinetic, rel=1e-9)
    s.settle()
    hand_over(s, SECOND)
    assert np.abs(s.row().v).max() < 1e-9
    s.set_lock("bolt", False)
    s.settle()
    hand_over(s, 2 * SECOND)
    s.settle()
    assert np.abs(s.row().v).max() > 0.1
    assert imbalance(s) < 1e-7


def test_a_joint_in_a_loop_turned_by_a_motor_cannot_be_locked():
    system = replace(four_bar(0.0), locks=(Lock("bolt", "b"),), drives=(Drive("motor", "a", "prescribed"),))
    s = at(system, 0)
    s.references.set_profile("motor", 0, 1.0, 4.0, None)
    s.settle()
    hand_over(s, SECOND)
    with pytest.raises(KernelError) as e:
        s.set_lock("bolt", True)
    assert str(e.value) == (
        "lock 'bolt' at 1.000 s: drive 'motor' is moving; stop it before locking a joint of a scene with closed loops"
    )


def test_each_combination_of_locked_joints_is_compiled_once(monkeypatch):
    compiled = []
    real = native.Library._compile
    monkeypatch.setattr(native.Library, "_compile", lambda *x: compiled.append(1) or real(*x))
    s = started(double_pendulum(gravity=G), cache=False)
    for i in range(6):
        hand_over(s, (i + 1) * SECOND // 4)
        s.set_lock("bolt", i % 2 == 0)
        s.settle()
    assert len(compiled) == 2
    assert s.set_lock("bolt", False) is None, "it is free already"


def test_a_joint_locked_at_the_start_does_not_move_until_its_lock_is_released():
    system = double_pendulum((0.5, 0.0), gravity=G)
    s = started(replace(system, locks=(Lock("bolt", "elbow", engaged=True),)))
    hand_over(s, SECOND)
    assert s.row().q[1] == 0.0
    s.set_lock("bolt", False)
    s.settle()
    hand_over(s, 2 * SECOND)
    assert s.row().q[1] != 0.0


@pytest.mark.parametrize("grants", [(), (0.13, 0.5000001, 1.1, 1.2, 1.9)])
def test_locking_a_joint_gives_the_same_bits_for_any_time_grants_and_in_interpreted_python(grants):
    def run(grants, native):
        s = started(double_pendulum(gravity=G), tolerance=1e-5, native=native)
        for lock, until in ((True, 1.0), (False, 2.0)):
            for g in (g for g in grants if until - 1.0 < g < until):
                s.run(round(g * SECOND))
            hand_over(s, round(until * SECOND))
            s.set_lock("bolt", lock)
            s.settle()
        s.interrupt(round(2.5 * SECOND))
        return s.state.copy()

    whole = run((), True)
    assert run(grants, True).tobytes() == whole.tobytes()
    assert run(grants, False) == pytest.approx(whole, rel=1e-10)


PLAIN = double_pendulum()


@pytest.mark.parametrize(
    ("system", "sentence"),
    [
        (replace(PLAIN, locks=(Lock("l", "knee"),)), "lock 'l': there is no joint 'knee'; known: shoulder, elbow"),
        (
            replace(PLAIN, locks=(Lock("l", "elbow"), Lock("m", "elbow"))),
            "lock 'm': joint 'elbow' already has the lock 'l'; remove one of them",
        ),
        (
            replace(PLAIN, drives=(Drive("d", "elbow", "prescribed"),)),
            "lock 'bolt': joint 'elbow' is moved by the prescribed drive 'd'; stop the drive instead",
        ),
        (
            replace(PLAIN, locks=(Lock("l", "elbow", engaged=True),)),
            "lock 'l': joint 'elbow' is locked at the start; its initial velocity must be zero",
        ),
        (
            replace(PLAIN, joints=(PLAIN.joints[0], replace(PLAIN.joints[1], kind="fixed", q0=(), v0=()))),
            "lock 'bolt': joint 'elbow' is fixed; there is nothing to lock",
        ),
        (
            replace(PLAIN, locks=(Lock("l", "elbow"), Lock("l", "shoulder"))),
            "'l': this name is used twice; names of force laws, drives and masters must be unique",
        ),
    ],
)
def test_impossible_locks_of_joints_are_refused(system, sentence):
    with pytest.raises(KernelError) as e:
        Simulation(system)
    assert str(e.value) == sentence


def test_a_command_to_an_unknown_lock_is_refused():
    s = at(PLAIN, 0)
    with pytest.raises(KernelError) as e:
        s.set_lock("nut", True)
    assert str(e.value) == "'nut': there is no lock with this name; there are bolt"
