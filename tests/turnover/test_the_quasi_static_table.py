"""The lift agrees with its quasi-static planning table: lengths, positions and load shares at every stage.

How it is compared.  The table's rope lengths are geometric, for ropes that do not stretch: the run's UNSTRETCHED
lengths are held against it, for a winch knows what it has wound off; the block hangs lower by the stretch.  During a
turn, lengths and trolleys are functions of the COMMANDED angle (the laws that were sent), shares of the MEASURED one:
elasticity and swing shift it by up to half a degree.  Angles in degrees, loads in tonnes.
"""

from __future__ import annotations

import numpy as np
import pytest
from independent_mechanics import Mechanics
from stock_reader import Array, Reading
from the_run import Stage

LENGTH, PLACE = 2e-3, 5e-3  # [m] ropes against their laws; trolleys, which servos hold against the swinging load
SHARE = 0.005  # of the load
OFF_LEAD = 0.2  # degrees, of hook ropes while the load is still
ROUNDED = 0.05  # the table gives one decimal
STRETCH = (0.05, 0.15)  # [m] by which the block hangs lower than the table says: hook ropes and slings
STILL = ("settle", "settle on A", "rigging", "settle on A and C", "settle 2", "rest")
LOAD = 900.0
A, B = ("loader-1", "loader-2", "loader-4", "loader-5"), ("loader-3", "loader-6")


def arms(theta: Array, half: int) -> tuple[Array, Array]:
    """y of lugs A and B from the centre of mass [m]; half +1: B on the former top, -1: on the former bottom."""
    c, s = np.cos(np.radians(theta)), np.sin(np.radians(theta))
    return -14.6 * c, 12.0 * c + half * 5.6 * s


def lengths(theta: Array, half: int) -> tuple[Array, Array]:
    """L_A and L_B [m] with the centre of mass at z = 30."""
    c, s = np.cos(np.radians(theta)), np.sin(np.radians(theta))
    return 102.0 - (30.0 + 14.6 * s + 11.0), 88.0 - (30.0 + (-12.0 * s + half * 5.6 * c) + 33.0)


def loads(theta: Array, half: int) -> tuple[Array, Array]:
    """Sling load of one A loader and of one B loader [t]: moments about the centre of mass balance."""
    a, b = arms(theta, half)
    return LOAD * b / (b - a) / 4, LOAD * -a / (b - a) / 2


def carried(mechanics: Mechanics, loaders: tuple[str, ...]) -> Array:
    """(n, len(loaders)) vertical sling force per loader [t]."""
    by = [sum(mechanics.pulls[s].force[:, 2] for s in mechanics.slings if s.startswith(loader)) for loader in loaders]
    return np.stack(by, axis=1) / mechanics.g / 1e3


def measured(mechanics: Mechanics) -> Array:
    """(n,) theta [degrees], 0 to 180 and a little more."""
    return np.degrees(np.unwrap(mechanics.theta))


def commanded(reading: Reading) -> Array:
    """(n,) theta of the turn's trapezoids [degrees], from the profiles that the commander sent."""
    theta = np.zeros(len(reading.t))
    for event in reading.said("commander", "input", "SetProfile"):
        x = event["value"]
        distance, speed, accel = abs(x["distance"]), abs(x["speed"]), x["accel"]
        ramp = speed / accel
        total = distance / speed + ramp
        s = np.clip(reading.t - x["start_ns"] * 1e-9, 0.0, total)
        up, down = np.minimum(s, ramp), np.maximum(s - (total - ramp), 0.0)
        theta += 0.5 * accel * up**2 + speed * np.maximum(s - ramp, 0.0) - 0.5 * accel * down**2
    return np.degrees(theta)


def test_slings_tighten_at_the_tabulated_rope_lengths_while_the_block_is_on_supports(
    reading: Reading, stages: dict[str, Stage]
) -> None:
    k = stages["load"].samples[0]
    assert _ropes(reading, "H1", "H2")[k] == pytest.approx(84.0, abs=ROUNDED)
    assert _ropes(reading, "H3")[k] == pytest.approx(42.4, abs=ROUNDED)


