"""Frequencies, damping and shapes of linearised scenes against closed forms and SciPy's eigenvalues."""

import json
from dataclasses import replace
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel.analysis import equilibrium, modes
from heavylift.kernel.description import Body, Joint, JointSpring, Line, Point, Rope, System
from scipy.linalg import eigh
from small_scenes import EA, LENGTH, MASS, G, X, Y, Z, hung, started

FORMS = {x["id"]: x for x in json.loads((Path(__file__).parents[2] / "data" / "closed_forms.json").read_text())}
CLOSE = 1e-8  # relative: fourth-order differences over 1e-4
DAMPED = 1e-7


def found(system: System):
    simulation = started(system)
    equilibrium(simulation)
    return modes(simulation)


def pulsations(system: System) -> list[float]:
    return [2.0 * pi * m.frequency for m in found(system).oscillations]


def hinge(name: str, parent: str, child: str, z: float = 0.0, q0: float = 0.0) -> Joint:
    return Joint(name, "revolute", parent, child, (0.0, 0.0, z), axis=Y, q0=(q0,))


def test_a_physical_pendulum_has_its_exact_frequency_from_any_start_pose():
    x, want = FORMS["C02"]["given"], FORMS["C02"]["expected"]
    m, d, I = x["m"], x["d"], want["I_G"]
    body = Body("block", m, (0.0, 0.0, -d), ((I, 0.0, 0.0), (0.0, I, 0.0), (0.0, 0.0, I)))
    for start in (0.0, 1.0, 3.0):
        assert pulsations(System((body,), (hinge("pivot", "world", "block", q0=start),), gravity=G)) == pytest.approx(
            [want["omega"]], rel=CLOSE
        )


def test_a_block_on_six_ropes_has_the_yaw_and_sway_periods_of_the_closed_form():
    x, want = FORMS["C02b"]["given"], FORMS["C02b"]["expected"]
    m, L, I = x["m"], x["L"], x["I_z"]
    h = 1e4  # ropes so stiff that they hardly stretch
    body = Body("block", m, inertia=((I, 0.0, 0.0), (0.0, I, 0.0), (0.0, 0.0, I)))
    stretch = m * G / 6.0 / (m * G * h)
    ropes = tuple(
        Rope(f"r{i}", (Line(Point("world", (a, b, L)), Point("block", (a, b, 0.0))),), m * G * h, L * (1.0 - stretch))
        for i, (a, b) in enumerate(x["ropes"])
    )
    scene = System((body,), (Joint("free", "free", "world", "block"),), ropes=ropes, gravity=G)
    oscillations = found(scene).oscillations
    yaw = next(o for o in oscillations if o.joints[0][0] == "free.wz")
    sway = [o for o in oscillations if o.joints[0][0] in ("free.vx", "free.vy")]
    assert 1.0 / yaw.frequency == pytest.approx(want["T_yaw"], rel=1e-4)
    assert [1.0 / o.frequency for o in sway[:2]] == pytest.approx([want["T_sway"]] * 2, rel=1e-3)


def test_hook_block_and_load_swing_with_the_frequencies_of_a_double_pendulum():
    x, want = FORMS["C03"]["given"], FORMS["C03"]["expected"]
    bodies = (Body("hook", x["m1"], (0.0, 0.0, -x["L1"])), Body("load", x["m2"], (0.0, 0.0, -x["L2"])))
    joints = (hinge("upper", "world", "hook", q0=0.2), hinge("lower", "hook", "load", -x["L1"], q0=-0.4))
    scene = System(bodies, joints, gravity=G)
    assert pulsations(scene) == pytest.approx([want["w1"], want["w2"]], rel=CLOSE)
    slow, fast = found(scene).oscillations
    assert slow.bodies[0][0] == "load"
    assert fast.bodies[0] == ("hook", pytest.approx(1.0, abs=0.1))  # the heavy load stays


def test_a_pendulum_on_a_free_trolley_has_its_exact_frequency():
    x, want = FORMS["C04"]["given"], FORMS["C04"]["expected"]
    bodies = (Body("trolley", x["M"]), Body("load", x["m"], (0.0, 0.0, -x["L"])))
    joints = (Joint("rail", "prismatic", "world", "trolley", axis=X), hinge("pivot", "trolley", "load"))
    result = found(System(bodies, joints, gravity=G))
    assert [2.0 * pi * m.frequency for m in result.oscillations] == pytest.approx([want["w"]], rel=CLOSE)
    assert result.free == 1  # both together roll away
    rail, pivot = np.abs(result.oscillations[0].shape)
    load = abs(result.oscillations[0].shape[0] - x["L"] * result.oscillations[0].shape[1])
    assert rail / load == pytest.approx(x["m"] / x["M"], rel=CLOSE)  # their centre stays
    assert pivot > 0.0


