"""A scene with every law, all joints but the spherical one, and no symmetry that could hide a mistake."""

from heavylift.kernel.description import (
    Body,
    Brake,
    Bushing,
    Drive,
    InputSignal,
    Joint,
    JointSpring,
    Line,
    Load,
    Master,
    Measured,
    Point,
    Rope,
    Spring,
    Stop,
    Support,
    System,
    Threshold,
    Torsion,
    Wind,
)
from small_scenes import G, X, Y, Z, cube

SEAT = tuple(tuple(1.0e3 if i == j else 100.0 + 20.0 * (i + j) for j in range(6)) for i in range(6))


def yard() -> System:
    """A trolley and a winch that carry a block over pads; a hinged arm with spring, stop and brake; one loose sling."""
    m = 5.0e4
    bodies = (
        Body("trolley", 2.0e4),
        Body("cat", 1.0e4),
        Body("block", m, (0.2, -0.1, 0.1), cube(m, 4.0)),
        Body("arm", 5.0e3, (0.8, 0.0, 0.0), cube(5.0e3)),
    )
    joints = (
        Joint("rail", "prismatic", "world", "trolley", (0.0, 0.0, 30.0), axis=X),
        Joint("girder", "prismatic", "trolley", "cat", axis=Y),
        Joint("float", "free", "world", "block", q0=(0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0)),
        Joint("hinge", "revolute", "block", "arm", (0.0, 0.0, 2.0), axis=Z),
    )
    rope = tuple(Line(Point("cat", (x, 0.0, 0.0)), Point("block", (x, 0.0, 2.0)), 0.5) for x in (-1.0, 1.0))
    sling = Line(Point("trolley", (3.0, 0.0, 0.0)), Point("block", (2.0, 0.0, 2.0)))
    k, d = m * G / 4 / 5e-3, 4e5
    return System(
        bodies,
        joints,
        springs=(JointSpring("closer", "hinge", 2.0e4, 2.0e3),),
        stops=(Stop("hinge-stop", "hinge", -0.3, 0.4, 5.0e6, 2.0e4),),
        brakes=(Brake("hinge-brake", "hinge", 5.0e3, 1.0e6, 1.0e4, True),),
        drives=(Drive("travel", "rail", "servo", 1.0e6, 2.0e5), Drive("traverse", "girder", "prescribed")),
        ropes=(
            Rope("hoist", rope, 4.0e8, 26.1, 1.0e5, winch=True),
            Rope("sling", (sling,), 2.0e8, 26.5, 5.0e4, hooked=False),
        ),
        supports=tuple(
            Support(f"pad{x}{y}", Point("block", (2.0 * x, 2.0 * y, -2.0)), 0.0, k, d, 0.3, k, d)
            for x in (-1, 1)
            for y in (-1, 1)
        ),
        forces=(
            Load("tug", Point("block", (2.0, 1.0, 0.0)), (3.0e3, -2.0e3, 0.0), (0.0, 0.0, 1.0e3), "body"),
            Wind(
                "gale",
                Point("block"),
                30.0,
                1.2,
                Y,
                InputSignal(times=(0.0, 0.001, 0.001, 2.0), values=(5.0, 9.0, 7.0, 20.0)),
            ),
            Spring("buffer", Point("cat", (0.0, 0.0, -1.0)), Point("block", (0.0, 0.0, 2.0)), 24.0, 2.0e4, 1.0e3),
            Torsion("twister", "block", "arm", Z, 3.0e3, 1.0e2),
            Bushing("seat", Point("cat"), Point("arm", (0.5, 0.0, 0.0)), SEAT, SEAT),
        ),
        masters=(Master("theta"),),
        measured=(Measured("lean", "angle", "block"), Measured("swing", "joint", "hinge")),
        thresholds=(
            Threshold("high", "height", point=Point("block")),
            Threshold("heavy", "tension", ropes=("hoist", "sling")),
        ),
        gravity=G,
    )
