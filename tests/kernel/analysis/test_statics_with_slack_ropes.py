"""Equilibria with slack ropes and pads: load shares against closed forms."""

import json
from dataclasses import replace
from math import cos, radians, sin
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.analysis import equilibrium, momentum, reactions
from heavylift.kernel.description import Body, Brake, Joint, Line, Point, Rope, Support, System
from small_scenes import EA, LENGTH, MASS, G, X, Y, Z, cube, hung, slider, started

FORMS = {x["id"]: x for x in json.loads((Path(__file__).parents[2] / "data" / "closed_forms.json").read_text())}
STATIC = 1e-6  # relative, as the closed forms ask


def hanging(lugs, weight, cg=(0.0, 0.0, 0.0), k=1e8, L=400.0, errors=(), size=10.0):
    """A block on vertical ropes of stiffness k; lugs and centre in its frame."""
    m = weight / G
    ropes = tuple(
        Rope(
            f"r{i}",
            (Line(Point("world", (x, y, L + z)), Point("block", (x, y, z))),),
            k * L,
            L + (errors[i] if errors else 0.0),
        )
        for i, (x, y, z) in enumerate(lugs)
    )
    block = Body("block", m, cg, cube(m, size))
    return System((block,), (Joint("free", "free", "world", "block"),), ropes=ropes, gravity=G)


def test_three_ropes_share_a_load_by_the_areas_of_the_lug_triangle():
    x, want = FORMS["C08a"]["given"], FORMS["C08a"]["expected"]
    # lugs level with the centre of mass, ropes stiff: what the block leans moves nothing
    scene = hanging([(*p, 0.0) for p in x["lugs"]], x["W"], (*x["cg"], 0.0), k=1e12)
    assert list(equilibrium(started(scene)).tensions.values()) == pytest.approx(want["T"], rel=STATIC)


def test_tensions_of_six_equal_ropes_vary_linearly_over_the_plan():
    x, want = FORMS["C08b"]["given"], FORMS["C08b"]["expected"]
    scene = hanging([(*p, 0.0) for p in x["lugs"]], x["W"], (*x["cg"], 0.0), k=1e12)
    assert list(equilibrium(started(scene)).tensions.values()) == pytest.approx(want["T"], rel=STATIC)


def test_of_six_ropes_on_a_block_the_one_that_is_too_short_is_overloaded_with_its_diagonal_partner():
    x, want = FORMS["C08d"]["given"], FORMS["C08d"]["expected"]
    lugs = [(-10.0, -9.0, 0.0), (10.0, -9.0, 0.0), (-10.0, 9.0, 0.0), (10.0, 9.0, 0.0)]
    weight, L = 8e6, 4e6  # long ropes: that each is as stiff as the closed form says, and plumb
    even = equilibrium(started(hanging(lugs, weight, k=x["k"], L=L))).tensions
    skew = equilibrium(started(hanging(lugs, weight, k=x["k"], L=L, errors=(-x["dL"], 0.0, 0.0, 0.0)))).tensions
    assert [skew[r] - even[r] for r in even] == pytest.approx(want["dT"], rel=1e-5)


def test_a_rope_that_would_push_goes_slack_and_the_others_share_its_load():
    lugs = [(-10.0, -9.0, 0.0), (10.0, -9.0, 0.0), (-10.0, 9.0, 0.0), (10.0, 9.0, 0.0)]
    scene = hanging(lugs, 1e6, k=1e8, errors=(0.0, 0.0, 0.0, 0.5))  # one half a metre too long
    found = equilibrium(started(scene)).tensions
    assert found["r3"] == 0.0
    assert found["r0"] == pytest.approx(0.0, abs=2e4)  # the centre lies on the line of the other two
    assert sum(found.values()) == pytest.approx(1e6, rel=1e-3)


def test_tensions_of_two_inclined_ropes_agree_with_the_closed_form():
    x, want = FORMS["C10b"]["given"], FORMS["C10b"]["expected"]
    a, b, L = radians(x["alpha_deg"]), radians(x["beta_deg"]), 60.0
    m, stiff = x["W"] / G, 1e13
    lugs = ((-9.0, 0.0, 0.0), (9.0, 0.0, 0.0))
    # the lines of both ropes meet above the centre of mass
    height = 18.0 / (np.tan(a) + np.tan(b))
    cg = (-9.0 + height * np.tan(a), 0.0, -1.0)
    ropes = tuple(
        Rope(name, (Line(Point("world", (p[0] + s * L * sin(t), 0.0, L * cos(t))), Point("block", p)),), stiff, L)
        for name, p, s, t in (("A", lugs[0], 1.0, a), ("B", lugs[1], -1.0, b))
    )
    scene = System((Body("block", m, cg, cube(m, 10.0)),), (Joint("free", "free", "world", "block"),), ropes=ropes)
    found = equilibrium(started(replace(scene, gravity=G)))
    assert found.tensions == pytest.approx({"A": want["T_A"], "B": want["T_B"]}, rel=STATIC)
    assert found.tensions["A"] * sin(a) == pytest.approx(want["H"], rel=STATIC)


