"""Closed forms of statics: shares of ropes, tilted and tandem lifts, tackles, capstans, belts, equalisers, feet."""

from __future__ import annotations

from collections.abc import Iterator
from math import asin, cos, exp, pi, radians, sin, sqrt, tan

import numpy as np
from comparison import FORMS, Row, case
from heavylift.kernel.analysis import equilibrium
from heavylift.kernel.description import Body, InputSignal, Joint, Line, Point, Reeving, Rope, Sheave, System
from small_scenes import SECOND, G, Y, Z, cube, started

TABLE, RULES = "Statics", "Worked examples of rules and tools"
SHARES = "tests/kernel/analysis/test_statics_with_slack_ropes.py"
REEVED = "tests/kernel/forces/ropes/test_ropes_over_sheaves.py"
EQUAL, HERE = "tests/kernel/forces/ropes/test_equalisers.py", "tests/validation/static_cases.py"


def shares(system: System) -> list[float]:
    """Tensions at rest [N]."""
    return list(equilibrium(started(system)).tensions.values())


@case(TABLE, "three plumb ropes, T = W × opposite area / area", SHARES, full=True)
def three_ropes() -> Iterator[Row]:
    from test_statics_with_slack_ropes import hanging

    x, want = FORMS["C08a"]["given"], FORMS["C08a"]["expected"]
    T = shares(hanging([(*p, 0.0) for p in x["lugs"]], x["W"], (*x["cg"], 0.0), k=1e12))
    yield Row("tension of the third rope", want["T"][2] / 1e3, T[2] / 1e3, 1e-6, "kN")


@case(TABLE, "n equal ropes, T = W (1/n + xg x/sum x² + yg y/sum y²)", SHARES, full=True)
def six_ropes() -> Iterator[Row]:
    from test_rigid_ropes import six
    from test_statics_with_slack_ropes import hanging

    x, want = FORMS["C08b"]["given"], FORMS["C08b"]["expected"]
    T = shares(hanging([(*p, 0.0) for p in x["lugs"]], x["W"], (*x["cg"], 0.0), k=1e12))
    yield Row("highest of six, elastic ropes", want["T"][2] / 1e3, T[2] / 1e3, 1e-6, "kN")
    rigid = started(six(x["lugs"], x["cg"])).row().pull
    yield Row("the same, ropes that do not stretch", want["T"][2] / 1e3, float(rigid[2]) / 1e3, 1e-6, "kN")


@case(TABLE, "rope 10 mm too short, dT = k dL/4", SHARES, full=True)
def skew_load() -> Iterator[Row]:
    from test_statics_with_slack_ropes import hanging

    x, want = FORMS["C08d"]["given"], FORMS["C08d"]["expected"]
    lugs = [(a, b, 0.0) for b in (-9.0, 9.0) for a in (-10.0, 10.0)]
    even = shares(hanging(lugs, 8e6, k=x["k"], L=4e6))
    skew = shares(hanging(lugs, 8e6, k=x["k"], L=4e6, errors=(-x["dL"], 0.0, 0.0, 0.0)))
    yield Row("more on its diagonal", want["dT"][0] / 1e3, (skew[0] - even[0]) / 1e3, 1e-5, "kN")


def tilted(a: tuple[float, float], b: tuple[float, float], t: float, W: float) -> list[float]:
    """Tensions of two plumb ropes to lugs a and b (x, z) of a block whose centre is its origin, turned by t."""
    places = [(p[0] * cos(t) + p[1] * sin(t), 0.0, p[1] * cos(t) - p[0] * sin(t) + 2e3) for p in (a, b)]
    ropes = tuple(
        Rope(name, (Line(Point("world", place), Point("block", (p[0], 0.0, p[1]))),), 1e15, 2e3)
        for name, p, place in zip("AB", (a, b), places, strict=True)
    )
    joint = Joint("free", "free", "world", "block", q0=(0.0, 0.0, 0.0, 0.0, sin(t / 2), 0.0, cos(t / 2)))
    block = Body("block", W / G, inertia=cube(W / G, 10.0))
    return shares(System((block,), (joint,), ropes=ropes, gravity=G))


