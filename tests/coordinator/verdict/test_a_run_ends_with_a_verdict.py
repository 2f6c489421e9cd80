"""Each run ends with a state, counts of its checks and all that was found, in one process or many, and tells it on the
terminal and in the recording."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest
from heavylift.coordinator.live import STOP, TimedCommand
from heavylift.coordinator.run import Progress, RunObserver, run
from heavylift.coordinator.verdict import verdict_of
from heavylift.kernel import HeavyliftError, KernelError, ModelError
from heavylift.kernel.description import NOT_CHECKED
from heavylift.nodes.devs import Event, Tag, seconds
from heavylift.nodes.models.parts import OperatorCommand
from heavylift.nodes.scene import bundled, parse
from heavylift.recordings import Recording, info, info_data, report
from heavylift.recordings.read import RecordedVerdict, recorded_verdict
from lifting import unstated

LIFT = unstated(bundled()["lift"].read_text())
UP = "  - stage: up\n    all hooks: hoist 3 m/min by 1 m\n"
SECOND = 0.5  # [s] between samples: what they show is known to one of them


def verdict(tmp_path: Path, text: str, *settings: str, commands: tuple[TimedCommand, ...] = ()) -> RecordedVerdict:
    result = run(parse(text, overrides=settings), tmp_path / "run.mcap", in_process=True, commands=commands, force=True)
    assert result.verdict is not None
    return result.verdict


def kinds(found: RecordedVerdict) -> list[str]:
    return [f.quantity for f in found.findings if f.state == "red"]


def test_a_verdict_counts_its_checks_and_lists_what_was_not_checked(tmp_path: Path) -> None:
    found = verdict(tmp_path, LIFT)
    assert found.line.startswith("AMBER: ")
    assert ", 0 red, 0 undecided, 14 not checked, " in found.line
    assert (found.red, found.findings) == (False, ())
    assert len(found.clearances) == 10
    ground, beams = found.clearances[:2]
    assert (ground.b, ground.distance) == ("ground", pytest.approx(3.0, abs=0.05)), "on its way, beyond its supports"
    assert beams.distance == pytest.approx(12.0 - 5.0, abs=0.05), "beams of 5 m, hooks 12 m apart"
    assert "clearance of slings while they are slack" in found.not_modelled
    assert "motion too fast for the samples of places and speeds, 2 a second" in found.not_modelled
    assert f", {len(found.not_modelled)} not modelled" in found.line
    rec = Recording(tmp_path / "run.mcap")
    assert recorded_verdict(rec) == found
    del rec.result["verdict"]
    again = verdict_of(rec)
    assert again is not None
    assert again.line == found.line, "a recording without a verdict is checked again"
    for a, b in zip(again.clearances, found.clearances, strict=True):
        assert (a.a, a.b, a.distance) == (b.a, b.b, pytest.approx(b.distance, abs=0.01))


def test_the_verdict_is_the_same_in_one_process_and_in_several(tmp_path: Path) -> None:
    scene = parse(LIFT, overrides=["end=30 s"])
    together = run(scene, tmp_path / "together.mcap", in_process=True)
    apart = run(scene, tmp_path / "apart.mcap")
    assert together.verdict == apart.verdict
    assert together.digest == apart.digest


def test_a_lifting_beam_that_enters_the_block_gives_a_red_check_with_depth_time_and_place(tmp_path: Path) -> None:
    """Its hook is unhooked and lowered on: 10 m of sling, then 4 m into the block of 8 m."""
    down = "  - stage: unhook\n    crane H3: unhook\n  - stage: through\n    crane H3: lower 10 m/min by 14.2 m\n"
    text = LIFT[: LIFT.index("actions:")] + "actions:\n" + down
    found = verdict(tmp_path, text.replace("end: 60 s\n", ""))
    assert kinds(found) == ["clearance", "clearance"], "its rope as well"
    (red,) = [f for f in found.findings if f.subject == "loader-3 and block"]
    eye = 10.3 + 10.0 + 3.0 - 0.05 - 14.2  # lug, sling, loader, slack, way
    assert red.value == pytest.approx(eye - 2.0 - 10.0, abs=0.02), "the hook block is 2 m high, the deck at 10 m"
    assert red.stage == "through"
    assert red.sentence.startswith("loader-3 went 2.95 m into the block (hook block of loader-3, block at u, v, w = ")
    assert found.red


def test_an_end_time_that_cuts_off_the_lift_gives_a_red_finding_in_check_and_run(tmp_path: Path) -> None:
    cut = parse(LIFT, overrides=["end=20 s"])
    assert [(f.quantity, f.word) for f in cut.findings if f.quantity == "cut"] == [("cut", "red")]
    found = verdict(tmp_path, LIFT, "end=20 s")
    assert kinds(found) == ["cut"]
    assert "the end of the scene at 20 s cut the lift: still waiting for" in found.line
    assert parse(LIFT).findings == (), "a last wait may be cut"


def test_a_stage_with_moves_that_ends_at_once_gives_a_red_finding_with_its_line_in_the_scene(tmp_path: Path) -> None:
    landed = "  - stage: set down\n    all hooks: lower 0.3 m/min until landed\n"
    text = LIFT.replace("actions:\n", "actions:\n" + landed)
    found = verdict(tmp_path, text)
    assert kinds(found) == ["stage"]
    (red,) = found.findings
    assert red.sentence == "the stage 'set down' ended at once: 'landed' held already, so it moved nothing"
    assert red.where.startswith("scene.yaml:34:")
    still = UP + "  - stage: nowhere\n    crane: travel 10 m/min to 40 m\n"
    found = verdict(tmp_path, LIFT.replace(UP, still), "end=80 s")
    assert [f.subject for f in found.findings] == ["nowhere"], "it stood there already"


@pytest.mark.parametrize(
    ("half", "rope", "sling", "severity", "degrees"),
    [(6.0, 85.7, 5.0, "warning", 53.1), (7.5, 85.85, 6.2, "red", 62.5)],
)
def test_the_verdict_reports_each_sling_of_a_bridle_beyond_its_allowed_angle(
    half: float, rope: float, sling: float, severity: str, degrees: float, tmp_path: Path
) -> None:
    """Beams of 4 m between lugs that are 12 m and 15 m apart; the hook begins just above them."""
    text = LIFT.replace("P1: [-8 m", f"P1: [{-6 - half} m").replace("P2: [-4 m", f"P2: [{-6 + half} m")
    text = text.replace("H1, sling: 10 m", f"H1, rope: {rope} m, sling: {sling} m").replace(
        "[20 m, 16 m", "[28 m, 16 m"
    )
    legs = [f for f in verdict(tmp_path, text, "end=6 s").findings if f.quantity == "bridle angle"]
    assert [(f.word, f.subject) for f in legs] == [(severity, f"loader-1.sling-{i}") for i in (1, 2)]
    for leg in legs:
        assert leg.value is not None
        assert np.degrees(leg.value) == pytest.approx(degrees, abs=0.2)


def test_a_centre_of_mass_outside_the_block_gives_a_red_finding_with_its_line_in_the_scene(tmp_path: Path) -> None:
    found = verdict(tmp_path, LIFT.replace("  size: [20", "  com: [0 m, 0 m, -4.5 m]\n  size: [20"), "end=1 s")
    assert kinds(found) == ["geometry", "cut"]
    assert "is 0.5 m outside the block" in found.line
    assert found.findings[0].where.startswith("scene.yaml:10:"), "its com"


def test_a_stop_by_the_operator_is_reported_in_the_verdict(tmp_path: Path) -> None:
    stop = TimedCommand(Tag(seconds(5.0)), msgspec.msgpack.encode(OperatorCommand(STOP)))
    found = verdict(tmp_path, LIFT, commands=(stop,))
    assert kinds(found) == ["operator"]
    assert found.findings[0].t == 5.0


class Ends(RunObserver):
    """Something ends the run when it begins a stage."""

    def __init__(self, error: BaseException) -> None:
        self.error = error

    def event(self, event: Event) -> None:
        if event.type == "Stage":
            raise self.error


@pytest.mark.parametrize("error", [KernelError("it broke"), ModelError("stuck"), KeyboardInterrupt(), None])
def test_a_run_that_ends_with_an_error_has_a_red_verdict_that_includes_all_checks_made_so_far(
    error: BaseException | None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = LIFT.replace("P1: [-8 m, -6 m, 4.3 m]", "P1: [-8 m, -6 m, 5.2 m]").replace("sling: 10 m", "sling: 12 m")
    if error is None:  # nothing can happen any more
        begin = text[: text.index("actions:")].replace("end: 60 s\n", "")
        text = begin + "actions:\n  - stage: never\n    when: all slings taut\n    wait: 1 s\n"
    scene = parse(text.replace("slack: 50 mm", "slack: 1.5 m"))
    with pytest.raises(HeavyliftError) as failed, Progress(scene.plan, as_json=error is None):
        run(scene, tmp_path / "run.mcap", in_process=True, watch=Ends(error) if error else None)
    rec = Recording(tmp_path / "run.mcap")
    found = recorded_verdict(rec)
    assert found is not None
    assert (found.red, kinds(found)) == (True, ["cut", "geometry"])
    assert found.line.startswith("RED: ")
    assert found.line.endswith("; worst: the run did not reach its end")
    assert str(failed.value) == rec.result["reason"] != "", "why is reported once, as the reason"
    out = capsys.readouterr().out
    if error is None:
        message = json.loads(out)
        assert (message["error"], msgspec.convert(message["verdict"], RecordedVerdict)) == (rec.result["reason"], found)
    else:
        assert (failed.value.verdict, out) == (found, "")


def test_a_scene_without_a_lift_also_has_a_verdict(tmp_path: Path) -> None:
    found = verdict(tmp_path, bundled()["pendulum"].read_text(), "end=2 s")
    assert found.state == "amber"
    assert found.line.endswith("; the scene has no limits to check: write 'limits'")
    assert "which have no shapes" in " ".join(x.sentence for x in found.checks if x.why == NOT_CHECKED)


def test_a_red_verdict_is_the_first_line_that_run_prints_and_gives_exit_code_1_with_strict(tmp_path: Path) -> None:
    def heavylift(*words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-c", "from heavylift.coordinator.cli import main; main()", *words],
            cwd=tmp_path, capture_output=True, text=True, check=False,
        )  # fmt: skip

    asked = ("run", "lift", "--in-process", "--set", "end=20 s", "-o", "cut.mcap")
    plain, strict = heavylift(*asked), heavylift(*asked, "--strict", "--json")
    assert (plain.returncode, strict.returncode) == (0, 1)
    first = plain.stdout.splitlines()[0]
    assert first.startswith("verdict: RED: ")
    assert "worst: the end of the scene at 20 s cut the lift" in first
    assert "\x1b" not in plain.stdout
    assert json.loads(strict.stdout)["promised"] == {"asked": [], "accuracy": 1e-4, "measured": {}}
    message = json.loads(strict.stdout)["verdict"]
    assert message["red"]
    told_again = json.loads(heavylift("info", "cut.mcap", "--json").stdout)["verdict"]
    assert told_again == message
    assert json.loads(heavylift("report", "cut.mcap", "--json").stdout)["verdict"] == message


def test_the_commands_info_and_report_print_the_verdict_and_name_the_tolerance(tmp_path: Path) -> None:
    verdict(tmp_path, LIFT)
    text, page = info(tmp_path / "run.mcap"), report(tmp_path / "run.mcap", tmp_path / "r.html").read_text()
    for message in (text, page):
        assert "AMBER: " in message
        assert " passed, 0 red, 0 undecided" in message
        assert "integrator" in message
        assert "accuracy" not in message
        assert "left out: girder rigid, ropes without mass" in message
    assert "girder rigid, motion spatial" in page, "the fidelity is listed"
    assert info_data(tmp_path / "run.mcap")["settings"]["steps"] == "dopri5, integrator's tolerance 1e-06"
    verdict(tmp_path, LIFT, "ask=[rope tension]", "accuracy=2 %")
    asked = info(tmp_path / "run.mcap")
    assert "rope tension to 2 %" in asked
    assert "rope tension within " in asked, "the measured error"


def test_the_length_of_a_rope_with_mass_is_the_sum_of_its_pieces(tmp_path: Path) -> None:
    """None of the pieces is as long as the shortest rope of its winch, 8 m; together they are."""
    found = verdict(tmp_path, LIFT, "fidelity={ropes: massive, lumps: 4}")
    assert not found.red
