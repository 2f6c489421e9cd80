"""`heavylift.Environment`: a scene stepped by a controller in Python, against closed forms."""

import numpy as np
import pytest
from heavylift import Environment, load
from heavylift.kernel import HeavyliftError

TROLLEY = "end=4 s", "actions=[]"  # its drive has a ramp of 0.3 m/s2
SIGNALS = ["joint/position/rail.travel", "joint/velocity/rail.speed"]


def test_a_drive_reaches_the_speeds_set_through_an_environment_along_its_ramp():
    env = Environment(load("trolley", TROLLEY), ["drive"], SIGNALS, period=0.5)
    assert env.names == SIGNALS
    assert list(env.observe()) == [0.0, 0.0]
    for _ in range(4):
        seen = env.step([0.3])
    ramp = 0.3 / 0.3
    assert env.t == 2.0
    assert list(seen) == pytest.approx([0.3 * (2.0 - ramp) + 0.5 * 0.3 * ramp, 0.3], abs=1e-6)
    assert list(seen) == list(env.observe())


def test_an_environment_that_is_reset_repeats_its_results_bit_for_bit():
    env = Environment(load("trolley", TROLLEY), ["drive"], ["*"], period=0.5)
    runs = []
    for _ in range(2):
        seen = [env.reset()]
        while not env.over:
            seen.append(env.step([0.1 * len(seen)]))
        runs.append(np.array(seen))
    assert len(runs[0]) == 9
    assert runs[0].tobytes() == runs[1].tobytes()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((["engine"],), "'engine' is not a drive or winch that a model can control"),
        ((["wind"],), "the scene has no 'wind'"),
        ((["drive"], ["load/*"]), "no signal matches"),
    ],
)
def test_unknown_actions_and_observations_of_an_environment_are_reported(arguments, sentence):
    with pytest.raises(HeavyliftError) as error:
        Environment(load("trolley", TROLLEY), *arguments)
    assert sentence in str(error.value)
