"""Peak tensions between the ends of integration steps are found with the accuracy of the steps."""

from dataclasses import replace
from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from heavylift.kernel.description import Body, Joint, Line, Point, Rope, Spring, System
from heavylift.kernel.simulation.native import NODES
from scipy_peers import PEERS
from small_scenes import EA, LENGTH, MASS, SECOND, G, Z, column, cube, hand_over, hung, started

EXACT = 1e-4  # of the peak, where a run is as exact as that itself
SPIKE = 0.02  # [s]

METHODS = {
    "dopri5": {"tolerance": 1e-9},
    "dop853": {"tolerance": 1e-9},
    "radau5": {"tolerance": 1e-7},
    "rk4": {"step": 5e-3},
    **{name: {"tolerance": 1e-8} for name in PEERS},
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("stiffer", [1.0, 30.0])
@pytest.mark.large(beyond=9)
def test_releasing_a_load_on_a_straight_unloaded_rope_gives_a_peak_tension_of_twice_its_weight(method, stiffer):
    """With dop853 a step is up to two radians long, and its ends may miss a tenth of the swing."""
    scene = hung(LENGTH)
    scene = replace(scene, ropes=(replace(scene.ropes[0], EA=EA * stiffer),))
    s = started(scene, method=method, sample_ns=SECOND // 20, **METHODS[method])
    hand_over(s, SECOND)
    peaks, when = column(s, "rope/peak")[1], column(s, "rope/peak_time")[1]
    k = int(np.argmax(peaks[:, 0]))
    assert peaks[k, 0] == pytest.approx(2.0 * MASS * G, rel=EXACT)
    w = sqrt(EA * stiffer / LENGTH / MASS)
    assert (when[k, 0] * w / pi) % 2.0 == pytest.approx(1.0, abs=0.02), "at the bottom of a swing"


@pytest.mark.parametrize("method", ["dopri5", "dop853", "radau5"])
def test_a_tension_spike_within_one_integration_step_is_found_as_peak_tension(method):
    """At a loose tolerance the rope is taut and slack again within a step, with no tension at both of its ends."""
    m, h = 100.0, 0.2
    w = pi / SPIKE
    scene = hung(LENGTH - h)
    rope = replace(scene.ropes[0], EA=m * w * w * LENGTH)
    scene = replace(scene, bodies=(replace(scene.bodies[0], mass=m),), ropes=(rope,))
    s = started(scene, tolerance=1e-6, sample_ns=SECOND // 2, method=method)
    hand_over(s, SECOND // 2)
    want = m * G + sqrt((m * G) ** 2 + 2.0 * m * w * w * m * G * h)
    assert column(s, "rope/peak")[1].max() == pytest.approx(want, rel=EXACT)


def swung(seed: int) -> System:
    """A load aside of its rope, which is stretched by less than its weight."""
    angle, turned = draw(seed, 0.05, 0.6), draw(seed, 0.0, 2.0 * pi)
    reach = LENGTH * (1.0 + 0.5 * draw(seed, 0.0, 1.0) * MASS * G / EA)
    place = (reach * sin(angle) * cos(turned), reach * sin(angle) * sin(turned), -reach * cos(angle))
    free = Joint("free", "free", "world", "load", q0=(*place, 0.0, 0.0, 0.0, 1.0))
    rope = Rope("rope", (Line(Point("world"), Point("load", (0.1, 0.2, 0.0))),), EA, LENGTH)
    return System((Body("load", MASS, inertia=cube(MASS)),), (free,), ropes=(rope,), gravity=G)


def draw(seed: int, low: float, high: float) -> float:
    """A random number, one for each range."""
    return float(np.random.default_rng([seed, round(1e6 * low), round(1e6 * high)]).uniform(low, high))


@pytest.mark.parametrize("scene", [hung(LENGTH), swung(2)], ids=["guided", "turning"])
def test_the_search_for_peaks_between_integration_steps_changes_no_other_result(scene):
    """Bit for bit, however the time is handed over, and where commands discard the step in which the peak was."""
    whole, parts, calm = (started(scene, method="dop853", sample_ns=SECOND // 20) for _ in range(3))
    calm.X[calm.native.at["top"]] = np.inf  # nothing can be higher
    hand_over(whole, SECOND)
    hand_over(calm, SECOND)
    for t in range(1, 101):
        parts.run(t * SECOND // 100)
    hand_over(parts, SECOND)
    assert whole["searched"] > calm["searched"] == 0.0
    assert all(
        whole.X[whole.native.at[n]].tobytes() == parts.X[parts.native.at[n]].tobytes()
        for n in ("top", "peak", "Ta", "Tb")
    )
    assert whole.state.tobytes() == calm.state.tobytes()
    assert [row.tobytes() for _, row in whole.rows] == [row.tobytes() for _, row in parts.rows]


def beating(started_at: tuple[float, ...], springs: tuple[float, ...]) -> System:
    """Loads on ropes side by side, begun so many times their stretch too low; between neighbours springs that are as
    stiff as so many ropes."""
    stretch, far = MASS * G * LENGTH / EA, 1000.0  # [m]
    names = [f"load-{i}" for i in range(len(started_at))]
    bodies = tuple(Body(name, MASS) for name in names)
    depths = [LENGTH + stretch * (1.0 + x) for x in started_at]
    joints = tuple(
        Joint(f"{n}-guide", "prismatic", "world", n, axis=Z, q0=(-d,)) for n, d in zip(names, depths, strict=True)
    )
    ropes = tuple(Rope(f"{n}-rope", (Line(Point("world"), Point(n)),), EA, LENGTH) for n in names)
    between = zip(names, names[1:], springs, strict=False)
    forces = tuple(Spring(b, Point(a, (0.0, 0.0, far)), Point(b), far, k=EA / LENGTH * e) for a, b, e in between)
    return System(bodies, joints, ropes=ropes, forces=forces, gravity=G)


def highest(started_at: tuple[float, ...], springs: tuple[float, ...], end: float) -> tuple[np.ndarray, np.ndarray]:
    """By normal modes, of each rope: largest tension over the weight, and when [s]."""
    stiffness = np.eye(len(started_at))
    for i, e in enumerate(springs):
        stiffness[i : i + 2, i : i + 2] += [[e, -e], [-e, e]]
    squares, modes = np.linalg.eigh(stiffness * EA / LENGTH / MASS)
    t = np.arange(0.0, end, 4e-4)  # 3e-6 of a swing's top may be missed
    x = (modes * (modes.T @ np.array(started_at))) @ np.cos(np.sqrt(squares)[:, None] * t)
    return 1.0 + x.max(axis=1), t[x.argmax(axis=1)]


@pytest.mark.parametrize(("method", "tolerance"), [("dop853", 1e-8), ("dopri5", 1e-8), ("radau5", 1e-7)])
@pytest.mark.parametrize(
    ("started_at", "springs", "end"),
    [((0.9, 0.0), (0.003,), 277), ((0.5, 0.4, 0.0), (0.004, 0.003), 120), ((-0.3, 0.5, 0.1), (0.02, 0.0005), 150)],
)
def test_a_peak_tension_is_found_even_if_it_is_the_late_maximum_of_a_beating_oscillation(
    method, tolerance, started_at, springs, end
):
    """Each of hundreds of hills is a little higher than all before, of one rope, of two, and in no simple order."""
    want, late = highest(started_at, springs, end)
    assert np.sort(late)[1 - len(late) :].min() > 20.0, "after more than 26 swings, in all ropes but one"
    s = started(beating(started_at, springs), method=method, tolerance=tolerance, sample_ns=SECOND)
    hand_over(s, end * SECOND)
    assert column(s, "rope/peak")[1].max(axis=0) / (MASS * G) == pytest.approx(want, rel=EXACT)


@pytest.mark.parametrize(("method", "part"), [("dopri5", 0.1), ("dop853", 0.15), ("radau5", 0.1)])
def test_the_search_for_peaks_between_samples_costs_at_most_a_tenth_of_all_rate_evaluations(method, part):
    """One hill is as high as the other, and each might be a little higher; dop853 has eight steps in a swing."""
    s = started(hung(LENGTH), method=method, tolerance=1e-6, sample_ns=SECOND)
    hand_over(s, 100 * SECOND)
    swings = 100.0 * sqrt(EA / LENGTH / MASS) / (2.0 * pi)
    how, inner = s.method.method, len(NODES) - 2 + (3 if method == "dop853" else 0)
    steps = s.native.attempts * how.evaluations + sum(n * s[name] for name, n in how.counted.items())
    assert s["searched"] <= 2.0 * swings
    assert s["searched"] * inner <= part * steps


def test_machine_code_and_interpreted_python_and_a_restored_snapshot_find_the_same_peaks_between_samples():
    """A simulation that goes on in the middle of hills finds the same ones."""
    whole, oracle, twin = (
        started(hung(LENGTH), method="dop853", tolerance=1e-6, sample_ns=SECOND, native=n) for n in (True, False, True)
    )
    for s in (whole, oracle):
        s.run(2 * SECOND)
    at = whole.native.at
    assert whole["searched"] == oracle["searched"] > 3.0
    for name in ("top", "Ta", "Tb"):
        assert whole.X[at[name]] == pytest.approx(oracle.X[at[name]], rel=1e-9)
    twin.restore(whole.snapshot())
    for s in (whole, twin):
        s.run(30 * SECOND)
    assert twin.X.tobytes() == whole.X.tobytes()


TOLERANCES = {
    "dopri5": (1e-5, 1e-8, 1e-11),
    "dop853": (1e-5, 1e-8, 1e-11),
    "radau5": (1e-5, 1e-7, 1e-9),
}


@pytest.mark.parametrize("method", TOLERANCES)
@pytest.mark.parametrize("seed", range(3))
def test_the_error_of_a_peak_tension_in_a_snatch_is_within_the_tolerance(method, seed):
    """A load falls into its rope: T = m g (1 + sqrt(1 + 2 h k / m g)), the tops of its swings between many short steps
    as between few long ones."""
    fall, stiffer = draw(seed, 0.0, 0.1), 10.0 ** draw(seed, 0.0, 1.5)
    scene = hung(LENGTH - fall)
    scene = replace(scene, ropes=(replace(scene.ropes[0], EA=EA * stiffer),))
    want = MASS * G * (1.0 + sqrt(1.0 + 2.0 * fall * EA * stiffer / LENGTH / (MASS * G)))
    for tolerance in TOLERANCES[method]:
        s = started(scene, method=method, tolerance=tolerance, sample_ns=SECOND // 7)
        hand_over(s, SECOND)
        assert abs(column(s, "rope/peak")[1].max() / want - 1.0) < 20.0 * tolerance


@pytest.mark.parametrize(("method", "order"), [("rk4", 4), ("semi-implicit-euler", 1)])
def test_the_error_of_a_peak_tension_at_fixed_steps_is_that_of_the_integration(method, order):
    errors = []
    for step in (8e-3, 4e-3, 2e-3):
        s = started(hung(LENGTH - 0.05), method=method, step=step, sample_ns=SECOND // 7)
        hand_over(s, SECOND)
        want = MASS * G * (1.0 + sqrt(1.0 + 0.1 * EA / LENGTH / (MASS * G)))
        errors.append(abs(column(s, "rope/peak")[1].max() / want - 1.0))
    assert errors[1] < 0.75 * 0.5 ** (order - 1) * errors[0]
    assert errors[2] < 0.75 * 0.5 ** (order - 1) * errors[1]


@pytest.mark.parametrize("method", TOLERANCES)
@pytest.mark.parametrize("seed", range(2))
def test_the_error_of_a_peak_tension_in_a_swing_is_within_the_tolerance(method, seed):
    """A load let go aside of its rope bounces while it swings, against the samples of a run that is nearly exact; the
    motion until then is itself no better."""
    scene = swung(seed)
    fine = started(scene, method="dop853", tolerance=1e-12, sample_ns=SECOND // 5000)
    hand_over(fine, 4 * SECOND)
    want = column(fine, "rope/tension")[1].max()  # 3e-7 of it may be missed between samples
    for tolerance in TOLERANCES[method]:
        s = started(scene, method=method, tolerance=tolerance, sample_ns=SECOND)
        hand_over(s, 4 * SECOND)
        assert abs(column(s, "rope/peak")[1].max() / want - 1.0) < 200.0 * tolerance + 3e-7
