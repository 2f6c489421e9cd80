"""Loops: any joint may close one; accelerations, drift, redundancy, singular poses, assembly."""

import json
from dataclasses import replace
from pathlib import Path
from re import fullmatch

import numpy as np
import pinocchio as pin
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.constraints import CLOSURES
from heavylift.kernel.description import JOINTS, WORLD, Body, Drive, Joint, JointSpring, System
from linkages import looped, relative, rod, windows
from random_trees import pinocchio_model
from small_scenes import SECOND, G, X, Y, Z, column, cube, hand_over, started

AGREES = 1e-9  # of the largest acceleration: two formulations in double precision
DRIFT = 1e-9  # [m or rad] the requirement over 1000 s
FOLLOWS = 1e-6  # of the exact motion of A02 after 20 s at tolerance 1e-10
CLOSES = 1e-8  # energy of the turned-over energy over some seconds at tolerance 1e-9
SHARES = 1e-6  # relative: equal rows carry equal loads


def accelerations(s):
    nq, nv = s.program.nq, s.program.nv
    return s.X[s.method.layout.at["f"]][nq : nq + nv]


@pytest.mark.parametrize("seed", [2, 12, 24, 34, 39, 55])
def test_random_loops_have_the_accelerations_of_pinocchio(seed):
    """One to three ball joints between the bodies of random trees; what is cut must be a row type of Pinocchio."""
    system, _, _ = looped(seed, ("spherical",) * (1 + seed % 3))
    s = started(system, native=False)
    graph = s.program.graph
    assert {j.kind for j in graph.loops} == {"spherical"}
    model = pinocchio_model(graph)
    frames = {name: (on, place) for name, on, place in _frames(model, graph)}
    loops = pin.StdVec_RigidConstraintModel()
    for j in graph.loops:
        (ja, Ma), (jb, Mb) = frames[j.parent], frames[j.child]
        at_a, at_b = Ma * pin.SE3(np.array(j.R_PJ), np.array(j.p_PJ)), Mb * pin.SE3(np.array(j.R_CJ), np.array(j.p_CJ))
        loops.append(
            pin.RigidConstraintModel(pin.ContactType.CONTACT_3D, model, ja, at_a, jb, at_b, pin.ReferenceFrame.LOCAL)
        )
    data, datas = model.createData(), pin.StdVec_RigidConstraintData()
    datas.extend(c.createData() for c in loops)
    pin.initConstraintDynamics(model, data, loops, datas)
    settings = pin.ProximalSettings(1e-14, 1e-10, 50)
    y, nq, nv = s.state, s.program.nq, s.program.nv
    want = pin.constraintDynamics(model, data, y[:nq], y[nq : nq + nv], np.zeros(nv), loops, datas, settings)
    assert np.abs(accelerations(s) - want).max() < AGREES * np.abs(want).max()


def _frames(model, graph):
    yield WORLD, 0, pin.SE3.Identity()
    at = {}
    for link in graph.links:
        on, place = (0, pin.SE3.Identity()) if link.parent < 0 else at[graph.links[link.parent].body.name]
        place = place * pin.SE3(np.array(link.joint.R_PJ), np.array(link.joint.p_PJ))
        made = [i for i, name in enumerate(model.names) if name.startswith(f"{link.joint.name}.")]
        if made:
            on, place = made[-1], pin.SE3.Identity()
        at[link.body.name] = (on, place)
        yield link.body.name, on, place


KINDS = [kind for kind, rows in CLOSURES.items() if rows]
AXIS, SECOND_AXIS, PITCH = (1.0, 0.0, 0.0), (0.0, 0.6, 0.8), 0.3


def pitch(kind):
    return PITCH if JOINTS[kind].pitched else 0.0


def doubled(kind):
    """A cart and what hangs on it by a joint, which a second one doubles."""
    turned = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    cart = Joint("cart-joint", "free", WORLD, "cart", v0=(0.1, 0.2, -0.1, 0.3, 0.1, 0.2))
    once = Joint("once", kind, "cart", "load", (0.5, 0.2, -0.3), turned, AXIS, SECOND_AXIS, pitch(kind))
    bodies = (Body("cart", 5.0, (0.1, 0.0, 0.2), cube(5.0)), Body("load", 2.0, (0.2, 0.1, -1.0), cube(2.0)))
    return System(bodies, (cart, once)), System(bodies, (cart, once, replace(once, name="twice")))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.large(beyond=3)
def test_doubling_a_loop_joint_of_any_type_does_not_change_the_motion(kind):
    """The closing joint's rows hold along the whole motion of the same joint in the tree, and do no work on it."""
    one, two = (started(x, tolerance=1e-10, h_max=0.05) for x in doubled(kind))
    assert [j.name for j in two.program.graph.loops] == ["twice"]
    for s in (one, two):
        nq = s.program.nq
        s.state[nq + 6 : nq + s.program.nv] = np.linspace(0.4, 0.8, s.program.nv - 6)
        s.settle()
        hand_over(s, 3 * SECOND)
    n = one.program.nq + one.program.nv
    assert two.state[:n] == pytest.approx(one.state[:n], rel=0.0, abs=1e-7)


