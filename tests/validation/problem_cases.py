"""Problems of published test sets with the default method; references have at least 16 digits."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from math import cos, radians, sin

import numpy as np
from comparison import TESTS, Row, case
from heavylift.kernel.description import Body, Drive, Joint, Line, Point, Rope, System
from small_scenes import SECOND, Y, hand_over, slider, started, times

TABLE = "Published problems"
TREES = "tests/kernel/multibody/test_reference_problems.py"
LOOPS = "tests/kernel/constraints/test_reference_mechanisms.py"
PROBLEMS = json.loads((TESTS / "data" / "tree_problems.json").read_text())["problems"]
LINKAGES = json.loads((TESTS / "data" / "linkages.json").read_text())
FINE = {"method": "dop853", "tolerance": 1e-13, "sample_ns": SECOND}


def diagonal(moments: list[float]) -> tuple:
    return tuple(tuple(moments[i] * (i == j) for j in range(3)) for i in range(3))


@case(TABLE, "IFToMM A01, simple pendulum from the horizontal", TREES)
def simple_pendulum() -> Iterator[Row]:
    joint = Joint("pin", "revolute", "world", "bob", axis=Y, q0=(radians(90.0),))
    s = started(System((Body("bob", 1.0, (0.0, 0.0, -1.0)),), (joint,), gravity=9.81), **FINE)
    hand_over(s, 10 * SECOND)
    want = PROBLEMS["A01_simple_pendulum"]["own_reference"]["10"]
    yield Row("height after 10 s", want["y"], -cos(s.state[0]), 1e-9, "m")
    yield Row("vertical speed after 10 s", want["vy"], s.state[1] * sin(s.state[0]), 1e-9, "m/s")


@case(
    TABLE,
    "IFToMM A02, two four-bar windows through singular poses",
    "tests/kernel/constraints/test_loops_close.py",
    full=True,
)
def four_bar_windows() -> Iterator[Row]:
    from linkages import windows

    s = started(windows(2), tolerance=1e-10)
    hand_over(s, 10 * SECOND)
    angle = s.state[s.program.graph.joint("foot0").q.start]
    x, z = LINKAGES["A02 N=2"]["10"]
    yield Row("place of a top after 10 s, along", x, sin(angle), 1e-6, "m")
    yield Row("and up", z, cos(angle), 1e-6, "m")
    yield Row("the same, as Exudyn publishes it (h = 0.125 ms)", 0.3284573768, sin(angle), 1e-5, "m")


@case(TABLE, "IFToMM A03, Andrews' squeezer", LOOPS, full=True)
def squeezing_mechanism() -> Iterator[Row]:
    from squeezer import squeezer
    from test_reference_mechanisms import coordinates

    reference = LINKAGES["A03"]
    s = started(squeezer(tuple(reference["start"])), method="dop853", tolerance=1e-12, sample_ns=SECOND)
    hand_over(s, SECOND // 20)
    got = coordinates(s, [f"K{i}" for i in range(1, 8)])
    yield Row("crank after 50 ms", reference["0.05"][0], float(got[0]), 1e-9, "rad")
    yield Row("its speed", reference["0.05"][7], float(got[7]), 1e-9, "rad/s")


@case(TABLE, "IVP Test Set, car axis, y(3) as published", LOOPS, full=True)
def car_axis_of_bari() -> Iterator[Row]:
    from test_reference_mechanisms import car_axis

    s = started(car_axis(), method="dop853", tolerance=1e-12, sample_ns=SECOND)
    s.set_follow("bumps", "phase", (0.0, 0.0, 0.1))
    s.references.set_profile("phase", 0, 10.0, 10.0, None)
    s.settle()
    hand_over(s, SECOND)  # the road moves at 10 rad/s and is at 0: now the problem's initial values
    graph, nq = s.program.graph, s.program.nq
    q, v = ([getattr(graph.joint(n), x).start for n in ("slide", "pin", "normal", "mount")] for x in "qv")
    s.state[q] = 1.0, 0.0, 0.5, 0.0
    s.state[[nq + i for i in v]] = 0.0, -1.0, 0.0, 1.0
    s.settle()
    hand_over(s, 4 * SECOND)
    _, angle, travel, _ = s.state[q]
    yield Row("left wheel, along", 0.4934557842755629e-1, travel * sin(angle), 1e-8, "m")
    yield Row("and up", 0.4969894602303324, travel * cos(angle), 1e-9, "m")


@case(TABLE, "heavy top of Géradin and Cardona, 150 rad/s", TREES)
def heavy_top() -> Iterator[Row]:
    p = PROBLEMS["heavy_top"]
    body = Body("top", 15.0, (0.0, 1.0, 0.0), diagonal(p["parameters"]["J_com"]))
    joint = Joint("tip", "spherical", "world", "top", v0=(0.0, 150.0, -4.61538))
    s = started(System((body,), (joint,), gravity=9.81), **FINE)
    hand_over(s, 2 * SECOND)
    want = p["own_reference"]["2"]["omega_body"]
    yield Row("spin after 2 s", want[1], float(s.state[5]), 1e-9, "rad/s")
    yield Row("rate across it", want[2], float(s.state[6]), 1e-8, "rad/s")


@case(TABLE, "NASA/TM-2015-218675, case 2: tumbling brick", TREES)
def tumbling_brick() -> Iterator[Row]:
    p = PROBLEMS["nesc_case2_tumbling_brick"]
    moments = [p["parameters"][k] * 1.3558179483 for k in ("Ixx", "Iyy", "Izz")]
    joint = Joint("free", "spherical", "world", "brick", v0=tuple(radians(x) for x in (10.0, 20.0, 30.0)))
    s = started(System((Body("brick", 2.26796, inertia=diagonal(moments)),), (joint,), gravity=0.0), **FINE)
    hand_over(s, 30 * SECOND)
    for k, axis in enumerate("pqr"):
        want = p["own_reference"]["30"]["omega_body_rad_s"][k]
        yield Row(f"rate {axis} after 30 s", want, float(s.state[4 + k]), 1e-8, "rad/s")


@case(TABLE, "own: load reeled in at 1 m/s from 20 m, 113-bit reference", TREES)
def reeled_in() -> Iterator[Row]:
    joints = (
        Joint("pivot", "revolute", "world", "boom", axis=Y, q0=(-0.1,)),
        Joint("reel", "prismatic", "boom", "load", axis=(0.0, 0.0, -1.0), q0=(20.0,)),
    )
    drives = (Drive("winch", "reel", "prescribed"),)
    s = started(System((Body("boom", 0.0), Body("load", 1.0)), joints, drives=drives, gravity=9.81), **FINE)
    s.references.set_profile("winch", 0, -1.0, 1e9, None)
    s.settle()
    hand_over(s, 10 * SECOND)
    angle = -s.state[s.program.graph.joint("pivot").q.start]
    yield Row("angle after 10 s", PROBLEMS["hoist_pendulum"]["own_reference"]["10"]["theta"], angle, 1e-7, "rad")


@case(TABLE, "own: load dropped on a slack rope, closed form", TREES)
def dropped_on_a_rope() -> Iterator[Row]:
    p = PROBLEMS["snap_load"]["own_reference"]
    rope = Rope("rope", (Line(Point("world"), Point("load")),), 1.2e7 * 20.0, 20.0)
    s = started(replace(slider(mass=3.0e5, q0=-19.95), ropes=(rope,), gravity=9.81), **FINE)
    hand_over(s, round(4.9 * p["period"] * SECOND))
    fifth = p["t_taut"] + 4 * p["period"]
    yield Row("fifth catch", fifth, times(s, "rope", "taut")[4], 1e-8, "s")


@case(
    TABLE,
    "own: two cranes, 24 freedoms; Drake, Exudyn, MuJoCo",
    "tests/kernel/simulation/test_the_goliath_reference.py",
    full=True,
)
def two_cranes() -> Iterator[Row]:
    from goliath import scene

    reference = json.loads((TESTS / "data" / "goliath_reference.json").read_text())
    s = started(scene(), tolerance=1e-10, sample_ns=100_000_000)
    s.run(10_050_000_000)
    columns = s.method.row_layout.at["tension"]
    rows = {t: row[columns] for t, row in s.rows}
    want = np.array(reference["tension"])
    got = np.array([rows[round(t * 1e9)] for t in reference["t"]])
    worst = np.unravel_index(np.argmax(np.abs(got - want)), want.shape)
    yield Row("tension where they differ most", want[worst] / 1e3, got[worst] / 1e3, 1e-6, "kN")
