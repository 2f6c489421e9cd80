"""Equilibria of a scene while its drives move: events, friction, folds and stability against closed forms."""

from dataclasses import replace
from itertools import pairwise
from math import acos, atan, cos, exp, sin

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.analysis import Corrector, EquilibriumPath, Poses, equilibrium
from heavylift.kernel.description import Body, Brake, Drive, Joint, Line, Point, Rope, Support, System
from heavylift.kernel.methods import AtRest
from heavylift.kernel.simulation import Simulation
from scipy.optimize import brentq
from small_scenes import EA, LENGTH, MASS, SECOND, G, Y, cube, hung, slider

LOCATED = 2e-6  # [s] to which events lie on the path
EXACT = 1e-7  # relative, of tensions: a corrector step of a nanometre on a rope of 1e9 N
DRAGGED = 2e-3  # of the rope: a slide's way is a chain of secants, as long as the steps of the path are
DIFFERENCES = 1e-6  # relative error of second-order differences


def following(system, heard=()):
    path = EquilibriumPath(Simulation(system, method=AtRest.name), frozenset(heard))
    path.start()
    return path


def moved(path, name, speed, way, accel=1e3):
    """A move whose ramps are too short to count."""
    path.command.set_profile(name, path.epoch, speed, accel, way)
    path.settle()


def tension(path):
    return float(path.points[-1].row.tension[0])


# ---- events ---------------------------------------------------------------------------------------------------


def lifted(slack):
    """A load on a stiff pad below a slack rope with a winch."""
    scene = hung(LENGTH - slack, winch=True)
    pad = Support("pad", Point("load"), -(LENGTH - slack), k=1e12, d=0.0)
    return replace(scene, supports=(pad,))


@pytest.mark.parametrize("slack", [0.01, 0.3, 7.0])
def test_a_rope_tightens_and_lifts_its_load_at_the_time_of_the_closed_form(slack):
    path, speed = following(lifted(slack), ("rope", "pad")), 0.05
    moved(path, "rope", -speed, -slack - 2.0)
    (taut,) = path.run(1000 * SECOND)
    ramp = speed / 1e3 / 2.0  # [s] by which a ramp is late
    assert (taut.name, taut.what) == ("rope", "taut")
    sunk = MASS * G / 1e12  # into the pad
    assert path.epoch * 1e-9 == pytest.approx((slack - sunk) / speed + ramp, abs=LOCATED)
    assert path.run(1000 * SECOND)[0].what == "open"
    length = LENGTH - slack
    L0 = length / (1.0 + MASS * G / EA)  # unstretched, of a rope that carries the load over this length
    assert path.epoch * 1e-9 == pytest.approx((LENGTH - L0) / speed + ramp, abs=LOCATED)
    assert tension(path) == pytest.approx(MASS * G, rel=1e-6)
    assert path.run(1000 * SECOND) == []
    assert path.points[-1].row.poses[2] == pytest.approx(-(LENGTH - slack - 2.0) * (1.0 + MASS * G / EA), rel=EXACT)


def test_ropes_of_two_winches_share_the_load_by_their_lengths():
    """A bar on two ropes 10 m apart; one winch alone hoists by 1 m: the bar leans, and each carries its half."""
    ropes = tuple(
        Rope(f"r{i}", (Line(Point("world", (x, 0.0, 50.0)), Point("bar", (x, 0.0, 0.0))),), EA, 50.0, winch=True)
        for i, x in enumerate((-5.0, 5.0))
    )
    scene = System((Body("bar", MASS, inertia=cube(MASS, 8.0)),), (Joint("free", "free", "world", "bar"),), ropes=ropes)
    path = following(scene)
    moved(path, "r0", -0.05, -1.0)
    path.run(100 * SECOND)
    p, R = path.points[-1].row.poses[:3], path.points[-1].row.poses[3:].reshape(3, 3)
    L0 = [49.0, 50.0]
    pulls = np.zeros(3)
    about = np.zeros(3)
    for x, L in zip((-5.0, 5.0), L0, strict=True):  # forces and moments, written again
        arm = R @ (x, 0.0, 0.0)
        rope = np.array([x, 0.0, 50.0]) - (p + arm)
        length = np.linalg.norm(rope)
        force = EA * (length / L - 1.0) * rope / length
        pulls, about = pulls + force, about + np.cross(arm, force)
    assert pulls == pytest.approx([0.0, 0.0, MASS * G], abs=1e-6 * MASS * G)
    assert about == pytest.approx(np.zeros(3), abs=1e-6 * MASS * G)