def held(kind):
    """A load on an arm that flies free, tied to a strut of its own by a joint of this kind, which closes the loop."""
    swing = Joint("swing", "revolute", WORLD, "arm", axis=X, q0=(0.3,), v0=(0.5,))
    ball = Joint("ball", "spherical", "arm", "load", (0.0, 0.0, -2.0))
    side = Joint("side", "spherical", WORLD, "strut", (1.5, 0.4, 0.0))
    closing = Joint(
        "closing", kind, "strut", "load", (0.0, 0.3, -1.5), axis=SECOND_AXIS, second=AXIS, pitch=pitch(kind)
    )
    bodies = (Body("arm", 4.0, (0.0, 0.0, -1.0), cube(4.0)), Body("load", 2.0, (0.1, 0.2, -0.5), cube(2.0)))
    strut = Body("strut", 3.0, (0.0, 0.2, -0.7), cube(3.0, 1.0))
    grounded = replace(swing, kind="free", q0=(0.3, 0.2, -0.1, 0.0, 0.0, 0.0, 1.0), v0=())
    return System((*bodies, strut), (grounded, ball, side, closing))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.large(beyond=3)
def test_a_loop_closed_by_any_joint_type_stays_closed_and_conserves_energy(kind):
    system = held(kind)
    s = started(system, tolerance=1e-9, sample_ns=100_000_000, h_max=0.05)
    (cut,) = s.program.graph.loops
    s.run(4 * SECOND)
    at = {name: column(s, f"pose/{name}")[1] for name in ("arm", "load", "strut")}
    for row in range(len(s.rows)):
        places = {name: (p[row, :3], pin.Quaternion(p[row, 3:]).matrix()) for name, p in at.items()}
        d, turn = relative(places[cut.parent], places[cut.child], cut)
        assert off(cut, d, turn) < DRIFT
    _, e = column(s, "energy")
    total = e[:, 0] + e[:, 1]
    assert np.ptp(total) < CLOSES * np.ptp(e[:, 0])


def off(j, d, turn):
    """How far a relative pose is from what a joint allows, seen through its own coordinates."""
    a, b = np.array(j.axis), np.array(j.second)
    c = np.cross(a, b)
    R = pin.exp3(turn)
    tilt = float(np.linalg.norm(R @ a - a))
    along = np.abs([d @ a, d @ b, d @ c])
    turns = (float(np.arctan2(c @ R @ b, b @ R @ b)) - d @ a / (j.pitch or 1.0)) / (2.0 * np.pi)
    return {
        "fixed": max(along.max(), np.abs(turn).max()),
        "revolute": max(along.max(), tilt),
        "prismatic": max(along[1:].max(), np.abs(turn).max()),
        "cylindrical": max(along[1:].max(), tilt),
        "screw": max(along[1:].max(), tilt, abs(turns - round(turns))),
        "universal": max(along.max(), abs(a @ R @ b)),
        "planar": max(along[0], tilt),
        "constant-velocity": max(along.max(), abs(turn @ a)),
        "spherical": along.max(),
    }[j.kind]


def reference(name):
    path = Path(__file__).parents[2] / "data" / "linkages.json"
    return json.loads(path.read_text())[name]


def test_a_chain_of_two_four_bar_linkages_follows_the_exact_motion_through_singular_poses():
    """IFToMM A02, N = 2: redundant rows, and all rods in one line some thirty times in 20 s."""
    s = started(windows(2), tolerance=1e-10)
    s.run(21 * SECOND)
    t, pose = column(s, "pose/upright0")
    for at, (x, z) in reference("A02 N=2").items():
        R = pin.Quaternion(pose[np.searchsorted(t, float(at) - 1e-6), 3:]).matrix()
        assert R[:, 2] == pytest.approx([x, 0.0, z], rel=0.0, abs=FOLLOWS)


def test_closed_loops_do_not_drift_apart_in_a_thousand_seconds():
    s = started(windows(1, omega=0.0, theta=2.5), sample_ns=SECOND)
    s.run(1001 * SECOND)
    _, left = column(s, "pose/bar0")
    _, right = column(s, "pose/upright1")
    end = np.array([p[:3] + pin.Quaternion(p[3:]).matrix() @ [0.0, 0.0, 1.0] for p in left])
    top = np.array([p[:3] + pin.Quaternion(p[3:]).matrix() @ [0.0, 0.0, 1.0] for p in right])
    assert len(end) > 1000
    assert np.abs(end - top).max() < DRIFT


