"""A scene that leaves open how it is run is asked what is usually meant, and is run as finely as its checks need."""

from __future__ import annotations

from pathlib import Path
from random import Random

import msgspec
import pytest
from heavylift.coordinator.cli import main
from heavylift.coordinator.ladder import AskedFigure, Ladder, Measuring, ModelLevel, chosen, decided, looks
from heavylift.coordinator.record import play
from heavylift.coordinator.run import RunBranch, run
from heavylift.coordinator.run.branch import branch
from heavylift.coordinator.run.simulate import simulate
from heavylift.kernel.description import Check
from heavylift.nodes.plan import MEANT, OF_TENSIONS, Question
from heavylift.nodes.scene import LoadedScene, load
from heavylift.recordings import Recording

NAMED = ["ask=[]", "accuracy=0.1 %", "method=radau5", "tolerance=1e-5", "step=5 ms", "fidelity={}"]
MOST = 5.0  # times what the errors of steps are, they may be reported to be where their order is seen


@pytest.mark.parametrize("named", NAMED)
@pytest.mark.parametrize("scene", ["lift", "turnover", "tandem"])
def test_errors_are_measured_by_default_unless_the_scene_states_quantities_accuracy_model_level_or_steps(
    scene: str, named: str
) -> None:
    assert load(scene).question == Question(MEANT, 0.01)
    assert load(scene, ["end=5 s", "samples=4 Hz", "seed=3"]).question == Question(MEANT, 0.01)
    given = load(scene, [named])
    assert given.question is None
    assert given.facts.accuracy == (0.001 if "accuracy" in named else OF_TENSIONS)
    assert chosen(given).plan == given.plan


def test_the_printed_summary_of_a_run_reports_all_measured_errors_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "sys.argv", ["heavylift", "run", "lift", "-o", str(tmp_path / "a.mcap"), "--in-process", "--verbose"]
    )
    main()
    text = capsys.readouterr().out
    answer = chosen(load("lift")).answer
    assert answer is not None
    assert [line for line in text.splitlines() if "within" in line] == [f"errors: {answer}"]
    assert max(answer.errors.values()) <= 0.01
    assert f"digest {simulate('lift').digest}" in text


def checks(scene: LoadedScene) -> list[Check]:
    """Of its signals."""
    return [c for c in play(scene.plan, errors=scene.errors).verdict.checks if c.quantity == "signal"]


def test_without_a_requested_accuracy_a_run_is_as_accurate_as_its_checks_need() -> None:
    def limited(tension: float) -> list[str]:
        return ["samples=40 Hz", f"limits.signals=[tension of crane.H1 <= {tension / 1e3!r} kN]"]

    (far,) = checks(chosen(load("lift", limited(2e6))))
    assert far.error
    near = limited(far.value + 0.9 * far.error)
    assert [c.state for c in checks(chosen(load("lift", near)))] == ["undecided"]
    text: list[str] = []
    fine = decided(load("lift", near), text.append)
    after = play(fine.plan, errors=fine.errors).verdict.checks
    assert all(c.state != "undecided" for c in after)
    assert text[-1].endswith(": 0 checks undecided")


class Falling(Measuring):
    """Figures whose errors fall as powers of the tolerance."""

    def __init__(self, orders: dict[str, float], sizes: dict[str, float]) -> None:
        super().__init__(MEANT)
        self.orders, self.sizes = orders, sizes

    def error(self, name: str, candidate: ModelLevel) -> float:
        return float(self.sizes[name] * candidate.plan.tolerance ** self.orders[name])

    def all_figures(self, candidate: ModelLevel) -> dict[str, AskedFigure]:
        return {x: AskedFigure(x, "swing", "m", 1.0 + self.error(x, candidate), 1.0) for x in self.orders}


@pytest.mark.parametrize("seed", range(40))
def test_estimated_step_errors_bound_the_true_errors_closely(seed: int) -> None:
    draw = Random(seed)
    order = draw.uniform(0.55, 1.2)
    measuring = Falling(
        {f"f{i}": order for i in range(5)}, {f"f{i}": draw.choice((-1, 1)) * draw.uniform(0.1, 9.0) for i in range(5)}
    )
    plan = msgspec.structs.replace(load("lift").plan, method="radau5")
    candidates = Ladder(plan).candidates(Ladder(plan).full[0])
    first = draw.randrange(4)
    second = first + draw.choice((1, 2))
    third = second + draw.choice((1, 2))
    for runs in ([candidates[first], candidates[second]], [candidates[first], candidates[second], candidates[third]]):
        samples = looks(runs, measuring)
        for look, candidate in zip(samples, runs, strict=True):
            for name, message in look.steps.items():
                assert message >= abs(measuring.error(name, candidate))
        if len(runs) == 3:
            most = max(samples[-1].steps.values()) / max(abs(measuring.error(x, runs[-1])) for x in measuring.orders)
            assert most <= MOST


def test_a_branch_of_a_run_has_its_own_error_estimates(tmp_path: Path) -> None:
    lift = run("lift", tmp_path / "lift.mcap", in_process=True).recording
    slower = ["stage up/all hooks=hoist 2 m/min by 1 m"]
    path = branch(RunBranch.of(lift, "stage up", slower), tmp_path / "slower.mcap").recording
    own, recorded = (Recording(x).fact("answer", {}) for x in (path, lift))
    assert own["fidelity"] == recorded["fidelity"]
    assert own["tolerance"] == recorded["tolerance"]
    assert own["figures"].keys() >= {"peak tension crane.H1", "duration of 'up'"}
    assert own["figures"] != recorded["figures"]
    assert all(0.0 < e <= 0.01 for e in own["errors"].values())
