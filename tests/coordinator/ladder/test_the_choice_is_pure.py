"""What is chosen depends on plan and question alone: with a cold, warm or damaged cache, one digest everywhere."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from heavylift.coordinator.cli import main
from heavylift.coordinator.ladder import Beside, ModelLevel, choosing, chosen, forestalled, known, level_of
from heavylift.coordinator.participants import PRELOAD_SCENE
from heavylift.coordinator.replay import RecordedRun
from heavylift.coordinator.run import run
from heavylift.coordinator.run.simulate import simulate
from heavylift.coordinator.run.verify import verify
from heavylift.coordinator.supervision import Processes
from heavylift.coordinator.sweeps import Task, measured_error, sweep
from heavylift.kernel import cache
from heavylift.kernel.compiler import Library
from heavylift.kernel.simulation.native import native_state
from heavylift.nodes.scene import load, parse
from heavylift.recordings import Recording

ASKED = ["end=40 s", "ask=[rope tension, sling tension]", "accuracy=1 %"]


@pytest.fixture
def kept(monkeypatch: pytest.MonkeyPatch) -> dict[str, bytes]:
    """Answers that are remembered, none of another test."""
    files: dict[str, bytes] = {}
    read, write = cache.read_cached, cache.write_cached

    def mine(name: str) -> bytes:
        return files.get(name, b"") if name.endswith(".answer") else read(name)

    def write_mine(name: str, content: bytes) -> None:
        if name.endswith(".answer"):
            files[name] = content
        else:
            write(name, content)

    for module in (cache, choosing):
        monkeypatch.setattr(module, "read_cached", mine)
    monkeypatch.setattr(cache, "write_cached", write_mine)
    return files


def test_a_scene_gets_the_same_model_level_and_digest_whether_the_cache_is_empty_full_or_damaged(
    kept: dict[str, bytes], tmp_path: Path
) -> None:
    scene = load("lift", ASKED)
    assert known(scene) is None
    digests = [run(scene, tmp_path / "cold.mcap", in_process=True).digest]
    assert len(kept) == 1
    text: list[str] = []
    assert chosen(scene, text.append).answer == known(scene)
    assert not text, "nothing is run again"
    digests.append(run(scene, tmp_path / "processes.mcap").digest)
    kept.update(dict.fromkeys(kept, b"not what it was"))
    digests.append(simulate(scene).digest)
    assert len(set(digests)) == 1
    assert digests[0] != simulate(load("lift", [*ASKED[:1], "ask=[]"])).digest
    answer = chosen(scene).answer
    assert answer is not None
    assert all(0.0 < e <= 0.01 for e in answer.errors.values())
    rec = Recording(tmp_path / "cold.mcap")
    assert json.loads(rec.run["answer"])["told"] == str(answer)
    assert not verify(RecordedRun(tmp_path / "cold.mcap")).others


def test_a_choice_is_the_same_whether_other_processes_run_a_part_of_it_or_fail_to(kept: dict[str, bytes]) -> None:
    scene, text = load("lift", [*ASKED, "accuracy=0.5 %"]), list[str]()

    def answer(start: Callable[[str, str], Callable[[], str]] | None) -> tuple[object, list[str]]:
        kept.clear()
        text.clear()
        found = chosen(scene, text.append, Beside(start))
        return (found.answer, found.plan), [message.partition(":")[0] for message in text]

    alone = answer(None)
    with Processes(PRELOAD_SCENE) as crew:
        outputs = list[str]()

        def spied(module: str, given: str) -> Callable[[], str]:
            wait = crew.aside(module, given)
            return lambda: outputs.append(wait()) or outputs[-1]

        assert answer(spied) == alone
        assert any(outputs), "a run was made beside"
    for output in ("", "Killed", "AAAA", "\xff"):
        assert answer(lambda module, given, output=output: lambda: output) == alone  # type: ignore[misc]


def test_the_first_two_model_levels_of_a_scene_are_compiled_while_it_is_loaded(
    kept: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(tmp_path))
    monkeypatch.setattr(native_state, "_loaded", {})
    compiled: list[bool] = []
    compile_ = Library._compile
    monkeypatch.setattr(Library, "_compile", lambda *given: compiled.append(True) or compile_(*given))
    with Processes(PRELOAD_SCENE) as crew:
        beside = Beside(crew.aside)
        with forestalled(beside):
            scene = load("lift", ASKED)
        own = len(compiled)  # for the path at rest
        answer = chosen(scene, beside=beside).answer
    assert len(compiled) == own > 0, "the runs found their code in the cache"
    kept.clear()
    assert answer == chosen(scene).answer
    with forestalled(Beside(lambda module, given: pytest.fail("a scene that is known begins nothing"))):
        load("lift", ASKED)


@pytest.mark.parametrize(
    "setting", ["accuracy=10 %", "fidelity.girder=elastic", "ask=[sling tension]", "gravity=9.8 m/s2"]
)
def test_the_model_level_is_chosen_again_for_another_accuracy_another_quantity_or_another_scene(
    setting: str, kept: dict[str, bytes]
) -> None:
    chosen(load("lift", ASKED))
    chosen(load("lift", [*ASKED, setting]))
    assert len(kept) == 2


def test_a_model_setting_that_the_scene_fixes_is_kept_and_its_error_is_reported(kept: dict[str, bytes]) -> None:
    scene = chosen(load("lift", [*ASKED, "fidelity.girder=rigid", "method=dopri5", "accuracy=0.3 %"]))
    assert (scene.plan.fidelity.girder, scene.plan.method) == ("rigid", "dopri5")
    assert scene.answer is not None
    assert "not converged: asked to 0.3 %" in scene.answer.notes[0]
    assert max(scene.answer.errors.values()) > 0.003


def test_the_choice_of_a_model_level_does_not_run_user_models() -> None:
    scene = load("damper", ["ask=[position]"])
    assert chosen(scene).answer is not None
    assert "models of its own" in str(chosen(scene).answer)
    assert chosen(scene).plan.fidelity == scene.plan.fidelity


def test_all_variants_of_a_study_use_the_model_level_chosen_for_its_scene(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    scene = load("lift", ASKED)
    base = chosen(scene).plan
    study = sweep(scene, ["block.mass=280..300 t by 10 t"], into=tmp_path / "study")
    commands = {row["command"] for row in study.rows.values()}
    assert all(f"--set method={base.method}" in x and "ask=[]" in x for x in commands)
    (spot,) = (n for n, row in study.rows.items() if "error" in row)
    assert measured_error(study).startswith(f"error measured on variant {spot}: within ")
    row = next(row for row in study.rows.values() if row["input/block.mass [t]"] == 300.0)
    sets = [*ASKED, *row["settings"]]
    again = simulate(load("lift", [*sets, *ModelLevel(base).settings]))
    assert row["digest"] == again.digest


def test_a_study_of_a_scene_with_extends_uses_the_model_level_chosen_for_that_scene(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("heavylift: 1\nname: mine\nextends: lift\nask: [rope tension]\nend: 40 s\n")
    scene = level_of(load(path))
    task = Task.of(scene, 60.0, "none", False)
    again = parse(task.text, task.name, task.settings)
    assert (again.plan.method, again.plan.tolerance) == (scene.plan.method, scene.plan.tolerance)
    assert again.plan.fidelity == scene.plan.fidelity
    assert again.question is None


def test_the_command_check_reports_the_model_level_that_an_earlier_choice_stored_in_the_cache(
    kept: dict[str, bytes], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = ["end=80 s", *ASKED[1:]]  # which does not cut the lift
    monkeypatch.setattr("sys.argv", ["heavylift", "check", "lift", *(x for s in asked for x in ("--set", s))])
    main()
    assert "errors are not measured yet" in capsys.readouterr().out
    answer = chosen(load("lift", asked)).answer
    main()
    assert str(answer) in capsys.readouterr().out