@case(TABLE, "turn-over on plumb ropes, T_A = W x_B/(x_B - x_A)", SHARES)
def turn_over() -> Iterator[Row]:
    x, want = FORMS["C10a"]["given"], FORMS["C10a"]["expected"]
    for angle in (30, 60):
        T = tilted(x["A"], x["B"], radians(angle), x["W"])
        yield Row(f"share of the upper hook at {angle}°", want[f"half1_{angle}deg"][0], T[0] / x["W"], 1e-5)


@case(TABLE, "two leaning ropes, T_A = W sin b/sin(a + b)", SHARES)
def off_lead() -> Iterator[Row]:
    x, want = FORMS["C10b"]["given"], FORMS["C10b"]["expected"]
    a, b, L, m = radians(x["alpha_deg"]), radians(x["beta_deg"]), 60.0, x["W"] / G
    height = 18.0 / (tan(a) + tan(b))  # of the place where their lines meet, above the lugs
    lugs = ((-9.0, 0.0, 0.0), (9.0, 0.0, 0.0))
    ropes = tuple(
        Rope(name, (Line(Point("world", (p[0] + s * L * sin(t), 0.0, L * cos(t))), Point("block", p)),), 1e13, L)
        for name, p, s, t in (("A", lugs[0], 1.0, a), ("B", lugs[1], -1.0, b))
    )
    block = Body("block", m, (-9.0 + height * tan(a), 0.0, -1.0), cube(m, 10.0))
    T = shares(System((block,), (Joint("free", "free", "world", "block"),), ropes=ropes, gravity=G))
    yield Row("tension at 4° off lead", want["T_A"] / 1e3, T[0] / 1e3, 1e-6, "kN")
    yield Row("horizontal pull on its trolley", want["H"] / 1e3, T[0] * sin(a) / 1e3, 1e-6, "kN")


@case(TABLE, "tandem lift 0.5 m out of level, T = W (1/2 + (h/s) tan a)", SHARES)
def out_of_level() -> Iterator[Row]:
    x, want = FORMS["C10c"]["given"], FORMS["C10c"]["expected"]
    h, half = x["h"], x["s"] / 2
    T = tilted((-half, h), (half, h), -radians(want["phi_deg"]), x["W"])
    yield Row("tension of the lower hook", want["T_A"] / 1e3, T[0] / 1e3, 1e-5, "kN")


@case(TABLE, "equaliser beam, (T1 - T2)/(T1 + T2) = (h/c) tan a", EQUAL)
def equaliser_beam() -> Iterator[Row]:
    x, want = FORMS["C09"]["given"], FORMS["C09"]["expected"]
    c, h, t, W, EA, top = x["c"], x["h"], radians(x["phi_deg"]), 1e5, 1e8, 20.0
    second = W / (1.0 + want["T1_over_T2"])
    ropes = []
    for name, e, T in (("one", -c, W - second), ("two", c, second)):
        x_at, z_at = e * cos(t) + h * sin(t), h * cos(t) - e * sin(t)
        line = Line(Point("world", (x_at, 0.0, top)), Point("beam", (e, 0.0, h)))
        ropes.append(Rope(name, (line,), EA, (top - z_at) / (1.0 + T / EA)))
    free = Joint("free", "free", "world", "beam", q0=(0.0, 0.0, 0.0, 0.0, sin(t / 2), 0.0, cos(t / 2)))
    s = started(System((Body("beam", W / G, inertia=cube(W / G)),), (free,), ropes=tuple(ropes), gravity=G))
    moment = float(s.X[s.native.at["f"]][s.program.nq + 4]) * cube(W / G)[1][1]  # what is left to turn it [N m]
    yield Row("moment left at 2° and the ratio 1.0141", 0.0, moment, 1e-3, "N m", absolute=True)


