"""`heavylift statics` and `heavylift modes`: at the start, at a time, after a stage; as text and as JSON."""

import json
import sys

import numpy as np
import pytest
from heavylift.coordinator.cli import main
from heavylift.coordinator.participants import paused
from heavylift.kernel.analysis import equilibrium
from heavylift.nodes.scene import load

G = 9.80665
LIFTED = 300e3 + 3 * 45e3  # [kg] block, and three loaders with their hook blocks
PERIOD_s = 15.541579551746315  # C01, linear
UPRIGHT = """\
heavylift: 1
name: upright
mechanism:
  bodies:
    bob: {mass: 3 kg, com: [0, 0, 2 m]}
  joints:
    pivot: {type: revolute, child: bob, axis: [0, 1, 0]}
actions:
  - wait 1 s
"""


def said(capsys, monkeypatch, *words: str) -> str:
    monkeypatch.setattr(sys, "argv", ["heavylift", *words])
    main()
    return capsys.readouterr().out


def test_the_modes_of_a_pendulum_give_its_period(capsys, monkeypatch):
    text = said(capsys, monkeypatch, "modes", "pendulum")
    assert "0.0643 Hz  15.542 s  0.000 %  load 100 %; by pivot.rate" in text
    (mode,) = json.loads(said(capsys, monkeypatch, "modes", "pendulum", "--json"))["modes"]
    assert 1.0 / mode["frequency"] == pytest.approx(PERIOD_s, rel=1e-8)
    assert mode["bodies"] == {"load": 1.0}


def test_statics_of_a_lift_are_computed_at_its_start_and_when_it_hangs(capsys, monkeypatch):
    text = said(capsys, monkeypatch, "statics", "lift")
    assert "at rest after 0 steps" in text
    assert "unstable" not in text
    assert "loader-1.sling-1       slack" in text
    found = json.loads(said(capsys, monkeypatch, "statics", "lift", "--after", "up", "--json"))
    ropes = sum(T for name, T in found["tensions"].items() if name.startswith("crane."))
    assert ropes == pytest.approx(LIFTED * G, rel=1e-5)  # they hang almost plumb
    assert set(found["supports"].values()) == {0.0}
    gantry = found["reactions"]["crane.gantry"]["force"]
    assert gantry == pytest.approx([0.0, 0.0, gantry[2]], abs=1e-6 * gantry[2])


def test_statics_of_an_upright_body_are_reported_as_unstable(capsys, monkeypatch, tmp_path):
    file = tmp_path / "upright.yaml"
    file.write_text(UPRIGHT)
    text = said(capsys, monkeypatch, "statics", str(file))
    assert text.startswith("at rest after 0 steps\nunstable: a small push grows e-fold in 0.452 s\n")  # sqrt(L/g)


def test_statics_can_start_from_the_pose_of_a_run_at_a_given_time(capsys, monkeypatch):
    before = len(json.loads(said(capsys, monkeypatch, "modes", "lift", "--json"))["modes"])
    during = json.loads(said(capsys, monkeypatch, "modes", "lift", "--at", "40", "--json"))["modes"]
    assert before == 27
    assert during[0]["bodies"]["block"] > 0.5  # now it is the block that swings


def test_a_simulation_paused_at_a_time_has_the_state_that_the_whole_run_has_then():
    simulation = paused(load("lift", []), at=40.0)
    assert simulation.epoch == 40_000_000_000
    moving = simulation.state.copy()
    assert np.abs(moving[simulation.program.nq :][: simulation.program.nv]).max() > 0.0
    equilibrium(simulation)
    assert simulation.row().v == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--after", "nonsense"], "heavylift: --after 'nonsense': there is no such stage; stages are take up slack, "),
        (["--at", "-1"], "heavylift: --at -1 s: the time must lie between 0 and 360000 s"),
    ],
)
def test_invalid_arguments_of_statics_and_modes_are_reported_in_one_sentence(capsys, monkeypatch, words, sentence):
    monkeypatch.setattr(sys, "argv", ["heavylift", "statics", "lift", *words])
    with pytest.raises(SystemExit, match="1"):
        main()
    error = capsys.readouterr().err
    assert error.startswith(sentence)
    assert error.count("\n") == 1


FALLS = """\
heavylift: 1
name: falls
actions:
  - wait 1 s
mechanism:
  bodies:
    stone: {mass: 1 t}
  joints:
    shaft: {type: prismatic, child: stone, axis: [0, 0, 1]}
"""


def test_a_freely_falling_body_has_no_static_equilibrium(tmp_path, capsys, monkeypatch):
    (tmp_path / "falls.yaml").write_text(FALLS)
    monkeypatch.setattr(sys, "argv", ["heavylift", "modes", str(tmp_path / "falls.yaml")])
    with pytest.raises(SystemExit, match="1"):
        main()
    assert "heavylift: body 'stone' finds no rest: joint 'shaft' still accelerates by 9.81" in capsys.readouterr().err
