"""Equalisers hold one tension (C08d, C09): one rope over several hooks, and a beam that tilts."""

import json
from math import cos, hypot, radians, sin
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel.description import Body, InputSignal, Joint, Line, Point, Reeving, Rope, Sheave, System
from heavylift.kernel.simulation import Simulation
from small_scenes import SECOND, G, cube, started

EQUAL = 1e-9  # parts of a rope without friction
FINE = {"tolerance": 1e-10, "sample_ns": 20_000_000}
FORMS = {c["id"]: c for c in json.loads((Path(__file__).parents[3] / "data" / "closed_forms.json").read_text())}


def tensions(s: Simulation, parts: int) -> np.ndarray:
    return np.array(s.row().shown[:parts])


def test_an_equaliser_keeps_equal_tension_for_any_rope_lengths():
    """One rope over the sheaves of two hooks (Ham, Roh, Lee 2016: one length row): equal tension in all parts at any
    tilt, where two ropes of their own would differ; C09 with h = 0."""
    beam = Body("beam", 1000.0, inertia=cube(1000.0, 3.0))
    joint = Joint("free", "free", "world", "beam", q0=(0.0, 0.0, -10.0, 0.0, sin(0.05), 0.0, cos(0.05)))
    at = [Point("beam", (x, 0.0, 0.0)) for x in (-2.0, 2.0)]
    top = [Point("world", (x, 0.0, 0.0)) for x in (-2.0, 0.0, 2.0)]
    drop = [10.0 + x * sin(0.1) for x in (-2.0, 2.0)]
    spans = [hypot(x - 2.0 * cos(0.1), z) for x, z in zip((2.0, 0.0, 0.0, 2.0), sorted(drop * 2), strict=True)]
    L0 = sum(spans) / (1 + 1000.0 * G / 4 / 1e7)
    rope = Reeving("eq", top[0], (Sheave(at[0]), Sheave(top[1]), Sheave(at[1])), top[2], 1e7, InputSignal(L0))
    s = started(System((beam,), (joint,), forces=(rope,), gravity=G), **FINE)
    s.interrupt(SECOND)
    T = tensions(s, 4)
    assert T.min() > 100.0
    assert np.ptp(T) <= EQUAL * T.max()


def test_an_equaliser_beam_shares_its_load_by_its_tilt():
    """C09: (T1 - T2)/(T1 + T2) = (h/c) tan phi; with the expected ratio the tilted beam stands still."""
    given, expected = FORMS["C09"]["given"], FORMS["C09"]["expected"]
    c, h, phi = given["c"], given["h"], radians(given["phi_deg"])
    W, EA, top = 1e5, 1e8, 20.0
    beam = Body("beam", W / G, (0.0, 0.0, 0.0), cube(W / G))
    joint = Joint("pin", "free", "world", "beam", q0=(0.0, 0.0, 0.0, 0.0, sin(phi / 2), 0.0, cos(phi / 2)))
    T2 = W / (1.0 + expected["T1_over_T2"])
    ropes = []
    for name, x, T in (("one", -c, W - T2), ("two", c, T2)):
        place = (x * cos(phi) + h * sin(phi), 0.0, -x * sin(phi) + h * cos(phi))
        l = top - place[2]
        line = Line(Point("world", (place[0], 0.0, top)), Point("beam", (x, 0.0, h)))
        ropes.append(Rope(name, (line,), EA, l / (1.0 + T / EA)))
    s = started(System((beam,), (joint,), ropes=tuple(ropes), gravity=G))
    n = s.program.nq
    assert s.X[s.native.at["f"]][n : n + 6] == pytest.approx(np.zeros(6), abs=1e-6)


def test_length_errors_do_not_unbalance_the_tensions_of_an_equaliser():
    """C08d: four ropes share a block by their lengths, +-k dL/4 on the diagonals; one rope over four eyes does not."""
    given, expected = FORMS["C08d"]["given"], FORMS["C08d"]["expected"]
    k, dL, h, W = given["k"], given["dL"], 50.0, 6e6
    block = Body("block", W / G, inertia=cube(W / G, 20.0))
    corners = [(x, y, 0.0) for x, y in ((-10.0, -9.0), (10.0, -9.0), (10.0, 9.0), (-10.0, 9.0))]
    joint = Joint("free", "free", "world", "block", q0=(0.0, 0.0, -h, 0.0, 0.0, 0.0, 1.0))
    L0 = h / (1.0 + W / 4 / (k * h))
    long = [dL / 2 * sign for sign in (-1.0, 1.0, -1.0, 1.0)]  # of the two diagonals, so that the block stays level
    ropes = tuple(
        Rope(f"r{i}", (Line(Point("world", c), Point("block", c)),), k * h, L0 - d / 2)
        for i, (c, d) in enumerate(zip(corners, long, strict=True))
    )
    free = started(System((block,), (joint,), ropes=ropes, gravity=G))
    T = free.row().tension
    assert abs(T - W / 4) == pytest.approx(np.abs(expected["dT"]), rel=2e-3)  # strain
    turns = [(body, c) for i, c in enumerate(corners) for body in (("block", "world") if i % 2 else ("world", "block"))]
    eyes = [Sheave(Point(body, c)) for body, c in turns]
    rope = Reeving(
        "one", eyes[0].at, tuple(eyes[1:-1]), eyes[-1].at, k * h, InputSignal(200.0 + 3 * 20.0 + sum(long)), 1e5
    )
    s = started(System((block,), (joint,), forces=(rope,), gravity=G))
    assert np.ptp(tensions(s, 7)) == 0.0