@case(TABLE, "tackle of 20 falls, T = W (1 - η)/(1 - η^n)", REEVED, full=True)
def tackle_of_twenty() -> Iterator[Row]:
    from test_ropes_over_sheaves import tackle

    x, want = FORMS["C14"]["given"], FORMS["C14"]["expected"]
    s = started(tackle(x["n"], x["eta"], x["W"] / G, 20.0, 1.0e8, 3e4), tolerance=1e-9)
    s.references.set_profile("rope", 0, -0.5, 0.5, None)
    s.settle()
    s.interrupt(25 * SECOND)
    T = np.array(s.row().shown[: x["n"]])
    yield Row("lead while it hoists, η = 0.985", want["T_lead"] / 1e3, T[0] / 1e3, 1e-6, "kN")
    yield Row("sum of the parts, W", want["sum_parts"] / 1e3, T.sum() / 1e3, 1e-6, "kN")


@case(TABLE, "Euler, Eytelwein: T1/T2 = exp(mu × wrap)", REEVED, full=True)
def capstan() -> Iterator[Row]:
    from test_ropes_over_sheaves import atwood

    m1, m2, rho = 200.0, 120.0, exp(0.1 * pi)
    s = started(atwood(m1, m2, 0.1), tolerance=1e-10, sample_ns=20_000_000)
    s.interrupt(SECOND)
    v = -s.row().v[2]
    s.settle()
    s.interrupt(3 * SECOND // 2)
    T = s.row().shown
    yield Row("ratio over a sheave that slips, mu = 0.1", rho, float(T[0] / T[1]), 1e-6)
    want = G * (m1 - rho * m2) / (m1 + rho * m2)
    yield Row("acceleration of 200 kg against 120 kg", want, float(-s.row().v[2] - v) / 0.5, 1e-4, "m/s²")


@case(TABLE, "belt over two wheels: tangents and arcs", REEVED)
def belts() -> Iterator[Row]:
    d, r1, r2, down = 6.0, 0.8, 0.3, 5.0
    for name, turn in (("open", 1.0), ("crossed", -1.0)):
        sheaves = (Sheave(Point("world"), Y, r1), Sheave(Point("world", (d, 0.0, 0.0)), (0.0, turn, 0.0), r2))
        guide = Joint("guide", "prismatic", "world", "load", (-r1, 0.0, 0.0), axis=Z, q0=(-down,))
        end = Point("world", (d + r2, 0.0, -down * turn))
        rope = Reeving("r", Point("load"), sheaves, end, 1e6, InputSignal(30.0))
        s = started(System((Body("load", 1.0),), (guide,), forces=(rope,)))
        lean, reach = asin((r1 - turn * r2) / d), r1 - turn * r2
        want = 2 * down + sqrt(d * d - reach**2) + r1 * (pi / 2 + lean) + r2 * (pi / 2 - turn * lean)
        yield Row(f"length, {name}", want, float(sum(s.row().shown[3:6])), 1e-9, "m")


@case(RULES, "0027/ND rev. 11, appendix B.1.2: formula and inputs as printed, worked out here", HERE)
def tilted_tandem_lift() -> Iterator[Row]:
    """Crane spacing 25 m, centre 12 + 0.9 m and 13 + 0.9 m from the cranes, 10 and 14 m below the lugs, 3 degrees."""
    L, c, d, a, b, x, z, t, W = 25.0, 12.0, 13.0, 10.0, 14.0, 0.9, 0.8, radians(3.0), 1e6
    one = ((b + z) * sin(t) + (d + x) * cos(t)) / (L * cos(t) + (b - a) * sin(t))
    two = ((a + z) * sin(t) + (c + x) * cos(t)) / (L * cos(t) - (b - a) * sin(t))
    # lugs as seen from the corner of the envelope of centres that is worst for each crane
    T = tilted((-(c - x), a + z), (d + x, b + z), t, W)
    yield Row("crane 1, part of the weight", one, T[0] / W, 1e-6)
    T = tilted((-(c + x), a + z), (d - x, b + z), -t, W)
    yield Row("crane 2, part of the weight", two, T[1] / W, 1e-6)


@case(RULES, "hjengineering.com.au, dual lift calculator, mode 1 (defaults: 8 m × 2 m, 2.5°)", HERE)
def dual_lift_calculator() -> Iterator[Row]:
    T = tilted((-4.0, 1.0), (4.0, 1.0), radians(2.5), 1e6)
    yield Row("factor of the lower hook over its half", 1.011, max(T) / 5e5, 5e-4)
