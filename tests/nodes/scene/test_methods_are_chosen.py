"""`method:` and `step:` of a scene are used as written; invalid ones are reported at their place."""

from pathlib import Path

import pytest
from heavylift.coordinator.cli import main
from heavylift.coordinator.run import run
from heavylift.kernel import HeavyliftError, SceneError
from heavylift.nodes.plan import decode, encode
from heavylift.nodes.scene import parse
from heavylift.recordings import Recording

SCENE = """\
heavylift: 1
name: swing
end: 2 s
{}
mechanism:
  bodies:
    bob: {{mass: 1 t, com: [0, 0, -2 m], inertia: [100 kg m2, 100 kg m2, 100 kg m2]}}
  joints:
    pin: {{type: revolute, child: bob, axis: [0, 1, 0], start: 20 deg}}
"""


def test_by_default_the_time_steps_are_as_long_as_the_requested_accuracy_allows():
    plan = parse(SCENE.format("")).plan
    assert (plan.method, plan.step) == ("dopri5", None)


def test_the_chosen_integration_method_is_stated_in_plan_and_recording(tmp_path: Path):
    scene = parse(SCENE.format("method: rk4\nstep: 5 ms"))
    assert (scene.plan.method, scene.plan.step) == ("rk4", 0.005)
    assert decode(encode(scene.plan)) == scene.plan
    result = run(scene, tmp_path / "swing.mcap", in_process=True)
    assert result.energy_error < 1e-6
    facts = Recording(tmp_path / "swing.mcap").run
    assert (facts["method"], facts["step"]) == ("rk4", "0.005 s")


def test_settings_override_the_integration_method_of_the_scene():
    plan = parse(SCENE.format("method: rk4\nstep: 5 ms"), overrides=["method=radau5", "step=20 ms"]).plan
    assert (plan.method, plan.step) == ("radau5", 0.02)


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ("method: euler", r"scene.yaml:4:9.*semi-implicit-euler.*rk4.*dopri5.*radau5"),
        ("method: rk4\nstep: 5", r"scene.yaml:5:7.*unit"),
        ("method: rk4\nstep: -1 s", r"scene.yaml:5:7"),
        (
            "tolerance of: rope tension",
            r"scene.yaml:4:15.*no method has a tolerance of rope tension alone; leave this key out",
        ),
    ],
)
def test_faults_of_integration_settings_are_reported_with_their_line_in_the_scene(keys: str, sentence: str):
    with pytest.raises(SceneError, match=rf"(?s){sentence}"):
        parse(SCENE.format(keys))


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ("method: rk4", "method 'rk4': it has no error estimate and needs a fixed step"),
        ("method: rk4\nstep: 5 s", "too long for method 'rk4', since 'bob' swings at 0.3"),
    ],
)
def test_integration_methods_that_cannot_run_are_refused_before_the_start(keys: str, sentence: str, tmp_path: Path):
    with pytest.raises(HeavyliftError, match=sentence):
        run(parse(SCENE.format(keys)), tmp_path / "swing.mcap", in_process=True)


@pytest.mark.parametrize(
    ("scene", "keys", "sentence"),
    [
        ("lift", ["method=rk4"], "method 'rk4': it has no error estimate and needs a fixed step"),
        ("lift", ["method=rk4", "step=1 s"], "step 1 s at 0.000 s is too long for method 'rk4', since 'block' on"),
        ("lift", ["method=rk4", "ask=[swing]", "accuracy=1 %"], "method 'rk4': it has no error estimate"),
        ("arm", ["method=semi-implicit-euler"], "it has no error estimate and needs a fixed step"),
        ("girder", ["method=rk4", "step=1 s"], "too long for method 'rk4', since 'girder' on 'girder' swings at"),
    ],
)
def test_the_commands_check_and_run_refuse_an_unstable_time_step_with_the_same_sentence(
    scene, keys, sentence, tmp_path, monkeypatch, capsys
):
    text = []
    for command in (["check", scene], ["run", scene, "--in-process", "-o", str(tmp_path / "out.mcap")]):
        monkeypatch.setattr("sys.argv", ["heavylift", *command, *(x for key in keys for x in ("--set", key))])
        with pytest.raises(SystemExit) as left:
            main()
        assert left.value.code == 1
        text.append(capsys.readouterr().err.splitlines()[-1])
    assert text[0] == text[1]
    assert sentence in text[0]


def test_a_fixed_step_within_the_stability_limit_is_accepted(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["heavylift", "check", "arm", "--set", "method=rk4", "--set", "step=5 ms"])
    main()
    assert capsys.readouterr().out.startswith("arm: 4 bodies")


@pytest.mark.parametrize("keys", ["method: ros34pw2", "method: sdirk2\ntolerance of: rope tension\ntolerance: 1e-3"])
def test_a_scene_with_an_integration_method_that_no_longer_exists_runs_with_radau5_and_a_note(tmp_path, keys):
    removed = keys.split("\n")[0].removeprefix("method: ")
    todays = keys.replace(removed, "radau5").replace("tolerance of: rope tension\n", "")
    for name, text in (("removed", keys), ("today", todays)):
        run(parse(SCENE.format(text)), tmp_path / f"{name}.mcap", in_process=True)
    one, other = (Recording(tmp_path / f"{name}.mcap") for name in ("removed", "today"))
    assert all((one[name].values == other[name].values).all() for name in one.signals())
    assert [sentence for _, sentence in one.notes()] == [f"method '{removed}' was removed: 'radau5' takes its place"]
