"""Which input moves a peak most: closed forms of a load that falls into its rope; inputs that make events switch."""

from __future__ import annotations

import json
from math import hypot, sqrt

import pytest
from heavylift.coordinator.cli import main
from heavylift.coordinator.uncertainty.sensitivities import sensitivities
from heavylift.kernel import ModelError
from heavylift.nodes.scene import load

LOAD, FALL = "mechanism.bodies.load.mass", "mechanism.ropes.fall"
UNDAMPED = ["end=2 s", f"{FALL}.damping=0 kN s/m", "tolerance=1e-9"]
G, L, H = 9.80665, 30.0, 0.5


def peak(mass: float, EA: float) -> float:
    """Of the tension of a load that falls H into its rope without damping [N]."""
    weight = mass * G
    return weight + sqrt(weight * (weight + 2.0 * H * EA / L))


def test_sensitivities_of_a_snatched_load_agree_with_closed_forms() -> None:
    scene = load("snatch", [*UNDAMPED, f"{LOAD}=10 t +- 6 %", f"{FALL}.EA=90..98 MN"])
    found = sensitivities(scene, at_once=0)
    (figure,) = [f for f in found.figures if f.quantity == "rope tension"]
    assert figure.value == pytest.approx(peak(10e3, 94e6), rel=1e-8)
    mass, EA = found.effects[figure.name]
    sd = 4e6 / sqrt(3.0)
    assert (mass.input, EA.input) == (LOAD, f"{FALL}.EA")
    assert mass.moves == pytest.approx(peak(10.3e3, 94e6) - peak(9.7e3, 94e6), rel=1e-6)
    assert EA.moves == pytest.approx(peak(10e3, 94e6 + sd) - peak(10e3, 94e6 - sd), rel=1e-6)
    assert found.bar(figure.name) == pytest.approx(hypot(mass.moves, EA.moves))
    assert not mass.switches
    assert f"{FALL}.length" in found.unstated
    assert LOAD not in found.unstated


def test_an_input_that_makes_a_second_rope_taut_is_run_at_both_ends_of_its_range() -> None:
    second = "mechanism.ropes.second={start: {body: world}, end: {body: load}, length: 30.2 m +- 0.1 m, EA: 94 MN}"
    found = sensitivities(load("snatch", [*UNDAMPED, second]), at_once=0)
    effects = {f.name: found.effects[f.name][0] for f in found.figures if f.quantity == "rope tension"}
    assert effects["peak tension second"].switches
    assert effects["peak tension second"].moves > 0.3 * peak(10e3, 94e6)  # 30.1 m: carries as the first one does


def test_an_input_value_that_cannot_be_simulated_is_reported_and_ignored() -> None:
    scene = load("snatch", [*UNDAMPED, f"{FALL}.winch.longest=30.2 m sd 0.3 m", f"{LOAD}=10 t +- 6 %"])
    found = sensitivities(scene, at_once=0)
    assert list(found.failed) == [f"{FALL}.winch.longest"]
    assert "the run with 29.90 m fails" in found.failed[f"{FALL}.winch.longest"]
    assert all(len(effects) == 1 for effects in found.effects.values())
    assert any("missing in all bars" in note for note in found.notes)


def test_a_requested_accuracy_finer_than_the_input_uncertainty_is_reported() -> None:
    asked = ["ask=[rope tension]", "accuracy=0.3 %", f"{LOAD}=10 t +- 6 %"]
    (note,) = sensitivities(load("snatch", [*UNDAMPED, *asked]), at_once=0).notes
    assert note.startswith("rope tension is asked to 0.3 %, finer than the inputs carry: ")
    assert not sensitivities(load("snatch", [*UNDAMPED, *asked, "accuracy=10 %"]), at_once=0).notes


def test_for_a_scene_without_uncertain_inputs_the_message_says_how_to_state_them() -> None:
    with pytest.raises(ModelError, match="states no uncertainties; add one after a value"):
        sensitivities(load("snatch"), at_once=0)


def test_the_additional_runs_for_sensitivities_use_several_processes(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    sets = [x for s in UNDAMPED for x in ("--set", s)]
    words = ["heavylift", "sensitivities", "snatch", *sets, "--json", "--input", f"{LOAD} +- 6 %"]
    monkeypatch.setattr("sys.argv", words)
    monkeypatch.setattr("heavylift.coordinator.uncertainty.sensitivities.cores", lambda: 1)
    main()
    message = capsys.readouterr()
    assert "2 runs of about " in message.err
    (effect,) = json.loads(message.out)["figures"][0]["effects"]
    assert effect["share"] == 1.0
