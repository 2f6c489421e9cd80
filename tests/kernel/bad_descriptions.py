"""Impossible descriptions of systems, each with its error message."""

from dataclasses import replace
from math import inf, nan

import numpy as np
from heavylift.kernel.description import (  # fmt: skip
    Beam,
    Body,
    Box,
    Brake,
    Contact,
    Drive,
    Flexible,
    Joint,
    JointSpring,
    Line,
    Master,
    Measured,
    Plane,
    Point,
    Rope,
    Stop,
    Support,
    Threshold,
)
from small_scenes import slider

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
    (with_(bodies=(BODY, BODY)), "body 'a': this name is used twice; names must be unique"),
    (with_(joints=(GUIDE, GUIDE)), "joint 'a-guide': this name is used twice; names must be unique"),
    (with_(joints=(replace(GUIDE, child="b"),)), "joint 'a-guide': there is no body 'b'; known: a, world"),
    (with_(joints=(replace(GUIDE, parent="b"),)), "joint 'a-guide': there is no body 'b'; known: a, world"),
    (with_(joints=()), "body 'a': no joint connects it to the ground; add one (kind free if it floats)"),
    (
        with_(joints=(replace(GUIDE, parent="a"),)),
        "joint 'a-guide': it connects 'a' to itself; give it another parent or child",
    ),
    (
        with_(bodies=(Body("world", 1.0),), joints=(replace(GUIDE, child="world"),)),
        "body 'world': this name is reserved for the ground; choose another one",
    ),
    (with_(bodies=(Body("a", -1.0),)), "body 'a': mass -1 kg; a mass cannot be negative"),
    (with_(joints=(replace(GUIDE, q0=(0.0, 1.0)),)), "joint 'a-guide': 2 initial coordinates; a prismatic joint has 1"),
    (with_(joints=(replace(GUIDE, v0=(0.0, 1.0)),)), "joint 'a-guide': 2 initial velocities; a prismatic joint has 1"),
    (
        with_(
            bodies=(BODY, Body("b", 1.0), Body("c", 1.0)),
            joints=(GUIDE, replace(GUIDE, name="j", parent="c", child="b"), replace(FLOAT, parent="b", child="c")),
        ),
        "body 'b': the joints that carry it form a loop that is not connected to the ground: 'j', 'float'",
    ),
    (
        with_(joints=(replace(GUIDE, kind="hinge"),)),
        "joint 'a-guide': kind is 'hinge'; it must be fixed, revolute, prismatic, cylindrical, screw, universal, "
        "planar, constant-velocity, spherical, free or slider",
    ),
    # axes
    (
        with_(joints=(replace(GUIDE, kind="universal", second=(0.0, 0.6, 0.8)),)),
        "joint 'a-guide': the angle between its axes is 36.87 deg; the second axis of a universal joint "
        "must be perpendicular to the first",
    ),
    (
        with_(joints=(replace(GUIDE, kind="planar", second=(0.0, 2.0, 0.0)),)),
        "joint 'a-guide': its second axis has length 2; it must be a unit vector",
    ),
    (
        with_(joints=(replace(GUIDE, kind="screw"),)),
        "joint 'a-guide': its pitch is 0; give the pitch of a screw in m/rad, or make the joint revolute",
    ),
    (with_(joints=(replace(GUIDE, pitch=0.1),)), "joint 'a-guide': pitch is 0.1; a prismatic joint has no pitch"),
    # numbers
    (with_(bodies=(Body("a", nan),)), "body 'a': mass is nan; it must be a finite number"),
    (with_(bodies=(Body("a", 1.0, (0.0, inf, 0.0)),)), "body 'a': com is inf; it must be a finite number"),
    (
        with_(bodies=(Body("a", 1.0, inertia=SHEARED),)),
        "body 'a': its inertia must be a symmetric matrix, but Ixy is 0.5 and Iyx is 0 kg m2; give both the same value",
    ),
    (
        with_(bodies=(Body("a", 1.0, inertia=diagonal(1.0, 5.0, 3.0)),)),
        "body 'a': its principal moments of inertia are 1, 3, 5 kg m2; none can be larger than the sum of the other "
        "two (for a flat plate Ixx + Iyy = Izz): where the other two do not matter, as in plane motion, write "
        "[1.5, 5, 3.5] kg m2",
    ),
    (
        with_(bodies=(Body("a", 1.0, inertia=((1.0, 2.0, 0.0), (2.0, 1.0, 0.0), (0.0, 0.0, 1.0))),)),
        "body 'a': its principal moments of inertia are -1, 1, 3 kg m2, but a "
        "principal moment cannot be negative: the products of "
        "inertia Ixy 2, Ixz 0, Iyz 0 are too large for the moments; reduce them",
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
    (with_(ropes=(replace(ROPE, lines=()),)), "rope 'rope': it has no straight part (line); give it at least one"),
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
        "stop 'stop': its lower limit 1 is above the upper one, -1",
    ),
    (
        with_(brakes=(Brake("brake", "a-guide", -1.0, 1e6, 0.0),)),
        "brake 'brake': moment is -1; it cannot be negative",
    ),
    # types and shapes
    ({}, "the description is {}; it must be a System"),
    (with_(gravity=None), "gravity is None; it must be a number"),
    (with_(bodies=(GUIDE, *ONE.bodies)), f"bodies: {str(GUIDE)[:57]}... is not allowed; it must be a Body"),
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
        "spring 'spring': there is no joint 'b-guide'; did you mean 'a-guide'?",
    ),
    (
        with_(joints=(replace(GUIDE, kind="cylindrical", q0=(), v0=()),), springs=(JointSpring("spring", "a-guide"),)),
        "'spring': name the coordinate of the cylindrical joint 'a-guide': travel or angle",
    ),
    (
        with_(springs=(JointSpring("spring", "a-guide", coordinate="angle"),)),
        "'spring': joint 'a-guide' is prismatic; it does not have the coordinate 'angle', only travel",
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
    (
        with_(ropes=(replace(ROPE, lines=(Line(Point("b"), Point("a")),)),)),
        "rope 'rope': there is no body 'b'; known: a, world",
    ),
    (
        with_(supports=(Support("pad", Point("b"), 0.0, 1.0, 1.0),)),
        "support 'pad': there is no body 'b'; known: a, world",
    ),
    (with_(measured=(Measured("theta", "angle", "b"),)), "measured 'theta': there is no body 'b'; known: a, world"),
    (with_(measured=(Measured("way", "joint", "b"),)), "measured 'way': there is no joint 'b'; known: a-guide"),
    (
        with_(joints=(FLOAT,), measured=(Measured("way", "joint", "float"),)),
        "'way': nothing can act along joint 'float', which is free: no velocity of it is the rate of a coordinate",
    ),
    (with_(thresholds=(Threshold("t", "angle", of="b"),)), "threshold 't': there is no body 'b'; known: a, world"),
    (with_(thresholds=(Threshold("t", "speed", of="b"),)), "threshold 't': there is no joint 'b'; known: a-guide"),
    (with_(thresholds=(Threshold("t", "height"),)), "threshold 't': a height needs a point; give one"),
    (with_(thresholds=(Threshold("t", "tension"),)), "threshold 't': a tension needs a rope; give one"),
    (
        with_(thresholds=(Threshold("t", "length", ropes=("r",)),)),
        "threshold 't': there is no rope 'r'; the system has no rope at all",
    ),
    (
        with_(ropes=(ROPE, ROPE)),
        "'rope': this name is used twice; names of force laws, drives and masters must be unique",
    ),
    (
        with_(ropes=(ROPE,), masters=(Master("rope"),)),
        "'rope': this name is used twice; names of force laws, drives and masters must be unique",
    ),
    (
        with_(ropes=(ROPE,), thresholds=(Threshold("rope", "tension", ropes=("rope",)),)),
        "'rope': this name is used twice; names of force laws, drives and masters must be unique",
    ),
]
