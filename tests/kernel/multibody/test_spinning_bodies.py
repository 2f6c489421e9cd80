"""Rotations: the symmetric top of C17, and quaternions that stay of unit length for an hour."""

import json
from dataclasses import replace
from math import cos, pi, sin
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel.description import Body, Joint, System
from scipy.spatial.transform import Rotation
from small_scenes import SECOND, hand_over, started

FORMS = json.loads((Path(__file__).parents[2] / "data" / "closed_forms.json").read_text())
C17 = next(x for x in FORMS if x["id"] == "C17")
I1, I3, W3, WT = (C17["given"][k] for k in ("I1", "I3", "w3", "wt"))
UNIT = 1e-12
DRIFT = 1e-8  # of |H| and E per 100 s


def top(kind: str, mass: float = 5.0e5) -> System:
    """A body that spins about its axis of symmetry and wobbles; no gravity.

    No body has I3 > 2 I1; the rest comes from a rotor without mass.
    """
    inertia = ((I1, 0.0, 0.0), (0.0, I1, 0.0), (0.0, 0.0, 2 * I1))
    rest = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, I3 - 2 * I1))
    v0 = (WT, 0.0, W3)
    v0 = v0 if kind == "spherical" else (0.3, -0.2, 0.1, *v0)
    joints = (Joint("spin", kind, "world", "top", v0=v0), Joint("geared", "fixed", "top", "rotor"))
    return System((Body("top", mass, inertia=inertia), Body("rotor", 0.0, inertia=rest)), joints, gravity=0.0)


@pytest.mark.parametrize("kind", ["free", "spherical"])
def test_a_top_free_of_torque_turns_as_the_closed_form_predicts(kind):
    s = started(top(kind), tolerance=1e-12, sample_ns=SECOND)
    lam, T = C17["expected"]["lam"], C17["expected"]["T_body"]
    hand_over(s, round(T * SECOND))
    assert s.state[s.program.nq :][-3:][:3] == pytest.approx(C17["expected"]["w_after_one_period"], abs=1e-9)
    s.settle()
    hand_over(s, 100 * SECOND)
    w = s.state[: s.program.nq + s.program.nv][-3:]
    assert w == pytest.approx([WT * cos(lam * 100.0), WT * sin(lam * 100.0), W3], abs=1e-9)
    energy, momentum = [], []
    for _, row in s.rows:
        w = row[s.method.row_layout.at["v"]][-3:]
        R = Rotation.from_quat(row[s.method.row_layout.at["q"]][-4:])
        H = np.array([I1, I1, I3]) * w
        energy.append(H @ w / 2)
        momentum.append(R.apply(H))
    assert np.ptp(energy) < DRIFT * energy[0]
    assert np.ptp(momentum, axis=0).max() < DRIFT * np.linalg.norm(momentum[0])


def test_the_axis_of_a_top_precesses_about_its_angular_momentum():
    s = started(top("free"), tolerance=1e-12, sample_ns=SECOND)
    hand_over(s, 100 * SECOND)
    H = np.array([I1 * WT, 0.0, I3 * W3])
    rate, axis = C17["expected"]["precession"], H / np.linalg.norm(H)
    got = Rotation.from_quat(s.row().q[3:7]).apply([0.0, 0.0, 1.0])
    want = Rotation.from_rotvec(axis * rate * 100.0).apply([0.0, 0.0, 1.0])
    assert got == pytest.approx(want, abs=1e-9)
    assert 2 * pi / rate == pytest.approx(14.404, abs=1e-3)


@pytest.mark.parametrize("tolerance", [1e-5, 1e-9])
def test_quaternions_keep_unit_length_for_an_hour(tolerance):
    s = started(top("free"), tolerance=tolerance, sample_ns=10 * SECOND)
    s.run(3600 * SECOND)
    hand_over(s, 3600 * SECOND)
    lengths = [np.linalg.norm(s.state[3:7])]
    assert np.abs(np.array(lengths) - 1.0).max() < UNIT
    assert s["accepted"] > 1000
    poses = np.array([row[s.method.row_layout.at["poses"]] for _, row in s.rows])
    R = poses[:, 3:12].reshape(-1, 3, 3)
    assert np.abs(R @ R.transpose(0, 2, 1) - np.eye(3)).max() < UNIT, "rotations in samples are rotations"


def test_scaling_a_start_quaternion_does_not_change_the_attitude():
    """It is brought to unit length by the first step."""
    ends = []
    for length in (1.0, 3.0):
        spin, geared = top("spherical").joints
        turned = replace(spin, q0=(0.0, 0.0, 0.6 * length, 0.8 * length))
        s = started(replace(top("spherical"), joints=(turned, geared)), tolerance=1e-12)
        hand_over(s, 10 * SECOND)
        ends.append(s.row().q)
    assert ends[0] == pytest.approx(ends[1], abs=1e-8)
