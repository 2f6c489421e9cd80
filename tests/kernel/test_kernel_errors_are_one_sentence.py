"""Whatever a user did wrong ends in one sentence that names it; nothing hangs, nothing is silently accepted."""

from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest
from heavylift.kernel.contact.describe import Ball, Box, Contact, Plane
from heavylift.kernel.describe import (
    Body,
    Brake,
    Drive,
    Joint,
    JointSpring,
    Line,
    Master,
    Measured,
    Point,
    Rope,
    Stop,
    Support,
    System,
    Threshold,
)  # fmt: skip
from heavylift.kernel.errors import KernelError
from heavylift.kernel.flexible.description import Beam, Flexible
from heavylift.kernel.methods import METHODS
from heavylift.kernel.rate import Program
from heavylift.kernel.simulation import Simulation
from heavylift.kernel.switching import Switches
from small_scenes import SECOND, X, Z, hand_over, hung, slider, started

ONE = slider("a")
BODY, GUIDE = ONE.bodies[0], ONE.joints[0]
LINE = (Line(Point("world"), Point("a")),)
ROPE = Rope("rope", LINE, 1e8, 10.0)
BEAM = Beam(10.0, 5.0, EI_y=1e6)
SHEARED = ((1.0, 0.5, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
LEFT_HANDED = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0))
COORDINATES = (("dt", "travel"), ("ea", "angle"), ("ft", "travel"))
FLOAT = Joint("float", "free", "world", "a")


def diagonal(a, b, c):
    return ((a, 0.0, 0.0), (0.0, b, 0.0), (0.0, 0.0, c))


def with_(**parts):
    return replace(ONE, **parts)


