"""`ramp one swing` and `ramp 0.1 m/s2 in two pulses` follow the swing period and leave no residual swing."""

from __future__ import annotations

from itertools import pairwise
from math import pi, sqrt

import numpy as np
import pytest
from heavylift.coordinator.record import play
from heavylift.kernel import SceneError
from heavylift.nodes.models.parts import Done
from heavylift.nodes.plan import Move, profile, ramp, residual, way
from heavylift.nodes.scene import LoadedScene, check, load, parse, spoken
from heavylift.nodes.scene.inputs import inputs

G = 9.80665
PENDULUM = """
heavylift: 1
name: crab
accuracy: 1e-4 %
samples: 20 Hz
mechanism:
  bodies:
    trolley: {{mass: 4 t}}
    load: {{mass: 10 t, com: [0, 0, -{length} m]}}
  joints:
    rail: {{type: prismatic, child: trolley, axis: [1, 0, 0]}}
    pivot: {{type: revolute, parent: trolley, child: load, axis: [0, 1, 0]}}
  drives:
    crab: {{joint: rail, type: prescribed, ramp: {ramp}}}
actions:
  - crab: drive 12 m/min {way}
  - wait: 30 s
"""
LIFT = "actions[3].trolleys=traverse 20 m/min ramp {} by 8 m"


def crab(ramp: str, length: float = 24.0, way: str = "by 7 m") -> LoadedScene:
    """A trolley with a point mass on a link."""
    return parse(PENDULUM.format(length=length, ramp=ramp, way=way))


def move_of(scene: LoadedScene) -> Move:
    """Its first move without swing."""
    orders = (order for action in scene.plan.actions for order in action.orders)
    return next(order for order in orders if isinstance(order, Move) and order.pulses)


def swing(scene: LoadedScene) -> tuple[float, float]:
    """Amplitude of the pendulum once the trolley stands [rad], and where it stands [m]."""
    run = play(scene.plan)
    done = next(e for e in run.events if isinstance(e.value, Done))
    poses = run.past.part(0, len(run.t)).poses
    x = (poses["load"][:, 3:] ** 2)[run.t > done.t / 1e9 + 0.1]  # quaternion x y z w: y is the sine of half the angle
    return 2.0 * sqrt(x[:, 1].max()), done.value.position


@pytest.mark.parametrize("length", [6.0, 24.0])
@pytest.mark.parametrize("ramp", ["one swing", "0.3 m/s2 in two pulses", "0.03 m/s2 in two pulses"])
def test_a_swing_free_ramp_leaves_a_pendulum_of_constant_length_at_rest(length: float, ramp: str) -> None:
    """Against the closed form: a plain ramp of acceleration a leaves up to 2 a / g, these a thousandth of that."""
    scene = crab(ramp, length)
    assert move_of(scene).periods == pytest.approx(2 * [2 * pi * sqrt(length / G)], rel=5e-5)
    left, stands = swing(scene)
    plain, _ = swing(crab("0.3 m/s2", length))
    assert left < 1e-3 * plain
    assert stands == pytest.approx(7.0, abs=1e-12)


def test_a_swing_free_ramp_that_is_halted_or_short_leaves_a_pendulum_at_rest() -> None:
    plain, _ = swing(crab("0.3 m/s2"))
    left, stands = swing(crab("one swing", way="until after 25 s"))
    assert left < 1e-3 * plain
    assert stands == pytest.approx(0.2 * 25.0, abs=1e-9)  # a ramp to start, and one as long behind the 25 s
    left, stands = swing(crab("one swing", way="by 1 m"))
    assert left < 1e-3 * plain
    assert stands == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("ramp", ["one swing", "0.3 m/s2 in two pulses"])
def test_swing_free_ramps_leave_less_than_two_percent_of_the_swing_of_a_step_in_speed(ramp: str) -> None:
    """Of what it would leave to begin and to stop at once, v / w each; some of it is there since the block was lifted.
    Three hooks with loaders hang below trolleys on servos."""
    scene = load("lift", [LIFT.format(ramp), "end=115 s"])
    run = play(scene.plan)
    y = run.past.part(0, len(run.t)).poses["block"][:, 1]
    assert np.ptp(y[run.t > 95.0]) < 0.02 * 4.0 * 20 / 60 * move_of(scene).periods[0] / (2 * pi)


def test_the_command_check_reports_the_chosen_swing_free_ramps() -> None:
    message = str(check(load("lift", [LIFT.format("one swing")])))
    trolleys = "the upper trolley of crane, the lower trolley of crane"
    assert f"  sideways: {trolleys}: 0.01847 m/s2, 18.05 s (a swing of 18.05 s), to start and to stop" in message
    message = str(check(load("trolley", ["mechanism.drives.drive.ramp=0.2 m/s2 in two pulses"])))
    assert "  back, quickly: drive: 0.2 m/s2 in two pulses, 7.41 s (a swing of 9.83 s), to start and to stop" in message


def test_a_move_too_short_for_a_swing_free_ramp_is_made_slower() -> None:
    message = str(check(load("lift", ["cranes.crane.ramp=one swing"])))
    assert "0.006142 m/s2, 18.05 s (a swing of 18.05 s), to start and to stop" in message  # 2 m / (18.05 s)^2


