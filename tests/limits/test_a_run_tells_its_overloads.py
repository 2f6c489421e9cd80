"""A run says at its end what was beyond a limit, in red and in a planner's words; so does its report."""

from pathlib import Path

import msgspec
import pytest
from heavylift.coordinator.commands.app import app
from heavylift.coordinator.record.limits import judged_recording, table
from heavylift.coordinator.run import run
from heavylift.coordinator.run.progress import summary
from heavylift.nodes.scene import load
from heavylift.recordings import Recording, report
from heavylift.recordings.report import facts
from typer.testing import CliRunner

SLING = "rig.sling.breaking=3.68 MN"  # at rest just within its factor of 5, in the lift just beyond


@pytest.fixture(scope="module")
def overloaded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("run") / "lift.mcap"
    run(load("lift", [SLING]), path, in_process=True)
    return path


def test_the_summary_is_red(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    scene = load("lift", [SLING])
    result = run(scene, tmp_path / "lift.mcap", in_process=True)
    summary(scene.plan, result, tmp_path / "lift.mcap")
    told = capsys.readouterr().out
    line, last = (line for line in told.splitlines() if "red: " in line)
    assert (
        "the tension of the sling loader-3.sling-1 was 743 kN, 101 % of its limit: 4.95 times below its breaking "
        "force, 5 are needed (EN 13414-1, working coefficient 5); likewise loader-3.sling-2, at 0:00:25 (up)"
    ) in line
    assert "verdict: red: the tension of the sling loader-3.sling-1 was 743 kN" in last
    assert line.startswith("\x1b[1;31m"), "bold red"


def test_the_worst_of_each_limit_has_its_time_and_stage(overloaded: Path) -> None:
    rec = Recording(overloaded)
    found = judged_recording(rec)
    assert found is not None
    peaks = rec.fact("peaks")
    worst = {(u.limit.quantity, u.limit.subject): u for u in found.uses}
    sling = worst["sling tension", "loader-3.sling-1"]
    peak = peaks["loader-3.sling-1"]
    assert (sling.value, sling.t, sling.stage) == (peak["tension"], peak["time"], "up"), "the exact peak, not a sample"
    assert sling.use == pytest.approx(5 * peak["tension"] / 3.68e6)
    hook = worst["hook load", "crane.H3"]
    assert hook.value == pytest.approx(peaks["crane.H3"]["tension"] / found.plan.gravity - 25e3)
    rope = next(r for r in found.plan.rig.hook_ropes if r.name == "crane.H3")
    own = rope.line / 20 * found.plan.gravity * 64.5  # [N] of a part while the block is lifted off
    lead = 10 * 0.02 / (1 - 0.98**10)
    pull = worst["rope peak", "crane.H3"].value
    assert pull == pytest.approx(lead * peaks["crane.H3"]["tension"] / 20 + own, rel=1e-3)
    assert [(f.subject, f.severity) for f in found.findings] == [
        ("loader-3.sling-1", "red"),
        ("loader-3.sling-2", "red"),
    ]


def test_the_report_shows_each_row_and_no_raw_message(overloaded: Path, tmp_path: Path) -> None:
    text = report(overloaded, tmp_path / "lift.html").read_text()
    for told in (
        "<td>sling tension</td><td>loader-3.sling-1 (of 6)</td><td>742.9 kN</td><td>0:00:24.5, up</td>",
        '<td class="bad">101 %</td>',
        "<td>rope factor</td><td>crane.H3 (of 3)</td>",
        "2 drum ends (assumed), sheave efficiency 0.98 (assumed): lead part 1.093 of the mean",
        "was 743 kN, 101 % of its limit",
        "Verdict: red: the tension of the sling loader-3.sling-1 was 743 kN",
        "1.05 foreseen (0027/ND rev 11.2, table 5-1, onshore)",
        "HC1 1.051, HC2 1.102, HC3 1.153, HC4 1.203",
        "wind of all: not judged; no wind is modelled",
    ):
        assert told in text, told
    assert "{&quot;actor" not in text
    result = CliRunner().invoke(app, ["report", str(overloaded), "-o", str(tmp_path / "by-command.html")])
    assert result.exit_code == 0
    assert (tmp_path / "by-command.html").read_text() == text


def test_what_stopped_itself_is_told_in_words_and_standing_at_an_end_is_no_fault(tmp_path: Path) -> None:
    """A trolley that runs on to the end of its girder, against which its servo presses."""
    run_on = 'actions=[{lower trolleys: "traverse 20 m/min until tension of crane.H1 >= 5 MN"}]'
    scene = load("lift", [run_on, "cranes.crane.girder=[60 m, 81.2 m]", "rig.slack=0.4 m", "end=30 s"])
    run(scene, tmp_path / "limit.mcap", in_process=True)
    rec = Recording(tmp_path / "limit.mcap")
    cut, told = facts(rec).warnings
    assert told.what == "the lower trolley of crane was stopped by its limit 'travel limit'"
    assert cut.what.startswith("the end of the scene at 30 s cut the lift")
    found = judged_recording(rec)
    assert found is not None
    assert found.findings == []
    end = next(u for u in found.uses if (u.limit.quantity, u.limit.subject) == ("girder", "crane lower"))
    assert end.value == pytest.approx(81.2, abs=0.05)


def test_a_lift_within_its_limits_says_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = load("lift")
    result = run(scene, tmp_path / "lift.mcap", in_process=True)
    summary(scene.plan, result, tmp_path / "lift.mcap")
    assert "red:" not in capsys.readouterr().out
    found = judged_recording(Recording(tmp_path / "lift.mcap"))
    assert found is not None
    assert found.findings == []
    assert not table(found).red


def test_a_recording_of_another_version_is_reported_without_its_limits(overloaded: Path) -> None:
    rec = Recording(overloaded)
    plan = msgspec.json.decode(rec.attachments["resolved.json"])
    rec.attachments["resolved.json"] = msgspec.json.encode({**plan, "unheard of": 1})
    assert judged_recording(rec) is None