@pytest.mark.parametrize(
    ("stage", "L_A", "L_B", "y_A", "y_B"),
    [
        ("settle", 61.0, 19.4, -14.6, 12.0),
        ("turn to 90 degrees", 46.4, 37.0, 0.0, 5.6),
        ("settle on A", 46.4, 37.2, 0.0, 5.6),
        ("re-rig, hooks up", 46.4, 34.2, 0.0, 5.6),
        ("re-rig, pass beneath", 46.4, 34.2, 0.0, -5.6),
        ("rigging", 46.4, 37.2, 0.0, -5.6),
        ("settle on A and C", 46.4, 37.0, 0.0, -5.6),
        ("settle 2", 61.0, 19.4, 14.6, -12.0),
    ],
)
def test_stages_of_the_scene_turnover_end_at_the_tabulated_states(
    reading: Reading, stages: dict[str, Stage], stage: str, L_A: float, L_B: float, y_A: float, y_B: float
) -> None:
    k = stages[stage].samples[-1]
    waiting = stage.startswith("re-rig")  # its last sample may lie before the end of the ramp
    assert _ropes(reading, "H1", "H2")[k] == pytest.approx(L_A, abs=LENGTH)
    assert _ropes(reading, "H3")[k] == pytest.approx(L_B, abs=0.01 if waiting else LENGTH)
    assert _trolleys(reading, "upper")[k] - 75.0 == pytest.approx(y_A, abs=PLACE)
    assert _trolleys(reading, "lower")[k] - 75.0 == pytest.approx(y_B, abs=0.02 if waiting else PLACE)


def test_after_the_travel_of_120_m_the_block_hangs_30_m_high_less_the_rope_stretch(
    reading: Reading, stages: dict[str, Stage]
) -> None:
    k = stages["settle"].samples[-1]
    assert reading.pose["west.main"][k, 0] == pytest.approx(160.0, abs=PLACE)
    assert reading.pose["east.main"][k, 0] == pytest.approx(196.0, abs=PLACE)
    for stage in ("settle", "settle on A", "settle 2"):
        assert STRETCH[0] < 30.0 - reading.pose["block"][stages[stage].samples[-1], 2] < STRETCH[1]


@pytest.mark.parametrize(("stage", "half"), [("turn to 90 degrees", 1), ("turn to 180 degrees", -1)])
def test_ropes_and_trolleys_follow_the_ordered_angle_of_the_block_during_the_turn_over(
    reading: Reading, stages: dict[str, Stage], stage: str, half: int
) -> None:
    k, theta = stages[stage].samples, commanded(reading)
    for message, law in ((_ropes(reading, "H1", "H2"), 0), (_ropes(reading, "H3"), 1)):
        assert message[k] == pytest.approx(np.tile(lengths(theta[k], half)[law][:, None], message.shape[1]), abs=LENGTH)
    for trolley, law in (("upper", 0), ("lower", 1)):
        y = np.tile(arms(theta[k], half)[law][:, None], 2)
        assert _trolleys(reading, trolley)[k] - 75.0 == pytest.approx(y, abs=PLACE)


@pytest.mark.parametrize(
    ("theta", "half", "L_A", "L_B", "y_A", "y_B", "H1", "H3"),
    [
        (0.0, 1, 61.0, 19.4, -14.6, 12.0, 101.6, 246.9),
        (30.0, 1, 53.7, 26.1, -12.64, 13.19, 115.0, 220.1),
        (60.0, 1, 48.4, 32.6, -7.30, 10.85, 134.7, 180.6),
        (85.0, 1, 46.5, 36.5, -1.27, 6.62, 187.6, 74.7),
        (120.0, -1, 48.4, 32.6, 7.30, -10.85, 134.7, 180.6),
        (180.0, -1, 61.0, 19.4, 14.6, -12.0, 101.6, 246.9),
    ],
)
def test_every_row_of_the_published_quasi_static_table_is_reproduced(
    reading: Reading,
    mechanics: Mechanics,
    stages: dict[str, Stage],
    theta: float,
    half: int,
    L_A: float,
    L_B: float,
    y_A: float,
    y_B: float,
    H1: float,
    H3: float,
) -> None:
    k = np.concatenate([stages[s].samples for s in _turning(half)])
    to = commanded(reading)[k]
    i = k[np.argmin(np.abs(to - theta))]  # nearest sample, less than 0.1 degrees away
    assert _ropes(reading, "H1", "H2")[i] == pytest.approx(L_A, abs=2 * ROUNDED)
    assert _ropes(reading, "H3")[i] == pytest.approx(L_B, abs=2 * ROUNDED)
    assert _trolleys(reading, "upper")[i] - 75.0 == pytest.approx(y_A, abs=2 * ROUNDED)
    assert _trolleys(reading, "lower")[i] - 75.0 == pytest.approx(y_B, abs=2 * ROUNDED)
    j = k[np.argmin(np.abs(measured(mechanics)[k] - theta))]
    assert carried(mechanics, A)[j] == pytest.approx(H1, abs=SHARE * LOAD)
    assert carried(mechanics, B)[j] == pytest.approx(H3, abs=SHARE * LOAD)