def test_the_equilibrium_path_ends_where_the_simulation_comes_to_rest():
    path = following(hung(LENGTH, winch=True))
    moved(path, "rope", -0.05, -3.0)
    path.run(1000 * SECOND)
    simulation = Simulation(replace(hung(LENGTH - 3.0, L0=LENGTH - 3.0), gravity=G))
    simulation.start()
    assert tension(path) == pytest.approx(equilibrium(simulation).tensions["rope"], rel=EXACT)


# ---- friction -------------------------------------------------------------------------------------------------


def test_in_statics_a_servo_on_a_slipping_brake_lags_behind_in_both_directions_of_its_motion():
    """A brake that slips at M on a servo kp: it follows M / kp behind, holds over 2 M / kp, and comes back so."""
    M, kp = 2e3, 1e4
    joint = Joint("guide", "prismatic", "world", "load", axis=Y)
    scene = System(
        (Body("load", 50.0),),
        (joint,),
        drives=(Drive("drive", "guide", "servo", kp, 1e3),),
        brakes=(Brake("brake", "guide", M, k=1e9, d=0.0, engaged=True),),
    )
    path = following(scene)
    moved(path, "drive", 0.1, 2.0)
    path.run(100 * SECOND)
    assert path.points[-1].q[0] == pytest.approx(2.0 - M / kp, rel=1e-5)
    moved(path, "drive", -0.1, -1.9 * M / kp)
    path.run(200 * SECOND)
    assert path.points[-1].q[0] == pytest.approx(2.0 - M / kp, abs=1e-4), "it holds where it has come to"
    moved(path, "drive", -0.1, -1.0)
    path.run(300 * SECOND)
    assert path.points[-1].q[0] == pytest.approx(2.0 - 1.9 * M / kp - 1.0 + M / kp, rel=1e-3)


def dragged(l, mu=0.3, m=1e3):
    """A load on a rough floor, on a rope of length l to a hook on rails along x that stands beside it."""
    axes = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
    chain = ("world", "long", "cross", "load")
    joints = [
        Joint(axis, "prismatic", *pair, axis=axes[axis]) for axis, pair in zip("xyz", pairwise(chain), strict=True)
    ]
    joints[1] = replace(joints[1], q0=(-l,))
    hook = Joint("rails", "prismatic", "world", "hook", axis=axes["x"])
    return System(
        (Body("long", 1e-3), Body("cross", 1e-3), Body("load", m), Body("hook", 1.0)),
        (*joints, hook),
        ropes=(Rope("rope", (Line(Point("hook"), Point("load")),), EA=1e9, L0=l),),
        supports=(Support("pad", Point("load"), m * G / 1e7, k=1e7, d=0.0, mu=mu, kt=1e7, dt=0.0),),
        drives=(Drive("drive", "rails", "prescribed"),),
    )


def test_a_load_dragged_by_a_rope_follows_a_tractrix():
    """Friction is against the way, so the way is along the rope: tan(theta / 2) falls as exp(-s / l) (Huygens)."""
    l, distance = 5.0, 12.0
    path = following(dragged(l))
    moved(path, "drive", 0.1, distance)
    path.run(200 * SECOND)
    *_, last = path.points
    theta = 2.0 * atan(exp(-distance / l))
    assert last.q[:2] == pytest.approx([distance - l * cos(theta), -l * sin(theta)], abs=DRAGGED * l)
    assert tension(path) == pytest.approx(0.3 * 1e3 * G, rel=EXACT)


def test_a_load_slides_along_its_guide_without_equilibrium_where_friction_cannot_hold_it():
    with pytest.raises(KernelError, match=r"body 'load' finds no rest: joint 'load-guide' still accelerates by 9\.81"):
        following(slider(q0=1.0))


# ---- folds and stability --------------------------------------------------------------------------------------


