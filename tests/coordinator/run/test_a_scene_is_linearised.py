"""`heavylift.linearise` over scenes and systems, and `heavylift.sensitivities`."""

import control
import heavylift
import numpy as np
import pytest
from heavylift.kernel import HeavyliftError
from heavylift.kernel.analysis import LinearModel
from heavylift.kernel.description import Body, Drive, Joint, System

G = 9.80665
CRANE = System(
    (Body("trolley", 3.0), Body("load", 2.0, (0.0, 0.0, -5.0))),
    (
        Joint("rail", "prismatic", "world", "trolley", axis=(1.0, 0.0, 0.0)),
        Joint("hook", "revolute", "trolley", "load", axis=(0.0, 1.0, 0.0), q0=(0.3,)),
    ),
    drives=(Drive("travel", "rail", "prescribed"),),
)


def frequencies(model: LinearModel) -> np.ndarray:
    """Of its oscillations [rad/s]."""
    return np.sort([abs(s) for s in np.linalg.eigvals(model.A) if s.imag > 1e-6])


@pytest.mark.parametrize(
    ("scene", "want"),
    [("pendulum", {(G / 60.0) ** 0.5}), ("trolley", {(G / 24.0) ** 0.5}), (CRANE, {(G / 5.0) ** 0.5})],
)
def test_a_linearised_pendulum_has_the_frequency_of_its_closed_form(scene, want):
    found = frequencies(heavylift.linearise(scene, [], ["joint/position/*"]))
    assert all(np.abs(found - w).min() < 1e-9 * w for w in want)


def test_linearising_a_bundled_crane_gives_the_pendulum_mode_of_its_load():
    """Its trolley as the input: at low frequencies the load follows with the swing of its hoist rope."""
    model = heavylift.linearise("hall", ["hall.traversing"], ["pose/block/y"], at="up")
    assert [x.unit for x in model.inputs] == ["m/s2"]
    follows = control.ss(*model)
    s = 0.02j
    assert complex(follows(s) * s**2) == pytest.approx(1.0, abs=2e-2)


def test_a_scene_can_be_linearised_at_rest_and_during_motion():
    at_start = heavylift.linearise(CRANE, [], ["joint/position/hook.angle"], at=0.0)
    assert frequencies(at_start) == pytest.approx([(G / 5.0 * np.cos(0.3)) ** 0.5], rel=1e-12)
    assert at_start.outputs[0].value == 0.3
    moved = heavylift.linearise(CRANE, [], ["joint/position/hook.angle"], at=0.4)
    assert frequencies(moved) == pytest.approx([(G / 5.0 * np.cos(moved.outputs[0].value)) ** 0.5], rel=1e-12)
    assert 0.0 < moved.outputs[0].value < 0.3


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((CRANE, ["travel"], ["joint/position/*"], "up"), "a system has no stages; give a time"),
        ((CRANE, [1], ["joint/position/*"]), "give names of drives, winches or signals"),
        ((CRANE, ["hoist"], ["joint/position/*"]), "there is no input 'hoist'; known: travel"),
        (("trolley", ["drive"], ["joint/position/*"], "sideways"), "there is no such stage; stages are out, smoothly"),
        (("trolley", ["drive"], ["joint/position/*"], -1.0), "at: "),
    ],
)
def test_invalid_arguments_of_linearise_are_reported_in_one_sentence(arguments, sentence):
    with pytest.raises(HeavyliftError) as error:
        heavylift.linearise(*arguments)
    assert sentence in str(error.value)
    assert "\n" not in str(error.value)


def test_sensitivities_can_be_computed_from_python():
    found = heavylift.sensitivities("snatch", ["mechanism.bodies.load.mass +- 1 %"], at_once=0)
    (effect,) = found.effects[found.figures[0].name]
    assert effect.input == "mechanism.bodies.load.mass"
    assert abs(effect.moves) > 0.0
