"""The example models behave as their first lines state."""

from devs_stories import kinds
from heavylift.nodes import drive
from heavylift.nodes.devs import Message, Simulator, Tag, seconds
from heavylift.nodes.zoo import Colour, Light, LightMode, RingStation, Show, Take, ring


def shown(inputs: list[tuple[int | Tag, str, Message]], until: float) -> list[tuple[float, str]]:
    return [
        (tag.t / 1e9, say.colour)
        for tag, _, say in drive(Light("light"), inputs, seconds(until))
        if isinstance(say, Show)
    ]


def test_a_traffic_light_model_changes_its_colours_at_the_stated_times() -> None:
    assert shown([], 130) == [
        (0.0, Colour.RED),
        (60.0, Colour.GREEN),
        (110.0, Colour.YELLOW),
        (120.0, Colour.RED),
    ]


def test_an_operator_switches_the_traffic_light_to_blinking_and_back() -> None:
    text = shown([(seconds(70), "take", Take(LightMode.MANUAL)), (seconds(71.2), "take", Take(LightMode.AUTO))], 132)
    assert text == [
        (0.0, Colour.RED),
        (60.0, Colour.GREEN),
        (70.0, Colour.YELLOW),
        (70.5, Colour.DARK),
        (71.0, Colour.YELLOW),
        (71.2, Colour.RED),
        (131.2, Colour.GREEN),
    ]


def test_the_models_of_a_ring_pass_one_token_around() -> None:
    model = ring(stations=4, tokens=1, hold=seconds(1))
    simulator = Simulator(model)
    simulator.start()
    simulator.run(seconds(10))
    assert [station.passed for station in simulator.atomics if isinstance(station, RingStation)] == [3, 2, 2, 2]


def test_a_ring_of_models_with_as_many_tokens_as_models_makes_only_confluent_transitions() -> None:
    assert kinds(ring(stations=3, tokens=3, hold=seconds(1)), 5) == dict.fromkeys(
        ["ring.s0", "ring.s1", "ring.s2"], "cccc"
    )