def pendulum(kp, m=100.0, l=2.0):
    """An upright rod on a servo: m g l sin(theta) = kp (theta - ref)."""
    body = Body("rod", m, (0.0, 0.0, l), ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    joint = Joint("pivot", "revolute", "world", "rod", axis=Y)
    return System((body,), (joint,), drives=(Drive("drive", "pivot", "servo", kp, 10.0),))


def test_a_rod_too_heavy_for_its_servo_falls_at_the_fold_of_the_equilibrium_path():
    """Leaning from -2.6 rad, the stable branch ends where m g l cos(theta) = kp."""
    torque = 100.0 * G * 2.0
    kp = 0.5 * torque
    scene = pendulum(kp)
    path = following(replace(scene, joints=(replace(scene.joints[0], q0=(-2.6,)),)))
    rests = brentq(lambda q: torque * sin(q) - kp * (q + 2.6), -3.2, -2.0)
    assert path.points[-1].q[0] == pytest.approx(rests, abs=1e-7)
    moved(path, "drive", 0.01, 4.0)
    path.run(1000 * SECOND)
    theta = -acos(kp / torque)  # the fold
    ref = theta - torque / kp * sin(theta)
    fold = next(note for note in path.notes if "falls" in note.sentence)
    assert fold.t_ns * 1e-9 == pytest.approx((ref + 2.6) / 0.01, abs=0.1), "as near as steps of the path go"
    end = path.points[-1].q[0]
    assert torque * sin(end) == pytest.approx(kp * (end - 1.4), abs=1e-3), "on the other branch"
    assert kp - torque * cos(end) > 0.0


@pytest.mark.parametrize("above", [-0.3, -0.01, 0.01, 0.3])
def test_a_load_with_its_centre_above_the_lugs_is_stable_below_its_metacentre(above):
    """Two ropes k, 2 a apart, L long: K = W [[1/L, -h/L], [-h/L, 2 k a^2 / W - h + h^2 / L]], whose determinant is
    W / L (2 k a^2 - W h): the metacentre lies 2 k a^2 / W above the lugs, however long the ropes are."""
    k, a, L, m, I = 2e6, 1.0, 30.0, 2e5, 4e5
    W = m * G
    T = W / 2.0
    metacentre = 2.0 * k * a * a / W
    h = metacentre * (1.0 + above)
    length = L * (1.0 + T / (k * L))
    across = Joint("plane", "planar", "world", "load", R_PJ=((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0)))
    body = Body("load", m, (0.0, h, 0.0), ((I, 0.0, 0.0), (0.0, I, 0.0), (0.0, 0.0, I)))
    ropes = tuple(
        Rope(f"r{i}", (Line(Point("world", (x, 0.0, length)), Point("load", (x, 0.0, 0.0))),), k * L, L)
        for i, x in enumerate((-a, a))
    )
    path = following(System((body,), (across,), ropes=ropes, gravity=G))
    roll = 2.0 * k * a * a * L / length + W * a * a / length - W * h + W * h * h / length
    K = np.array([[W / length, -W * h / length], [-W * h / length, roll]])
    smallest = float(np.linalg.eigvals(np.linalg.solve(np.diag([m, I]), K)).real.min())
    assert (smallest > 0.0) == (above < 0.0) or abs(above) < 0.02
    assert path.stiffness() == pytest.approx(smallest, rel=0.02, abs=2e-3)
    assert (path.stiffness() > 0.0) == (above < 0.0)


# ---- the tangent ----------------------------------------------------------------------------------------------


def crossed():
    """A block on three leaning ropes and a pad."""
    lugs = {"a": (-2.0, -1.0, 1.0), "b": (2.0, -1.5, 1.0), "c": (0.5, 2.0, 1.2)}
    ropes = tuple(
        Rope(n, (Line(Point("world", (1.3 * x, 0.8 * y, 12.0 + x)), Point("block", (x, y, z))),), 1e7, 9.0 + 0.2 * x)
        for n, (x, y, z) in lugs.items()
    )
    pad = Support("pad", Point("block", (0.0, 0.0, -1.0)), -1.2, k=1e6, d=1e3, mu=0.3, kt=1e6, dt=1e3)
    body = Body("block", 3e3, (0.1, 0.2, -0.1), cube(3e3, 3.0))
    return System((body,), (Joint("free", "free", "world", "block"),), ropes=ropes, supports=(pad,), gravity=G)


def test_the_tangent_stiffness_agrees_in_machine_code_and_interpreted_python_and_with_finite_differences():
    native, floats = (Poses(s) for s in (Simulation(crossed()), Simulation(crossed(), native=False)))
    for poses in (native, floats):
        poses.simulation.start()
    q = native.q
    K = native.stiffness(q)
    assert floats.stiffness(q) == pytest.approx(K, rel=1e-6, abs=1e-6 * np.abs(K).max())
    h = 1e-5
    for j, e in enumerate(np.eye(len(native.free))):
        ends = [native.accelerations(native.moved(q, x * h * e)) for x in (1.0, -1.0)]
        assert K[:, j] == pytest.approx((ends[0] - ends[1]) / (2.0 * h), rel=DIFFERENCES, abs=1e-5 * np.abs(K).max())


def test_the_factorised_tangent_stiffness_solves_its_linear_equations():
    poses = Poses(Simulation(crossed()))
    poses.simulation.start()
    K, a = poses.stiffness(poses.q), np.arange(1.0, 7.0)
    poses.factorise(K, 10.0, None)
    assert (np.eye(6) / 100.0 - K) @ poses.solve(a) == pytest.approx(a, rel=1e-9)
    assert poses.sign() == np.sign(np.linalg.det(np.eye(6) / 100.0 - K))


@pytest.mark.parametrize("seed", range(3))
def test_a_native_newton_step_is_the_solution_of_its_parts_to_the_last_bit(seed):
    draw = np.random.default_rng(seed)
    turning = Joint("turn", "revolute", "world", "arm", axis=Y)
    arm = Body("arm", 2e3, (1.0, 0.0, 0.0), cube(2e3, 2.0))
    hook = Rope("hook", (Line(Point("arm", (3.0, 0.0, 0.0)), Point("block", (0.5, 0.4, 1.0))),), 1e6, 2.0)
    scene = crossed()
    driven = Drive("drive", "turn", "prescribed")
    scene = replace(
        scene,
        bodies=(arm, *scene.bodies),
        joints=(turning, *scene.joints),
        ropes=(*scene.ropes, hook),
        drives=(driven,),
    )
    native, floats = (Poses(s) for s in (Simulation(scene), Simulation(scene, native=False)))
    for poses in (native, floats):
        poses.simulation.start()
        q = poses.moved(poses.q, 0.1 * np.ones(len(poses.free)))
    assert len(native.free) < native.simulation.program.nv
    for _ in range(3):
        q = native.moved(native.q, draw.uniform(-0.3, 0.3, len(native.free)))
        K = native.stiffness(q)
        for poses in (native, floats):
            poses.factorise(K, 10.0, None)
        a = native.accelerations(q)
        step = native.solve(a)
        size, distance, reached = native.newton_step(q)
        assert (size, distance) == (np.abs(a).max(), np.abs(step).max())
        assert (reached == native.moved(q, step)).all()
        others = floats.newton_step(q)
        assert others[:2] == pytest.approx((size, distance), rel=1e-9)
        assert others[2] == pytest.approx(reached, abs=1e-9)


def test_a_newton_step_from_a_pose_without_finite_accelerations_has_no_finite_size():
    poses = Poses(Simulation(crossed()))
    poses.simulation.start()
    poses.factorise(poses.stiffness(poses.q), 10.0, None)
    size, distance, _ = poses.newton_step(np.full(len(poses.q), np.nan))
    assert not np.isfinite([size, distance]).any()


# ---- what it costs --------------------------------------------------------------------------------------------


@pytest.fixture
def corrected(monkeypatch):
    """Times at which the corrector has looked for a rest [ns]."""
    times, whole = [], Corrector.corrected

    def counted(corrector, q):
        times.append(corrector._simulation.epoch)
        return whole(corrector, q)

    monkeypatch.setattr(Corrector, "corrected", counted)
    return times


@pytest.mark.parametrize("slack", [1e-3, 0.01, 0.3, 2.0, 7.0])
def test_path_following_locates_an_event_with_few_computed_equilibria(slack, corrected):
    """A guard of a slack rope is a length, of a taut one a force, 1e9 times as steep: no chord between them converges;
    a bracket of hours has 34 halves down to a microsecond."""
    path = following(lifted(slack), ("rope", "pad"))
    moved(path, "rope", -1e-3, -slack - 2.0)
    for what in ("taut", "open"):
        del corrected[:]
        assert path.run(10_000 * SECOND)[0].what == what
        behind = next(i for i, t in enumerate(corrected) if t > path.epoch)  # the step in which it is
        assert len(corrected) - behind <= 18, "of which some follow from it"


def test_path_following_takes_few_steps_along_a_straight_path_of_equilibria(corrected):
    """A load is hoisted by 40 of 50 m: its rope is stretched by a nanometre for a newton, but its path is a line."""
    path = following(hung(LENGTH, winch=True))
    moved(path, "rope", -0.05, -0.8 * LENGTH)
    del corrected[:]
    path.run(10_000 * SECOND)
    assert tension(path) == pytest.approx(MASS * G, rel=EXACT)
    assert len(corrected) <= 20