def test_equal_redundant_joints_share_their_load_equally():
    """A crate on four equal hinges; the joint that carries it in the tree lets it go where its weight pulls."""
    crate = Body("crate", 100.0, (0.0, 0.0, -1.0), cube(100.0))
    plane = Joint("plane", "planar", WORLD, "crate", axis=Y, second=X)
    hinges = [Joint(f"hinge{i}", "revolute", WORLD, "crate", axis=Y) for i in range(4)]
    s = started(System((crate,), (plane, *hinges), springs=(JointSpring("free", "plane", coordinate="angle"),)))
    _, force = column(s, "loop/force")
    _, moment = column(s, "loop/moment")
    assert np.abs(force[0].reshape(4, 3)) == pytest.approx(np.outer(np.ones(4), (0.0, 0.0, 100.0 * G / 4)), rel=SHARES)
    assert np.isfinite(moment).all()


def test_machine_code_and_interpreted_python_agree_on_closed_loops():
    system = held("revolute")
    native, floats = (started(system, native=x) for x in (True, False))
    for s in (native, floats):
        hand_over(s, SECOND // 5)
    assert native.state == pytest.approx(floats.state, rel=0.0, abs=1e-12)


def test_closed_loops_in_a_start_pose_are_kept_and_open_loops_are_closed():
    closed = started(windows(1))
    assert closed.state[: closed.program.nq].tolist() == [0.0, np.pi / 2, 0.0]
    system = windows(1)
    bent = tuple(replace(j, q0=(1.4,)) if j.name == "left0" else j for j in system.joints)
    s = started(replace(system, joints=bent), sample_ns=SECOND)
    _, left = column(s, "pose/bar0")
    _, right = column(s, "pose/upright1")
    end = left[0, :3] + pin.Quaternion(left[0, 3:]).matrix() @ [0.0, 0.0, 1.0]
    top = right[0, :3] + pin.Quaternion(right[0, 3:]).matrix() @ [0.0, 0.0, 1.0]
    assert end == pytest.approx(top, rel=0.0, abs=DRIFT)


GUIDE = Joint("guide", "prismatic", WORLD, "load", axis=Z)
LONG = tuple(replace(j, p_CJ=(0.0, 0.0, 4.0)) if j.name == "right0" else j for j in windows(1).joints)
REFUSED = [
    (
        replace(windows(1), joints=LONG),
        "joint 'right0': its loop does not close; a gap of 10.. mm is left of 3000 mm in the initial pose: "
        "change the dimensions or the initial coordinates",
    ),
    (
        System((Body("load", 1.0),), (GUIDE, replace(GUIDE, name="across", axis=X))),
        "joint 'across': the loops leave nothing free to move; "
        "give one of their joints another degree of freedom, or connect the bodies by fixed joints",
    ),
    (
        System((Body("load", 1.0, inertia=cube(1.0)),), (GUIDE, Joint("f", "free", WORLD, "load"))),
        "joint 'f': a free joint constrains nothing, and 'guide' carries 'load' already; remove it",
    ),
    (
        System((Body("load", 1.0),), (replace(GUIDE, parent="load"),)),
        "joint 'guide': it connects 'load' to itself; give it another parent or child",
    ),
    (
        System(
            (Body("load", 1.0),),
            (GUIDE, replace(GUIDE, name="b")),
            springs=(JointSpring("s", "guide"), JointSpring("s2", "b")),
        ),
        "joint 'b': 's2' needs a coordinate, but this joint closes a loop and has none; "
        "remove all laws from one joint of the loop, so that that joint closes the loop",
    ),
]


@pytest.mark.parametrize(("system", "sentence"), REFUSED, ids=[s[:40] for _, s in REFUSED])
def test_linkages_that_cannot_close_are_refused(system, sentence):
    with pytest.raises(KernelError) as e:
        started(system)
    assert fullmatch(sentence, str(e.value))


def test_a_drive_motion_that_a_linkage_cannot_follow_is_reported():
    """A crank turned by force in a linkage in which it can only rock."""
    crank, rocker = rod("crank"), rod("rocker", 0.5)
    joints = (
        Joint("motor", "revolute", WORLD, "crank", axis=Y, q0=(0.2,)),
        Joint("pin", "revolute", "crank", "coupler", Z, axis=Y, q0=(1.4,)),
        Joint("pivot", "revolute", WORLD, "rocker", (1.2, 0.0, 0.0), axis=Y),
        Joint("end", "revolute", "rocker", "coupler", (0.0, 0.0, 0.5), axis=Y, p_CJ=Z),
    )
    drive = Drive("turn", "motor", "prescribed")
    s = started(System((crank, rod("coupler"), rocker), joints, drives=(drive,)))
    s.references.set_profile("turn", 0, 1.0, 1.0, None)
    s.settle()
    with pytest.raises(KernelError) as e:
        s.run(20 * SECOND)
    assert str(e.value).startswith("constraint lost at joint 'end' ")