def test_a_load_bounces_on_its_rope_with_the_expected_frequency():
    form = FORMS["C07a"]
    rope = replace(hung(LENGTH + 0.1).ropes[0], EA=form["given"]["k"] * LENGTH)
    assert pulsations(replace(hung(LENGTH + 0.1), ropes=(rope,))) == pytest.approx(
        [form["expected"]["omega"]], rel=CLOSE
    )


@pytest.mark.parametrize("zeta", [0.0, 0.02, 0.7])
def test_a_damped_rope_reports_the_damping_ratio_of_its_load(zeta):
    w = sqrt(EA / LENGTH / MASS)
    (mode,) = found(hung(LENGTH + 0.1, damping=2.0 * zeta * w * MASS)).oscillations
    assert mode.damping == pytest.approx(zeta, rel=DAMPED, abs=DAMPED)
    assert 2.0 * pi * mode.frequency == pytest.approx(w, rel=DAMPED)


def test_the_modes_of_an_overdamped_rope_have_decay_rates_and_no_frequencies():
    w = sqrt(EA / LENGTH / MASS)
    result = found(hung(LENGTH + 0.1, damping=2.0 * 2.0 * w * MASS))
    assert result.oscillations == ()
    assert result.decays == pytest.approx([w * (2.0 - sqrt(3.0)), w * (2.0 + sqrt(3.0))], rel=1e-6)


def test_a_beam_on_two_springs_bounces_and_pitches():
    """w^2 = 2 k / m and 2 k b^2 / I; the vertical ropes are its springs."""
    m, I, b, k, L = 1e5, 4e6, 8.0, 5e6, 500.0
    body = Body("beam", m, inertia=((I, 0.0, 0.0), (0.0, I, 0.0), (0.0, 0.0, I)))
    joints = (
        Joint("up", "prismatic", "world", "carrier", axis=Z),
        Joint("pitch", "revolute", "carrier", "beam", axis=Y),
    )
    ropes = tuple(
        Rope(f"r{s:+.0f}", (Line(Point("world", (s * b, 0.0, L)), Point("beam", (s * b, 0.0, 0.0))),), k * L, L)
        for s in (-1.0, 1.0)
    )
    scene = System((Body("carrier", 0.0), body), joints, ropes=ropes, gravity=G)
    bounce, pitch = sqrt(2.0 * k / m), sqrt(2.0 * k * b * b / I)
    assert pulsations(scene) == pytest.approx([bounce, pitch], rel=CLOSE)


def test_a_chain_of_masses_has_the_eigenvalues_of_scipy():
    n, random = 7, np.random.default_rng(5)
    m, k = random.uniform(1.0, 9.0, n), random.uniform(1e2, 1e4, n)
    bodies = tuple(Body(f"m{i}", float(m[i])) for i in range(n))
    joints = tuple(
        Joint(f"s{i}", "prismatic", f"m{i - 1}" if i else "world", f"m{i}", (1.0, 0.0, 0.0), axis=X) for i in range(n)
    )
    springs = tuple(JointSpring(f"k{i}", f"s{i}", float(k[i])) for i in range(n))
    K = np.diag(k + np.append(k[1:], 0.0)) - np.diag(k[1:], 1) - np.diag(k[1:], -1)
    want = np.sqrt(eigh(K, np.diag(m), eigvals_only=True))
    assert pulsations(System(bodies, joints, springs, gravity=G)) == pytest.approx(want, rel=CLOSE)


def test_an_upright_inverted_pendulum_has_its_exact_growth_rate():
    body = Body("rod", 1.0, (0.0, 0.0, 2.0))
    simulation = started(System((body,), (hinge("foot", "world", "rod"),), gravity=G))
    equilibrium(simulation)  # exactly upright: at rest, though not stable
    assert modes(simulation).decays == pytest.approx([-sqrt(G / 2.0), sqrt(G / 2.0)], rel=CLOSE)


def test_computing_the_modes_of_a_scene_does_not_change_its_state():
    simulation = started(hung(LENGTH + 0.1))
    equilibrium(simulation)
    before = simulation.state.copy()
    modes(simulation)
    assert np.array_equal(simulation.state, before)


@pytest.mark.parametrize(("start", "growth"), [(0.0, sqrt(G / 2.0)), (0.3, 0.0)])
def test_a_linear_model_is_unstable_for_an_upright_pendulum_and_stable_for_a_hanging_one(start, growth):
    bob = Body("bob", 3.0, (0.0, 0.0, 2.0))
    stands = found(System((bob,), (hinge("pivot", "world", "bob", q0=start),), gravity=G))
    assert stands.growth == pytest.approx(growth, rel=CLOSE)