def test_swing_free_ramps_can_be_set_for_a_crane_or_for_a_single_order() -> None:
    scene = load("lift", ["cranes.crane.ramp=one swing"])
    up, sideways = scene.plan.actions[2].orders[0], scene.plan.actions[3].orders[0]
    assert isinstance(up, Move)
    assert isinstance(sideways, Move)
    assert (up.pulses, up.accel) == (0, 0.05)  # winches keep what a crane has by itself
    assert (sideways.pulses, sideways.accel) == (1, pytest.approx(20 / 60 / sideways.periods[0]))
    scene = load("lift", ["cranes.crane.ramp=one swing", LIFT.format("0.1 m/s2")])
    assert all(not m.pulses for action in scene.plan.actions for m in action.orders if isinstance(m, Move))


def test_each_swing_free_ramp_fits_the_rope_length_at_the_beginning_of_its_move() -> None:
    """Hoisting while it traverses: the ropes are shorter as it stops, and what that leaves is said."""
    scene = load(
        "lift",
        [
            "end=120 s",
            "actions[2].all hooks=hoist 3 m/min by 3 m",
            "actions[3].when=after 30 s",
            LIFT.format("one swing"),
        ],
    )
    move = move_of(scene)
    first, last = move.periods
    hoisted = G * (first**2 - last**2) / (4 * pi * pi)
    begins, stops = 30.0, 30.0 + 8.0 / (20 / 60)
    assert hoisted == pytest.approx(0.05 * (stops - begins), rel=0.1)
    assert 0.0 < move.left < 0.05 * move.accel / G
    assert "as lengths change, about" in str(check(scene))


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        (["actions[2].all hooks=hoist 3 m/min ramp one swing by 1 m"], "hoist causes no swing"),
        (["actions[3].trolleys=traverse 20 m/min ramp one swin by 1 m"], "after 'ramp one' 'swing' must follow"),
        (["actions[3].trolleys=traverse 20 m/min ramp 1 m/s2 in one pulse by 1 m"], "after 'in' 'two' must follow"),
        (["cranes.crane.ramp=-1 m/s2 in two pulses"], "must be greater than zero"),
        (["cranes.crane.ramp=one"], "'swing' must follow"),
    ],
)
def test_impossible_swing_free_ramps_are_reported(settings: list[str], sentence: str) -> None:
    with pytest.raises(SceneError, match=sentence):
        load("lift", settings)


def test_swing_free_ramps_of_a_load_without_swing_period_are_reported() -> None:
    text = PENDULUM.format(length=24, ramp="one swing", way="by 7 m")
    with pytest.raises(SceneError, match="crab: nothing swings that it moves: write an acceleration after 'ramp'"):
        parse(text.replace("type: revolute", "type: fixed").replace(", axis: [0, 1, 0]}\n  dr", "}\n  dr"))
    late = text.replace("  - crab:", "  - wait: 1 s\n  - when: position of rail >= 5 m\n    crab:")
    with pytest.raises(SceneError, match="no length is known for this ramp, write an acceleration: still waiting for"):
        parse(late)
    turn = "actions[5].block=turn 0.15 deg/s ramp one swing to 90 deg"
    with pytest.raises(SceneError, match="hooks move on arcs in a turn"):
        load("turnover", [turn])


def test_a_move_with_a_swing_free_ramp_can_neither_be_varied_nor_ordered_by_an_operator() -> None:
    with pytest.raises(SceneError, match=r"input cranes.crane.ramp: this is not a quantity"):
        inputs(load("lift", ["cranes.crane.ramp=one swing"]), ["cranes.crane.ramp"])
    with pytest.raises(
        SceneError, match="ramps without swing are possible only in the action list: give an acceleration"
    ):
        spoken(load("lift"), "trolleys: traverse 20 m/min ramp one swing by 1 m")


@pytest.mark.parametrize("pulses", [1, 2])
@pytest.mark.parametrize("accel", [0.02, 0.07, 0.4])
def test_the_residual_swing_of_a_speed_profile_is_that_of_a_linear_oscillator(pulses: int, accel: float) -> None:
    speed, chosen, period = 0.5, 12.0, 11.0
    rows = ramp(pulses, speed, accel, chosen)
    slopes = [(w - v) / (t - s) for (s, v), (t, w) in pairwise(rows)]
    steps = [(t, b - a) for (t, _), a, b in zip(rows, [0.0, *slopes], [*slopes, 0.0], strict=True)]
    swings = sum(a * np.exp(2j * pi / period * t) for t, a in steps)  # each step of the acceleration starts one
    left = residual(pulses, speed, accel, chosen, period, G)
    assert left == pytest.approx(abs(swings) / G, rel=1e-9)
    assert residual(pulses, speed, accel, chosen, chosen, G) < 1e-12


@pytest.mark.parametrize("distance", [-1e-6, 0.3, 4.0, 120.0, -33.3])
@pytest.mark.parametrize("pulses", [1, 2])
def test_swing_free_speed_profiles_end_exactly_at_the_target_position(pulses: int, distance: float) -> None:
    rows = profile(pulses, distance, 0.5, 0.1, (15.0, 13.0), 7)
    assert way(rows) == pytest.approx(distance, rel=1e-15)
    assert rows[0] == (7, 0.0)
    assert rows[-1][1] == 0.0
    assert max(abs(v) for _, v in rows) <= 0.5 * (1 + 1e-8)
    assert all(a < b for (a, _), (b, _) in pairwise(rows))
