"""Dynamic hoisting factors of one load on one rope: pick-up, ramps, sudden loss, emergency stop (C07b-c, C22, C23)."""

import json
from dataclasses import replace
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel.description import Body, Joint, Line, Point, Rope, Stop, System
from heavylift.kernel.simulation import Simulation
from small_scenes import EA, LENGTH, MASS, SECOND, G, Y, Z, column, hand_over, hung, started

FORMS = {x["id"]: x for x in json.loads((Path(__file__).parents[3] / "data" / "closed_forms.json").read_text())}
FACTOR = 1e-3  # the closed forms are for constant stiffness; a winch law stiffens a rope that it shortens
FINE = {"tolerance": 1e-10, "sample_ns": SECOND // 200}


def hanging(m: float, k: float, L: float, **rope) -> System:
    """At rest under its weight on a rope of stiffness k."""
    scene = hung(L + m * G / k, L, **rope)
    ropes = (replace(scene.ropes[0], EA=k * L),)
    return replace(scene, bodies=(Body("load", m),), ropes=ropes)


def peak(s: Simulation) -> float:
    """Largest tension at an accepted step or sample [N]."""
    return max(float(column(s, "rope/peak")[1].max()), float(column(s, "rope/tension")[1].max()))


def test_a_load_picked_up_at_full_hoist_speed_has_the_peak_tension_of_the_closed_form():
    x, want = FORMS["C07b"]["given"], FORMS["C07b"]["expected"]
    m, k, L = x["m"], x["k"], 1e4 * x["L"]  # so much rope of the same stiffness that winding changes it little
    stiff = 1e12
    ground = Stop("ground", "load-guide", -L + m * G / stiff, 1e6, stiff, 0.6 * sqrt(stiff * m))
    scene = replace(hanging(m, k, L, winch=True), stops=(ground,))
    scene = replace(scene, joints=tuple(replace(j, q0=(-L,)) for j in scene.joints))
    s = started(scene, **FINE)
    s.references.set_profile("rope", 0, -x["v"], 1e6, None)
    s.settle()
    hand_over(s, SECOND)
    assert peak(s) / (m * G) == pytest.approx(want["phi"], rel=FACTOR)
    t_lift = next(t for t, e in s.log if e.name == "ground" and e.what == "open") * 1e-9
    assert t_lift == pytest.approx(want["t_lift"], rel=3e-3)


def test_the_peak_tension_of_a_slow_pick_up_stays_within_the_design_factors_of_standards():
    """C07a's load at C07d's speed: above what marine rules take for slow lifts, below every hoisting class."""
    x, want = FORMS["C07d"]["given"], FORMS["C07d"]["expected"]
    k = EA / LENGTH
    stiff = 1e12
    ground = Stop("ground", "load-guide", -LENGTH + MASS * G / stiff, 1e6, stiff, 0.6 * sqrt(stiff * MASS))
    scene = replace(hanging(MASS, k, LENGTH, winch=True), stops=(ground,))
    s = started(replace(scene, joints=tuple(replace(j, q0=(-LENGTH,)) for j in scene.joints)), **FINE)
    s.references.set_profile("rope", 0, -x["v_h"], 1e6, None)
    s.settle()
    hand_over(s, 8 * SECOND)
    factor = peak(s) / (MASS * G)
    assert want["NobleDenton_onshore_1000_2500t"] < factor < want["EN13001_HC1"]
    assert factor == pytest.approx(1.0 + x["v_h"] * sqrt(k / MASS) / G, rel=FACTOR)


def test_accelerating_a_hanging_load_gives_the_expected_peak_tension():
    x, want = FORMS["C07c"]["given"], FORMS["C07c"]["expected"]
    m, k, L = x["m"], x["k"], 6e5
    s = started(hanging(m, k, L, winch=True), **FINE)
    s.references.set_profile("rope", 0, -x["v"], x["v"] / x["ta"], None)
    s.settle()
    hand_over(s, 4 * SECOND)
    t, T = column(s, "rope/tension")
    ramp = t <= x["ta"]
    assert T[ramp].max() / (m * G) == pytest.approx(want["phi_in_ramp"], rel=FACTOR)
    assert T[~ramp].max() / (m * G) == pytest.approx(want["phi_after"], rel=FACTOR)
    # the excess over the weight is what the ramp has done: it is right to a percent of itself
    assert T[ramp].max() / (m * G) - 1.0 == pytest.approx(want["phi_in_ramp"] - 1.0, rel=0.01)


def test_after_a_load_loses_part_of_its_mass_the_rest_rebounds_as_in_the_closed_form():
    x, want = FORMS["C22"]["given"], FORMS["C22"]["expected"]
    m, k, part, L = x["m"], x["k"], x["dm_over_m"], 60.0
    kept, lost = m * (1.0 - part), m * part
    stiff = 1e4 * k
    down, below = m * G / k, lost * G / stiff
    bodies = (Body("load", kept), Body("part", lost))
    joints = (
        Joint("load-guide", "prismatic", "world", "load", axis=Z, q0=(-L - down,)),
        Joint("part-guide", "prismatic", "world", "part", axis=Z, q0=(-L - down - 1.0 - below,)),
    )
    ropes = (
        Rope("rope", (Line(Point("world"), Point("load")),), k * L, L),
        Rope("hook", (Line(Point("load"), Point("part")),), stiff, 1.0),
    )
    s = started(System(bodies, joints, ropes=ropes, gravity=G), **FINE)
    s.interrupt(0)
    s.unhook("hook")
    s.settle()
    hand_over(s, 2 * SECOND)
    _, T = column(s, "rope/tension")
    assert T[:, 0].min() / (m * G) == pytest.approx(want["phi3"], rel=FACTOR)


@pytest.mark.parametrize("ramp", [0.4, 1e-4])
def test_an_emergency_stop_while_lowering_gives_the_expected_peak_tension(ramp):
    x, want = FORMS["C23"]["given"], FORMS["C23"]["expected"]
    m, k, L, v = x["m"], x["k"], 6e5, x["v"]
    scene = hanging(m, k, L, winch=True)
    scene = replace(scene, joints=tuple(replace(j, v0=(-v,)) for j in scene.joints))
    s = started(scene, **FINE)
    s.references.set_profile("rope", 0, v, 1e9, None)  # it is lowering already
    s.settle()
    hand_over(s, SECOND)
    s.references.set_profile("rope", SECOND, 0.0, v / ramp, None)
    s.settle()
    hand_over(s, 4 * SECOND)
    t, T = column(s, "rope/tension")
    phi = T[t > 1.0 + ramp].max() / (m * G)
    assert phi == pytest.approx(want["phi"] if ramp == x["ts"] else want["phi_instant"], rel=FACTOR)


def test_the_rope_tension_at_the_bottom_of_a_swing_is_that_of_the_pendulum_formula():
    x, want = FORMS["C11b"]["given"], FORMS["C11b"]["expected"]
    m, L, start = x["m"], x["L"], np.radians(x["th0_deg"])
    k = 1e9
    hold = m * G * np.cos(start) / k  # the stretch at the end of the swing
    bodies = (Body("carrier", 0.0), Body("load", m))
    joints = (
        Joint("pivot", "revolute", "world", "carrier", axis=Y, q0=(start,)),
        Joint("slide", "prismatic", "carrier", "load", (0.0, 0.0, -L), axis=Z, q0=(-hold,)),
    )
    rope = Rope("rope", (Line(Point("world"), Point("load")),), k * L, L, damping=2.0 * sqrt(k * m))
    s = started(System(bodies, joints, ropes=(rope,), gravity=G), **FINE)
    assert float(s.row().tension[0]) == pytest.approx(want["T_end"], rel=1e-6)
    hand_over(s, 5 * SECOND)
    assert peak(s) == pytest.approx(want["T_bottom"], rel=1e-4)
