"""Tandem motions of two trolleys with a block between them: turning it over (C10e), travelling out of step (C10f)."""

import json
from dataclasses import replace
from math import asin, cos, degrees, pi, radians, sin
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel.analysis import equilibrium
from heavylift.kernel.description import Body, Drive, Joint, Line, Measured, Point, RigidRope, System
from small_scenes import SECOND, G, X, Y, Z, column, cube, hand_over, started

FORMS = {x["id"]: x for x in json.loads((Path(__file__).parents[2] / "data" / "closed_forms.json").read_text())}
ROPE = 50.0  # [m]
MASS = 9e5
ANGLE = 0.05  # [deg], as C10e accepts it
PLUMB = 0.1  # [deg]
CLOSE = 1e-9  # relative, of a static equilibrium
RATE = 2e-3  # relative: what is left of the swing that the start of the winch has caused


def lifted(A: tuple[float, float], B: tuple[float, float], kind: str, apart: float = 0.0) -> System:
    """A block under two trolleys on one rail, on two rigid ropes; `apart`: more than the lugs are [m]."""
    lugs = {"west": (A[0], 0.0, A[1]), "east": (B[0], 0.0, B[1])}
    start = {"west": A[0] - apart / 2.0, "east": B[0] + apart / 2.0}
    gains = {"kp": 1e8, "kv": 1e7} if kind == "servo" else {}
    height = -A[1] - ROPE * cos(asin(apart / 2.0 / ROPE))
    return System(
        (Body("block", MASS, inertia=cube(MASS, 20.0)), *(Body(name, 1e5) for name in lugs)),
        (
            Joint("swing", "planar", "world", "block", axis=Y, second=Z, q0=(height, 0.0, 0.0)),  # z, x, angle
            *(Joint(f"rail-{n}", "prismatic", "world", n, axis=X, q0=(x,)) for n, x in start.items()),
        ),
        drives=tuple(Drive(f"drive-{n}", f"rail-{n}", kind, **gains) for n in lugs),
        rigid_ropes=tuple(
            RigidRope(f"rope-{n}", (Line(Point(n), Point("block", p)),), ROPE, True) for n, p in lugs.items()
        ),
        measured=(Measured("angle", "joint", "swing", coordinate="angle"),),
        gravity=G,
    )


def off_lead(q: np.ndarray, A: tuple[float, float], B: tuple[float, float]) -> np.ndarray:
    """Angle of each rope to the plumb line [deg], from rows of joint positions z, x, angle, west, east."""
    z, x, a = q[..., 0], q[..., 1], q[..., 2]
    leads = [
        np.arctan2(x + p[0] * np.cos(a) + p[1] * np.sin(a) - rail, -(z - p[0] * np.sin(a) + p[1] * np.cos(a)))
        for p, rail in ((A, q[..., 3]), (B, q[..., 4]))
    ]
    return np.degrees(leads)


def test_a_block_is_turned_over_by_one_winch_while_the_other_trolley_follows():
    x, want = FORMS["C10e"]["given"], FORMS["C10e"]["expected"]
    v, accel, s_lugs = x["v_diff"], 1e-3, x["B"][0] - x["A"][0]
    s = started(lifted(x["A"], x["B"], "servo"), sample_ns=SECOND)
    s.set_follow("drive-east", "angle", (0.0, s_lugs, 0.0))
    end = radians(want["theta_end_deg"])
    s.references.set_profile("rope-west", 0, -v, accel, -s_lugs * sin(end))
    s.settle()
    duration = want["t_0_to_70deg"] + v / accel  # the closed form knows no ramps
    hand_over(s, round(duration * SECOND))
    t, q = column(s, "joint/position")
    once = np.concatenate(([True], np.diff(t) > 0.0))  # an event is sampled at its instant, too
    t, q = t[once], q[once]
    angle, west, east = q[:, 2:].T
    assert degrees(angle[-1]) == pytest.approx(want["theta_end_deg"], abs=ANGLE)
    rate = np.interp(pi / 4.0, angle, np.gradient(angle, t))
    assert degrees(rate) == pytest.approx(want["rate_45_deg_s"], rel=RATE)
    assert np.interp(pi / 4.0, angle, east - west) == pytest.approx(want["s_45"], rel=RATE)
    closing = np.interp(pi / 4.0, angle, -np.gradient(east - west, t))
    assert closing == pytest.approx(want["closing_speed_45"], rel=RATE)
    assert np.abs(off_lead(q, x["A"], x["B"])).max() < PLUMB


def test_two_gantries_out_of_step_pull_their_hoist_ropes_off_plumb():
    x, want = FORMS["C10f"]["given"], FORMS["C10f"]["expected"]
    assert x["L"] == ROPE
    A, B = (-10.0, 4.0), (10.0, 4.0)

    def apart(late: float) -> float:
        s = started(lifted(A, B, "prescribed"), sample_ns=SECOND)
        for name, t in (("east", 0.0), ("west", late)):
            hand_over(s, round(t * SECOND))
            s.references.set_profile(f"drive-{name}", round(t * SECOND), x["v"], 0.5, None)
            s.settle()
        hand_over(s, 5 * SECOND)
        west, east = s.row().q[-2:]
        return float(east - west) - (B[0] - A[0])

    assert apart(0.0) == 0.0, "the same command, in the same bits"
    assert apart(x["dt"]) == pytest.approx(want["dx"], abs=1e-12)

    s = started(replace(lifted(A, B, "prescribed", want["dx"]), gravity=x["W"] / MASS))
    equilibrium(s)
    assert np.abs(off_lead(s.row().q, A, B)) == pytest.approx([want["angle_deg"]] * 2, rel=CLOSE)
    pull = s.row().pull * np.sin(np.radians(want["angle_deg"]))
    assert pull == pytest.approx([want["H"]] * 2, rel=CLOSE)