def test_a_height_difference_of_two_hooks_shifts_the_load_between_them():
    x, want = FORMS["C10c"]["given"], FORMS["C10c"]["expected"]
    s, h, dz, L = x["s"], x["h"], x["dz"], 1e4
    m = x["W"] / G
    guide = (
        Joint("along", "prismatic", "world", "a", axis=X),
        Joint("up", "prismatic", "a", "b", axis=Z),
        Joint("pitch", "revolute", "b", "block", axis=Y, q0=(-want["phi_deg"] * np.pi / 180.0,)),
    )
    bodies = (Body("a", 0.0), Body("b", 0.0), Body("block", m, (0.0, 0.0, -h), cube(m, 10.0)))
    phi = radians(want["phi_deg"])
    ropes = tuple(
        Rope(name, (Line(Point("world", (e * cos(phi), 0.0, L + up)), Point("block", (e, 0.0, 0.0))),), 1e13, L)
        for name, e, up in (("low", -s / 2, -dz / 2), ("high", s / 2, dz / 2))
    )  # fmt: skip
    found = equilibrium(started(System(bodies, guide, ropes=ropes, gravity=G)))
    assert found.tensions == pytest.approx({"low": want["T_A"], "high": want["T_B"]}, rel=1e-5)


@pytest.mark.parametrize("theta", [0.0, 30.0, 60.0])
def test_load_shares_of_two_hooks_change_with_the_angle_of_the_block(theta):
    """Plumb ropes over the lugs of a block held at an angle; ropes stiff, so it stays there."""
    x, want = FORMS["C10a"]["given"], FORMS["C10a"]["expected"][f"half1_{theta:.0f}deg"]
    L, t = 2e3, radians(theta)
    lugs = {name: (x[name][0], 0.0, x[name][1]) for name in ("A", "B")}
    m = x["W"] / G
    joint = Joint("free", "free", "world", "block", q0=(0.0, 0.0, 0.0, 0.0, sin(t / 2), 0.0, cos(t / 2)))
    ropes = tuple(
        Rope(name, (Line(Point("world", _above(p, t, L)), Point("block", p)),), 1e15, L) for name, p in lugs.items()
    )
    found = equilibrium(started(System((Body("block", m, inertia=cube(m, 10.0)),), (joint,), ropes=ropes, gravity=G)))
    assert [T / x["W"] for T in found.tensions.values()] == pytest.approx(want, rel=1e-5)


def _above(p, t, L):
    """A point L above a lug of a block that is turned by t about y."""
    return (p[0] * cos(t) + p[2] * sin(t), 0.0, -p[0] * sin(t) + p[2] * cos(t) + L)


def test_a_load_on_a_slack_rope_comes_to_rest_where_the_stretched_rope_carries_its_weight():
    simulation = started(hung(LENGTH - 5.0))
    found = equilibrium(simulation)
    assert found.tensions["rope"] == pytest.approx(MASS * G, rel=1e-9)
    assert -found.q[0] - LENGTH == pytest.approx(MASS * G * LENGTH / EA, rel=1e-9)


def test_a_body_comes_to_rest_on_its_pads():
    m = 1e3
    body = Body("box", m, inertia=cube(m))
    pads = tuple(
        Support(f"p{x:+.0f}{y:+.0f}", Point("box", (x, y, -1.0)), 0.0, 1e6, 1e4, 0.3, 1e6, 1e4)
        for x in (-1.0, 1.0)
        for y in (-1.0, 1.0)
    )
    joint = Joint("free", "free", "world", "box", q0=(0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 1.0))
    simulation = started(System((body,), (joint,), supports=pads, gravity=G))
    found = equilibrium(simulation)
    assert list(found.supports.values()) == pytest.approx([m * G / 4] * 4, rel=1e-7)
    assert momentum(simulation).centre[2] == pytest.approx(1.0 - m * G / 4e6, abs=1e-9)


def test_a_brake_holds_an_inclined_pendulum():
    m, L, q = 100.0, 3.0, 0.5
    joint = Joint("pivot", "revolute", "world", "load", axis=Y, q0=(q,))
    scene = System((Body("load", m, (0.0, 0.0, -L)),), (joint,), gravity=G)
    held = replace(scene, brakes=(Brake("brake", "pivot", 1e4, 1e9, 0.0, True),))
    simulation = started(held)
    assert equilibrium(simulation).q[0] == pytest.approx(q, abs=1e-5)
    assert abs(reactions(simulation)["pivot"].moment[1]) == pytest.approx(m * G * L * sin(q), rel=1e-4)
    assert equilibrium(started(scene)).q[0] == pytest.approx(0.0, abs=1e-8)


def test_statics_of_a_body_without_support_are_refused_with_the_name_of_the_body():
    with pytest.raises(KernelError, match=r"body 'load' finds no rest: joint 'load-guide' still accelerates by 9\.8"):
        equilibrium(started(slider()))


def test_an_unhooked_rope_carries_no_load():
    with pytest.raises(KernelError, match="body 'load' finds no rest"):
        equilibrium(started(hung(50.0, hooked=False)))


def test_an_equaliser_beam_tilts_until_its_rope_tensions_have_the_ratio_of_the_closed_form():
    x, want = FORMS["C09"]["given"], FORMS["C09"]["expected"]
    c, h, phi, L, W = x["c"], x["h"], radians(x["phi_deg"]), 1e4, 1e6
    bodies = (Body("beam", 1e-3, inertia=cube(1e-3)), Body("load", W / G))
    joints = (
        Joint("hinge", "revolute", "world", "beam", axis=Y),
        Joint("guide", "prismatic", "world", "load", axis=Z, q0=(-L,)),
    )
    ropes = tuple(
        Rope(
            name,
            (Line(Point("beam", (s * c, 0.0, -h)), Point("load", (s * c, 0.0, -h))),),
            1e13,
            L + s * c * sin(phi),
        )
        for name, s in (("T1", 1.0), ("T2", -1.0))
    )
    found = equilibrium(started(System(bodies, joints, ropes=ropes, gravity=G)))
    assert abs(np.tan(found.q[0])) == pytest.approx(want["tan_phi"], rel=1e-4)
    big, small = sorted(found.tensions.values(), reverse=True)
    assert big / small == pytest.approx(want["T1_over_T2"], rel=1e-4)