@pytest.mark.parametrize("half", [1, -1])
def test_computed_load_shares_agree_with_the_measured_table_at_every_angle(
    mechanics: Mechanics, stages: dict[str, Stage], half: int
) -> None:
    for stage in _turning(half):
        k = stages[stage].samples
        a, b = loads(measured(mechanics)[k], half)
        assert np.abs(carried(mechanics, A)[k].sum(axis=1) - 4 * a).max() < SHARE * LOAD, stage
        assert np.abs(carried(mechanics, B)[k].sum(axis=1) - 2 * b).max() < SHARE * LOAD, stage


def test_each_lifting_beam_of_crane_a_carries_a_quarter_when_the_block_hangs_from_crane_a_alone(
    mechanics: Mechanics, stages: dict[str, Stage]
) -> None:
    k = stages["settle on A"].last(10.0)
    assert carried(mechanics, A)[k] == pytest.approx(225.0, abs=SHARE * LOAD)
    assert np.all(carried(mechanics, B)[k] == 0.0)


def test_crane_b_goes_slack_when_the_block_stands_on_edge(
    reading: Reading, mechanics: Mechanics, stages: dict[str, Stage]
) -> None:
    theta = measured(mechanics)
    t = reading.t
    slack = [
        e["t_ns"] * 1e-9
        for name in B
        for e in reading.said(name, "report", "RopeState")
        if e["value"]["state"] == "slack" and stages["slacken B"].start < e["t_ns"] * 1e-9 < stages["unhook B"].start
    ]
    assert len(slack) >= 4
    assert np.interp(slack, t, theta) == pytest.approx(90.0, abs=0.5)


@pytest.mark.parametrize("stage", STILL)
def test_hook_ropes_hang_plumb_at_rest(mechanics: Mechanics, stages: dict[str, Stage], stage: str) -> None:
    k = stages[stage].last(20.0)
    for name in mechanics.hook_ropes:
        for u in mechanics.pulls[name].directions:
            assert np.degrees(np.arcsin(np.hypot(u[k, 0], u[k, 1]))).max() < OFF_LEAD, name


def test_winches_hoist_at_most_2300_mm_per_minute_during_turns(reading: Reading, stages: dict[str, Stage]) -> None:
    for stage in ("turn to 90 degrees", "turn to 180 degrees"):
        rates = reading.values["/rope/length_rate"][stages[stage].samples] * 60.0
        assert np.abs(rates).max() == pytest.approx(2.3, abs=ROUNDED)


def _turning(half: int) -> tuple[str, ...]:
    return ("settle", "turn to 90 degrees") if half > 0 else ("settle on A and C", "turn to 180 degrees", "settle 2")


def _ropes(reading: Reading, *hooks: str) -> Array:
    """(n, ...) unstretched lengths of these hook ropes of both cranes [m]."""
    names = [f"{crane}.{hook}" for crane in ("west", "east") for hook in hooks]
    return np.stack([reading.column("/rope/length", name) for name in names], axis=1)


def _trolleys(reading: Reading, which: str) -> Array:
    """(n, 2) y of this trolley of both cranes [m]."""
    return np.stack([reading.pose[f"{crane}.{which}"][:, 1] for crane in ("west", "east")], axis=1)