DESCRIPTIONS = [
    # the graph
    (with_(bodies=(BODY, BODY)), "body 'a': two of this name; names must be unique"),
    (with_(joints=(GUIDE, GUIDE)), "joint 'a-guide': two of this name; names must be unique"),
    (with_(joints=(replace(GUIDE, child="b"),)), "joint 'a-guide': there is no body 'b'"),
    (with_(joints=(replace(GUIDE, parent="b"),)), "joint 'a-guide': there is no body 'b'"),
    (with_(joints=()), "body 'a': no joint connects it to the ground; add one (kind free if it floats)"),
    (
        with_(joints=(replace(GUIDE, parent="a"),)),
        "joint 'a-guide': it joins 'a' to itself; give it another parent or child",
    ),
    (
        with_(bodies=(Body("world", 1.0),), joints=(replace(GUIDE, child="world"),)),
        "body 'world': this is the name of the ground; choose another one",
    ),
    (with_(bodies=(Body("a", -1.0),)), "body 'a': mass -1 kg; a mass cannot be negative"),
    (with_(joints=(replace(GUIDE, q0=(0.0, 1.0)),)), "joint 'a-guide': 2 initial coordinates; a prismatic joint has 1"),
    (with_(joints=(replace(GUIDE, v0=(0.0, 1.0)),)), "joint 'a-guide': 2 initial velocities; a prismatic joint has 1"),
    (
        with_(
            bodies=(BODY, Body("b", 1.0), Body("c", 1.0)),
            joints=(GUIDE, replace(GUIDE, name="j", parent="c", child="b"), replace(FLOAT, parent="b", child="c")),
        ),
        "body 'b': the joints that carry it go in a circle and never reach the ground: 'j', 'float'",
    ),
    (
        with_(joints=(replace(GUIDE, kind="hinge"),)),
        "joint 'a-guide': kind is 'hinge'; it must be fixed, revolute, prismatic, cylindrical, screw, universal, "
        "planar, constant-velocity, spherical, free or slider",
    ),
    # axes
    (
        with_(joints=(replace(GUIDE, kind="universal", second=(0.0, 0.6, 0.8)),)),
        "joint 'a-guide': its axes stand at 36.87 deg; the second axis of a universal joint is perpendicular to the "
        "first",
    ),
    (
        with_(joints=(replace(GUIDE, kind="planar", second=(0.0, 2.0, 0.0)),)),
        "joint 'a-guide': its second axis has length 2; it must be a unit vector",
    ),
    (
        with_(joints=(replace(GUIDE, kind="screw"),)),
        "joint 'a-guide': its pitch is 0; a screw advances, in m/rad (else make it revolute)",
    ),
    (with_(joints=(replace(GUIDE, pitch=0.1),)), "joint 'a-guide': pitch is 0.1; a prismatic joint has none"),
    # numbers
    (with_(bodies=(Body("a", nan),)), "body 'a': mass is nan; it must be a finite number"),
    (with_(bodies=(Body("a", 1.0, (0.0, inf, 0.0)),)), "body 'a': com is inf; it must be a finite number"),
    (with_(bodies=(Body("a", 1.0, inertia=SHEARED),)), "body 'a': its inertia must be a symmetric matrix"),
    (
        with_(bodies=(Body("a", 1.0, inertia=diagonal(1.0, 5.0, 3.0)),)),
        "body 'a': its principal moments of inertia are 1, 3, 5 kg m2; no body has one that is larger than the sum of "
        "the others",
    ),
    (
        with_(bodies=(Body("a", 1.0, inertia=((1.0, 2.0, 0.0), (2.0, 1.0, 0.0), (0.0, 0.0, 1.0))),)),
        "body 'a': its principal moments of inertia are -1, 1, 3 kg m2; none can be negative",
    ),
    (with_(joints=(replace(GUIDE, p_PJ=(nan, 0.0, 0.0)),)), "joint 'a-guide': p_PJ is nan; it must be a finite number"),
    (with_(joints=(replace(GUIDE, q0=(-inf,)),)), "joint 'a-guide': q0 is -inf; it must be a finite number"),
    (
        with_(joints=(replace(GUIDE, axis=(1.0, 1.0, 0.0)),)),
        "joint 'a-guide': its axis has length 1.41421; it must be a unit vector",
    ),
    *(
        (
            with_(joints=(replace(GUIDE, R_PJ=R),)),
            "joint 'a-guide': R_PJ is not a rotation; its rows must be right-handed unit vectors",
        )
        for R in (SHEARED, LEFT_HANDED)
    ),
    (
        with_(joints=(replace(FLOAT, q0=(0.0,) * 7),)),
        "joint 'float': its initial quaternion is zero; it must have length 1",
    ),
    (with_(gravity=nan), "gravity is nan; it must be a finite number"),
    (with_(ropes=(replace(ROPE, EA=nan),)), "rope 'rope': EA is nan; it must be a finite number"),
    (with_(ropes=(replace(ROPE, EA=0.0),)), "rope 'rope': EA is 0; it must be positive"),
    (with_(ropes=(replace(ROPE, L0=-3.0),)), "rope 'rope': L0 is -3; it must be positive"),
    (with_(ropes=(replace(ROPE, damping=-1.0),)), "rope 'rope': damping is -1; it cannot be negative"),
    (with_(ropes=(replace(ROPE, lines=()),)), "rope 'rope': it has no line; give it at least one"),
    (
        with_(ropes=(replace(ROPE, lines=(Line(Point("a", (0.0, 0.0, nan)), Point("world")),)),)),
        "rope 'rope': lines is nan; it must be a finite number",
    ),
    (
        with_(supports=(Support("pad", Point("a"), 0.0, 1e6, -1.0),)),
        "support 'pad': d is -1; it cannot be negative",
    ),
    (
        with_(springs=(JointSpring("spring", "a-guide", -1.0),)),
        "spring 'spring': k is -1; it cannot be negative",
    ),
    (
        with_(stops=(Stop("stop", "a-guide", 1.0, -1.0, 1e6, 0.0),)),
        "stop 'stop': its lower limit 1 lies above the upper one, -1",
    ),
    (
        with_(brakes=(Brake("brake", "a-guide", -1.0, 1e6, 0.0),)),
        "brake 'brake': moment is -1; it cannot be negative",
    ),
    # types and shapes
    ({}, "the description is {}; it must be a System"),
    (with_(gravity=None), "gravity is None; it must be a number"),
    (with_(bodies=(GUIDE, *ONE.bodies)), f"bodies: {str(GUIDE)[:57]}... is none of them; it must be a Body"),
    (with_(bodies=(Body(7, 1.0),)), "body 7: name is 7; it must be a text"),
    (with_(bodies=(Body("a", "heavy"),)), "body 'a': mass is 'heavy'; it must be a number"),
    (with_(bodies=(Body("a", None),)), "body 'a': mass is None; it must be a number"),
    (
        with_(bodies=(Body("a", 1.0, inertia=((1.0,),)),)),
        "body 'a': inertia is ((1.0,),); it must be 3 rows of 3 numbers",
    ),
    (with_(joints=(replace(GUIDE, axis=(1.0, 0.0)),)), "joint 'a-guide': axis is (1.0, 0.0); it must be 3 numbers"),
    (
        with_(joints=(replace(GUIDE, R_PJ=((1.0, 0.0), (0.0, 1.0))),)),
        "joint 'a-guide': R_PJ is ((1.0, 0.0), (0.0, 1.0)); it must be 3 rows of 3 numbers",
    ),
    (with_(joints=(replace(GUIDE, p_PJ=np.full(3, nan)),)), "joint 'a-guide': p_PJ is nan; it must be a finite number"),
    (with_(joints=(replace(GUIDE, q0=[nan]),)), "joint 'a-guide': q0 is nan; it must be a finite number"),
    (with_(bodies=(Body("a", np.float32(nan)),)), "body 'a': mass is nan; it must be a finite number"),
    (with_(ropes=(replace(ROPE, EA="x"),)), "rope 'rope': EA is 'x'; it must be a number"),
    (with_(ropes=(replace(ROPE, lines=(7,)),)), "rope 'rope': lines is 7; it must be a Line"),
    (
        with_(contacts=(Contact("c", Box("a", size=(1.0, 1.0)), Plane()),)),
        "contact 'c': a.size is (1.0, 1.0); it must be 3 numbers",
    ),
    (
        with_(contacts=(Contact("c", Plane(), Plane()),)),
        f"contact 'c': a is {str(Plane())[:57]}...; it must be a Ball or a Box",
    ),
    (
        with_(bodies=(Body("a", 1.0, flexible=Flexible(2, BEAM, frame="foo")),)),
        "body 'a': flexible.frame is 'foo'; it must be clamped, simply supported or free",
    ),
    (
        with_(bodies=(Body("a", 1.0, flexible=Flexible(2, replace(BEAM, elements=2.5))),)),
        "body 'a': flexible.beam.elements is 2.5; it must be a whole number",
    ),
    (
        with_(bodies=(Body("a", 1.0, flexible=Flexible(2.5, BEAM)),)),
        "body 'a': flexible.modes is 2.5; it must be a whole number",
    ),
    # laws
    (
        with_(springs=(JointSpring("spring", "b-guide"),)),
        "joint 'b-guide': no such joint; joints are a-guide",
    ),
    (
        with_(joints=(replace(GUIDE, kind="cylindrical", q0=(), v0=()),), springs=(JointSpring("spring", "a-guide"),)),
        "'spring': say which coordinate of the cylindrical joint 'a-guide': travel or angle",
    ),
    (
        with_(springs=(JointSpring("spring", "a-guide", coordinate="angle"),)),
        "'spring': joint 'a-guide' is prismatic; it has no coordinate 'angle' but travel",
    ),
    (
        with_(joints=(replace(GUIDE, kind="fixed", q0=(), v0=()),), springs=(JointSpring("spring", "a-guide"),)),
        "'spring': nothing can act along joint 'a-guide', which is fixed: nothing moves in it",
    ),
    (
        with_(
            joints=(replace(GUIDE, kind="cylindrical", q0=(), v0=()),),
            drives=tuple(Drive(n, "a-guide", "servo", coordinate=c) for n, c in COORDINATES),
        ),
        "drive 'ft': joint 'a-guide' already has the drive 'dt'",
    ),
    (
        with_(joints=(FLOAT,), brakes=(Brake("brake", "float", 1.0, 1.0, 1.0),)),
        "'brake': nothing can act along joint 'float', which is free: no velocity of it is the rate of a coordinate",
    ),
    (
        with_(drives=(Drive("d", "a-guide", "servo"), Drive("e", "a-guide", "servo"))),
        "drive 'e': joint 'a-guide' already has the drive 'd'",
    ),
    (with_(ropes=(replace(ROPE, lines=(Line(Point("b"), Point("a")),)),)), "'rope': there is no body 'b'"),
    (with_(supports=(Support("pad", Point("b"), 0.0, 1.0, 1.0),)), "'pad': there is no body 'b'"),
    (with_(measured=(Measured("theta", "angle", "b"),)), "'theta': there is no body 'b'"),
    (with_(measured=(Measured("way", "joint", "b"),)), "joint 'b': no such joint; joints are a-guide"),
    (
        with_(joints=(FLOAT,), measured=(Measured("way", "joint", "float"),)),
        "'way': nothing can act along joint 'float', which is free: no velocity of it is the rate of a coordinate",
    ),
    (with_(thresholds=(Threshold("t", "angle", of="b"),)), "'t': there is no body 'b'"),
    (with_(thresholds=(Threshold("t", "speed", of="b"),)), "joint 'b': no such joint; joints are a-guide"),
    (with_(thresholds=(Threshold("t", "height"),)), "threshold 't': a height needs a point"),
    (with_(thresholds=(Threshold("t", "tension"),)), "threshold 't': a tension needs a rope"),
    (with_(thresholds=(Threshold("t", "length", ropes=("r",)),)), "threshold 't': there is no rope 'r'"),
    (
        with_(ropes=(ROPE, ROPE)),
        "'rope': two of this name; names of laws, drives and masters must be unique",
    ),
    (
        with_(ropes=(ROPE,), masters=(Master("rope"),)),
        "'rope': two of this name; names of laws, drives and masters must be unique",
    ),
    (
        with_(ropes=(ROPE,), thresholds=(Threshold("rope", "tension", ropes=("rope",)),)),
        "'rope': two of this name; names of laws, drives and masters must be unique",
    ),
]


