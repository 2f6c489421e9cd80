"""Set-points: the commander leads the actuator of a model to each speed, and refuses that actuator to all others."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.coordinator.live import TimedCommand
from heavylift.coordinator.record import Played, play
from heavylift.coordinator.run import run
from heavylift.kernel import ModelError, SceneError
from heavylift.nodes import drive
from heavylift.nodes.devs import Simulator, Tag, encode, ms, seconds
from heavylift.nodes.models import build_one
from heavylift.nodes.models.parts import Limit, OperatorAnswer, OperatorCommand, Order, Sample, SetPoint, SetProfile
from heavylift.nodes.plan import Action, Move
from msgspec import msgpack
from scenes import HAND, SLEDGE, scene


def said(found: Played, kind: type) -> list[tuple[float, object]]:
    return [(event.t / 1e9, event.value) for event in found.events if isinstance(event.value, kind)]


def test_each_speed_set_by_a_user_model_becomes_one_order_with_one_motion_profile(folder: Path) -> None:
    found = play(scene(folder, SLEDGE, HAND).plan)
    assert [(t, x.value) for t, x in said(found, SetPoint)] == [(1.0, 0.3), (2.0, -0.1), (3.0, 0.0)]  # type: ignore[attr-defined]
    led = [(t, x.what) for t, x in said(found, Order) if x.led]  # type: ignore[attr-defined]
    assert [(t, x.speed, x.accel) for t, x in led] == [(1.0, 0.3, 0.5), (2.0, -0.1, 0.5), (3.0, 0.0, 0.5)]  # type: ignore[attr-defined]
    profiles = [x for _, x in said(found, SetProfile)]
    # up to the end positions at +-1 m, 0.3 m/s from 1.6 s on; back from 0.3 m/s, 0.09 m ahead of where it turns
    assert profiles[0] == SetProfile("pusher", seconds(1), 0.3, 0.5, 1.0)
    assert profiles[1].speed == -0.1  # type: ignore[attr-defined]
    assert profiles[1].distance == pytest.approx(-1.0 - (0.3 * 0.3 / (2 * 0.5) + 0.3 * 0.4))  # type: ignore[attr-defined]
    assert profiles[2] == SetProfile("pusher", seconds(3), 0.0, 0.5)


def test_the_delay_of_set_points_from_a_user_model_is_the_lookahead_of_its_port(folder: Path) -> None:
    late = scene(folder, SLEDGE, HAND, sets=("models.hand.delay=250 ms",))
    model = build_one(late.plan, "hand")
    assert {
        port.name: drive(model, until=seconds(5))[0][0] for port in model.ports.values() if port.name == "speed"
    } == {"speed": Tag(ms(1250))}
    simulator = Simulator(build_one(late.plan, "hand"))
    simulator.start()
    assert simulator.lookahead == {"hand.speed": ms(250)}
    assert [t for t, x in said(play(late.plan), Order) if x.led] == [1.25, 2.25, 3.25]


def test_a_drive_controlled_by_a_user_model_stops_at_its_end_position(folder: Path) -> None:
    fast = scene(
        folder, SLEDGE, HAND, sets=("models.hand.parameters={one: 1 m/s, two: 1 m/s, three: 1 m/s}", "end=6 s")
    )
    found = play(fast.plan)
    ((t, limit),) = said(found, Limit)
    assert limit == Limit("pusher", "travel limit", 1.0)
    assert t == pytest.approx(1.0 + 2 * (1.0 / 0.5) ** 0.5, abs=1e-9), "the quickest way over 1 m from rest to rest"
    names = next(c for c in found.layout.channels if c.topic == "joint/position")
    assert found.rows[-1, names.start + list(names.names).index("rail.travel")] == pytest.approx(1.0, abs=1e-3)


def test_an_operator_may_not_move_a_drive_that_is_controlled_by_a_user_model(folder: Path) -> None:
    plan = scene(folder, SLEDGE, HAND).plan
    push = Move(verb="drive", model="sledge", actuator="pusher", speed=0.1, accel=0.5, by=0.1)
    words = OperatorCommand("pusher: drive 6 m/min by 0.1 m", msgpack.encode(Action(orders=(push,))))
    found = play(plan, commands=[TimedCommand(Tag(seconds(4)), encode(words))])
    ((_, answer),) = said(found, OperatorAnswer)
    assert answer.refused == "pusher is controlled by the model hand and takes no other orders; leave this order out"  # type: ignore[attr-defined]


ACTION = "actions:\n  - pusher: drive 6 m/min by 0.1 m\n"
TWICE = HAND + HAND.partition("\n")[2].replace("hand:", "other:")
WRONG = [
    (HAND + ACTION, (), "pusher is controlled by the model 'hand' and takes no other orders"),
    (TWICE, (), "pusher is controlled by the model 'hand' already; only one model can control it"),
    (HAND, ("models.hand.signals.heard=postion of rail",), "there is no signal 'postion'"),
    (HAND, ("models.hand.signals.heard=position of rial",), "there is no 'rial' with position"),
    (HAND, ("models.hand.signals.heard=swing along of fell",), "there is no 'fell' with swing along"),
    (HAND, ("models.hand.orders={speed: pushed}",), "'pushed' is not a drive or winch that a model can control"),
    (
        HAND,
        ("models.hand.orders={pace: pusher}",),
        "beside.py:Hand has no output port 'pace' for a SetPoint; it has speed",
    ),
    (
        HAND,
        ("models.hand.signals={ears: position of rail}",),
        "beside.py:Hand has no input port 'ears' for a Sample; it has heard",
    ),
    (HAND, ("models.hand.period=0",), "0 is out of range: choose 0.001 ms to 100 days"),
    (HAND, ("models.hand.delay=-1 ms",), "a time must be zero or more here, not -1 ms"),
    (HAND, ("models.hand.delay=11 s",), "the delay exceeds 100 periods; lengthen the period"),
    (HAND, ("models.hand.parameters.one=[1]",), "write a number, a quantity, a word, true or false here"),
    (HAND, ("models.hand.model=beside.py:Foot",), "beside.py has no model Foot; define a class or a function"),
    (HAND, ("models.hand.model=beside.py:number",), "must return a DEVS model with the name that it gets"),
    (HAND, ("models.hand.model=beside.py:broken",), "raised TypeError: broken() got an unexpected keyword argument"),
    (HAND, ("models.hand.model=none.py:Hand",), "none.py: there is no such file"),
    (HAND, ("models.hand.model=../beside.py:Hand",), "is outside of the scene's folder"),
    (HAND.replace("hand:", "kernel:"), (), "the name 'kernel' is reserved"),
    (HAND.replace("hand:", "sledge:"), (), "the name 'sledge' is given twice"),
]


@pytest.mark.parametrize(("models", "sets", "sentence"), WRONG)
def test_an_invalid_user_model_is_reported_with_its_line_in_the_scene(
    folder: Path, models: str, sets: tuple[str, ...], sentence: str
) -> None:
    with pytest.raises(SceneError) as message:
        scene(folder, SLEDGE, models, sets=sets)
    assert sentence in str(message.value)
    assert str(message.value).count("error:") == 1, "one sentence"
    assert ": error: " in str(message.value)


GOES_WRONG = [
    ("beside.py:Clumsy", {}, "model at (1 s, 0): external() raised ZeroDivisionError: there is no way"),
    ("beside.py:Chatterbox", {"one": "0.1", "two": "0.2"}, "set-points come more often than once in a period"),
    ("beside.py:Hand", {"wild": "true"}, "hand: speed sends nan, which is not a speed"),
]


@pytest.mark.parametrize(("model", "parameters", "sentence"), GOES_WRONG)
def test_a_runtime_error_in_a_controller_ends_the_run_with_an_error_that_names_the_controller(
    folder: Path, model: str, parameters: dict[str, str], sentence: str
) -> None:
    text = HAND.replace("{one: 18 m/min, two: -6 m/min, three: 0}", str(parameters).replace("'", ""))
    plan = scene(folder, SLEDGE, text, sets=(f"models.hand.model={model}", "models.hand.delay=50 ms")).plan
    with pytest.raises(ModelError) as message:
        play(plan)
    assert sentence in str(message.value)
    assert "\n" not in str(message.value)


def test_a_bundled_crane_accepts_the_orders_of_a_user_model(folder: Path) -> None:
    text = HAND.replace("position of rail", "position of jib slewer").replace("speed: pusher", "speed: jib slewer")
    jib = "heavylift: 1\nextends: jib\nname: jib\nend: 4 s\nactions: [{wait: 4 s}]\n"
    turned = play(scene(folder, jib, text, sets=("models.hand.parameters={one: 1 deg/s}",)).plan)
    heard = [x.value for _, x in said(turned, Sample)]  # type: ignore[attr-defined]
    assert heard[0] == 0.0
    assert heard[-1] > 0.003, "[rad], under way from 1 s to 2 s"
    with pytest.raises(
        ModelError, match=r"speed requests a speed of 1 from jib\.slewer, whose limit is .* m/s or rad/s"
    ):
        play(scene(folder, jib, text, sets=("models.hand.parameters={one: 1 rad/s}",)).plan)


def test_user_models_share_no_state_and_communicate_only_by_messages(folder: Path, tmp_path: Path) -> None:
    one = "{model: beside.py:Gossip, period: 1 s, signals: {heard: position of rail}}"
    with pytest.raises(ModelError, match=r"one, sledge\.two use the global variable beside\.HEARD, which has changed"):
        run(scene(folder, SLEDGE, f"models: {{one: {one}, two: {one}}}\n"), tmp_path / "x.mcap", in_process=True)


def test_a_crane_controlled_by_a_user_model_keeps_its_speed_limits(folder: Path) -> None:
    text = HAND.replace("position of rail", "position of crane").replace("speed: pusher", "speed: crane")
    lift = "heavylift: 1\nextends: lift\nname: lift\n"
    with pytest.raises(
        ModelError, match=r"speed requests a speed of 5 from crane.gantry.drive, whose limit is 0.5 m/s or rad/s;"
    ):
        play(scene(folder, lift, text, sets=("models.hand.parameters={one: 5 m/s}",)).plan)
    with pytest.raises(ModelError, match=r"crane cannot travel while block stands on its supports and .* is taut"):
        play(scene(folder, lift, text, sets=("models.hand.parameters={three: 0.1 m/s, wait: 4 s}",)).plan)