@pytest.mark.parametrize(("system", "sentence"), DESCRIPTIONS, ids=[s[:60] for _, s in DESCRIPTIONS])
def test_descriptions_that_cannot_be(system, sentence):
    with pytest.raises(KernelError) as e:
        Program(system)
    assert str(e.value) == sentence


@pytest.mark.parametrize(
    ("system", "options", "sentence"),
    [
        (
            System((Body("a", 1.0),), (Joint("weld", "fixed", "world", "a"),)),
            {},
            "nothing in this scene can move: all joints are fixed",
        ),
        (
            with_(bodies=(Body("a", 0.0),)),
            {},
            "body 'a': nothing resists its motion; give it, or what it carries, mass or inertia",
        ),
        (
            with_(bodies=(Body("a", 1.0, (0.0, 0.6, 0.8)),), joints=(Joint("ball", "spherical", "world", "a"),)),
            {},
            "body 'a': nothing resists its motion in joint 'ball'; give it, or what it carries, mass or inertia",
        ),
        (
            System(
                (Body("a", 1.0, inertia=diagonal(1.0, 1.0, 1.0)), Body("b", 2.0, (0.0, 0.3, 0.4))),
                (Joint("j", "spherical", "world", "a"), Joint("k", "revolute", "a", "b", X, axis=(0.0, 0.6, 0.8))),
            ),
            {},
            "body 'b': nothing resists its motion in joint 'k'; give it, or what it carries, mass or inertia",
        ),
        (ONE, {"tolerance": 0.0}, "tolerance 0: it must lie between 1e-14 and 1"),
        (ONE, {"tolerance": nan}, "tolerance nan: it must lie between 1e-14 and 1"),
        (ONE, {"sample_ns": 0}, "samples every 0 ns: they must be at least 100000 ns apart"),
        (
            ONE,
            {"method": "euler"},
            f"method 'euler': there is none of this name; choose one of {', '.join(METHODS)}",
        ),
        (ONE, {"method": "rk4"}, "method 'rk4': it has no error estimate; give it a step, such as 0.001 s"),
        (ONE, {"tolerance": 1e-30}, "tolerance 1e-30: it must lie between 1e-14 and 1"),
        (ONE, {"tolerance": "a"}, "tolerance is 'a'; it must be a number"),
        (ONE, {"h_max": nan}, "h_max nan s: the longest step must be positive and finite"),
        (ONE, {"h_max": 0.0}, "h_max 0 s: the longest step must be positive and finite"),
        (ONE, {"h_max": -1.0}, "h_max -1 s: the longest step must be positive and finite"),
        (ONE, {"h_max": 1e9}, "a step of 1e+09 s has more than 1000000 samples; make it shorter"),
        (ONE, {"opt": 9}, "opt 9: the compiler's levels are 0, 1, 2 and 3"),
        (ONE, {"step": 0.0}, "step 0 s: a fixed step must be at least 1e-09 s and finite"),
        (ONE, {"step": nan}, "step nan s: a fixed step must be at least 1e-09 s and finite"),
    ],
)
def test_simulations_that_cannot_start(system, options, sentence):
    with pytest.raises(KernelError) as e:
        Simulation(system, cache=False, **options)
    assert str(e.value) == sentence


def driven():
    scene = replace(
        hung(60.1, winch=True),
        bodies=(Body("load", 4.5e5), Body("b", 1.0), Body("c", 1.0)),
        joints=(
            *hung(60.1).joints,
            Joint("rail", "prismatic", "world", "b", axis=X),
            Joint("other", "prismatic", "world", "c", axis=X),
        ),
        drives=(Drive("drive", "rail", "prescribed"),),
        masters=(Master("theta"),),
        measured=(Measured("way", "joint", "other"),),
        brakes=(Brake("brake", "other", 1.0, 1.0, 1.0),),
        thresholds=(Threshold("low", "joint", of="other"),),
    )
    return replace(scene, ropes=(*scene.ropes, Rope("sling", (Line(Point("world"), Point("b")),), 1e8, 5.0)))


COMMANDS = [
    (
        lambda s: s.references.set_profile("x", 0, 1.0, 1.0, None),
        "'x': no drive, winch or master of this name; there are theta, drive, rope, sling",
    ),
    (
        lambda s: s.references.set_profile("sling", 0, 1.0, 1.0, 1.0),
        "rope 'sling': it has no winch; declare one to drive it",
    ),
    (
        lambda s: s.references.set_profile("rope", SECOND, 1.0, 0.0, 1.0),
        "'rope' at 1.000 s: acceleration must be positive, not 0.0",
    ),
    (
        lambda s: s.references.set_profile("rope", 0, 1.0, inf, 1.0),
        "'rope' at 0.000 s: acceleration must be positive, not inf",
    ),
    (
        lambda s: s.references.set_profile("rope", 0, 0.0, 1.0, 1.0),
        "'rope' at 0.000 s: a distance cannot be travelled at speed 0",
    ),
    (
        lambda s: s.references.set_profile("rope", 0, nan, 1.0, None),
        "'rope' at 0.000 s: speed nan and distance None must be finite numbers",
    ),
    (
        lambda s: s.references.set_profile("rope", 0, 1.0, 1.0, inf),
        "'rope' at 0.000 s: speed 1.0 and distance inf must be finite numbers",
    ),
    (
        lambda s: s.set_follow("sling", "theta", (1.0, 0.0, 0.0)),
        "rope 'sling': it has no winch; declare one to drive it",
    ),
    (
        lambda s: s.set_follow("rope", "x", (1.0, 0.0, 0.0)),
        "'rope' cannot follow 'x': masters are theta, way",
    ),
    (
        lambda s: s.set_follow("theta", "way", (1.0, 0.0, 0.0)),
        "'theta' cannot follow 'way': masters are theta, way",
    ),
    (
        lambda s: s.set_follow("drive", "way", (1.0, 0.0, 0.0)),
        "'drive' cannot follow 'way': a prescribed drive follows commanded masters only",
    ),
    (
        lambda s: s.set_follow("rope", "theta", (nan, 0.0, 0.0)),
        "'rope' cannot follow (nan, 0.0, 0.0): the coefficients must be finite numbers",
    ),
    (lambda s: s.set_brake("x", True), "'x': no brake of this name; there are brake"),
    (lambda s: s.switches.watch("x", 1.0, True), "'x': no threshold of this name; there are low"),
    (lambda s: s.switches.unwatch("x"), "'x': no threshold of this name; there are low"),
    (
        lambda s: s.switches.watch("low", nan, True),
        "threshold 'low': nan is no value to wait for; it must be a finite number",
    ),
    (lambda s: s.unhook("x"), "'x': no rope of this name; there are rope, sling"),
    (lambda s: s.hook("x"), "'x': no rope of this name; there are rope, sling"),
    (lambda s: s.hook("sling", a=(1.0,)), "rope 'sling' at 0.000 s: end (1.0,); it must be 3 finite numbers"),
    (lambda s: s.hook("sling", b=(1.0, 2.0)), "rope 'sling' at 0.000 s: end (1.0, 2.0); it must be 3 finite numbers"),
    (
        lambda s: s.hook("sling", a=(nan,) * 3),
        "rope 'sling' at 0.000 s: end (nan, nan, nan); it must be 3 finite numbers",
    ),
    (lambda s: s.run(nan), "time nan: it must be a whole number of nanoseconds"),
    (lambda s: s.interrupt(1e8), "time 100000000.0: it must be a whole number of nanoseconds"),
    (lambda s: s.interrupt(-1), "time -1 ns: it lies before the present, 0 ns"),
    (lambda s: s.fire(), "no event has been located; run first"),
    (lambda s: s.hook("rope"), "rope 'rope' at 0.000 s: it is hooked already; unhook it first"),
]


@pytest.fixture(scope="module")
def simulation():
    return started(driven())


@pytest.mark.parametrize(("command", "sentence"), COMMANDS, ids=[s[:60] for _, s in COMMANDS])
def test_commands_that_cannot_be(simulation, command, sentence):
    before = simulation.P.tobytes()
    with pytest.raises(KernelError) as e:
        command(simulation)
    assert str(e.value) == sentence
    simulation.references.write(simulation.epoch)
    assert simulation.P.tobytes() == before, "a refused command changes nothing"


@pytest.mark.parametrize(
    "command",
    [
        lambda s: s.run(SECOND),
        lambda s: s.interrupt(SECOND // 10),
        lambda s: s.fire(),
        lambda s: s.preview(),
        lambda s: s.settle(),
        lambda s: s.set_follow("rope", "theta", (1.0, 0.0, 0.0)),
        lambda s: s.set_brake("brake", True),
        lambda s: s.set_lock("lock", True),
        lambda s: s.unhook("rope"),
        lambda s: s.hook("rope"),
    ],
)
def test_nothing_can_be_told_to_a_simulation_before_its_start(command):
    with pytest.raises(KernelError) as e:
        command(Simulation(driven()))
    assert str(e.value) == "the simulation has no state yet; start it first"


def test_a_rope_is_hooked_at_an_array():
    s = started(driven())
    s.unhook("sling")
    s.hook("sling", a=np.array([1.0, 0.0, 0.0]))
    assert s.switches.rope_numbers("sling")[4:7] == pytest.approx([1.0, 0.0, 0.0])


def test_names_of_none():
    switches = Switches(Program(ONE), Program(ONE).parameters.initial)
    for what, call in (
        ("rope", switches.rope_numbers),
        ("threshold", switches.unwatch),
        ("brake", lambda name: switches.set_brake(name, True, None)),
    ):
        with pytest.raises(KernelError, match=f"'x': no {what} of this name; there are none"):
            call("x")


def test_a_winch_that_pays_in_more_rope_than_there_is():
    s = started(hung(60.1, winch=True))
    s.references.set_profile("rope", 0, -9.0, 10.0, None)
    s.settle()
    with pytest.raises(KernelError) as e:
        s.run(60 * SECOND)
    assert str(e.value) == "rope 'rope' at 7.117 s: all of it is wound up; stop its winch before"


def test_motion_that_is_not_finite_names_the_body():
    scene = System(
        (Body("a", 1.0), Body("b", 1e-300)),
        (Joint("j", "prismatic", "world", "a", axis=X), Joint("k", "prismatic", "a", "b", axis=Z)),
        springs=(JointSpring("s", "k", 1e300, q_rest=1e300),),
    )
    s = started(scene)
    with pytest.raises(KernelError) as e:
        hand_over(s, SECOND)
    assert str(e.value).startswith("body '")
    assert "\n" not in str(e.value)


def test_a_law_that_jumps_is_named_by_its_body():
    """A brake as stiff as numbers allow: the step shrinks below a picosecond and the run ends."""
    brake = Brake("brake", "a-guide", 1e30, 1e36, 0.0, True)
    s = started(replace(slider("a", 1.0, v0=1.0), brakes=(brake,)))
    with pytest.raises(KernelError) as e:
        s.run(SECOND)
    assert str(e.value) == (
        "body 'a' at 0.000000 s: the step became too small (below 1e-12 s); 'a' on 'brake' swings at "
        "1.59e+17 Hz, or a law near it jumps; soften it, or choose method radau5"
    )


def test_a_drive_that_pushes_a_body_into_the_ground_is_named_by_the_contact():
    ground = Contact("ground", Ball("a", radius=0.1), Plane(p=(0.0, 0.0, -0.2)))
    s = started(replace(slider("a", 1.0), drives=(Drive("press", "a-guide", "prescribed"),), contacts=(ground,)))
    s.references.set_profile("press", 0, -0.5, 0.5, None)
    s.settle()
    with pytest.raises(KernelError) as e:
        s.run(2 * SECOND)
    assert str(e.value) == (
        "contact 'ground' at 0.632456 s: drives or locks hold all that it could move; stop the drive before, make it "
        "a servo, or free a joint"
    )


def test_states_that_switch_without_end_are_named():
    """A guard that falls again at the same instant, whatever its law does, for ever."""
    s = started(hung(59.0))

    def chatter():
        for _ in range(300):
            s._fallen, s._event_ns = [0], s.epoch
            s.fire()

    with pytest.raises(KernelError) as e:
        chatter()
    assert str(e.value) == "rope at 0.000000000 s: states switch without end; soften or damp the law"


@pytest.mark.parametrize("value", [nan, inf, -inf])
@pytest.mark.parametrize("place", ["q0", "v0"])
def test_states_that_are_not_finite_are_refused(value, place):
    with pytest.raises(KernelError, match=f"joint 'a-guide': {place} is {value}; it must be a finite number"):
        Simulation(with_(joints=(replace(GUIDE, **{place: (value,)}),)))


def test_a_rope_whose_ends_meet_has_no_direction():
    s = started(hung(0.0))
    with pytest.raises(KernelError) as e:
        s.run(SECOND)
    assert str(e.value) == "rope 'rope' at 0.000 s: its ends meet, so that it has no direction; keep them apart"
