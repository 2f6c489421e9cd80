"""The summary and the report of a run list exceeded limits in red."""

import json
from pathlib import Path

import pytest
from heavylift.coordinator.commands.common.app import app
from heavylift.coordinator.run import run, summary
from heavylift.coordinator.verdict import verdict_of
from heavylift.recordings import Recording, report
from lifting import bare
from typer.testing import CliRunner

SLING = "rig.sling.breaking=3.68 MN"  # at rest just within its factor of 5, in the lift just beyond
PRECISE = [
    SLING,
    "ask=[rope tension, sling tension]",
    "accuracy=0.3 %",
    "end=80 s",
]  # so that the error does not reach to the limit
TOLD = (
    "sling tension of loader-3.sling-1 was 743.5 kN, 101 %; 736 kN is allowed (assumed: the table of EN 13414-1 ends "
    "at 60 mm and 42 t a leg; give 'termination' or 'WLL')"
)


@pytest.fixture(scope="module")
def overloaded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("run") / "lift.mcap"
    run(bare("lift", PRECISE), path, in_process=True)
    return path


def test_an_overload_gives_a_red_summary_of_the_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    scene = bare("lift", PRECISE)
    result = run(scene, tmp_path / "lift.mcap", in_process=True)
    summary(scene.plan, result)
    lines = [line for line in capsys.readouterr().out.splitlines() if TOLD in line]
    assert len(lines) == 2, "the finding and the verdict"
    assert all(line.startswith("\x1b[1;31m") for line in lines), "bold red"
    assert f"{TOLD}; likewise loader-3.sling-2, at 1:" in lines[1]


def test_overloads_are_checked_at_the_exact_peak_and_not_at_a_sample(overloaded: Path) -> None:
    rec = Recording(overloaded)
    found = verdict_of(rec)
    assert found is not None
    peak = rec.fact("peaks")["loader-3.sling-1"]
    red = [f for f in found.findings if f.state == "red"]
    assert [f.subject for f in red] == ["loader-3.sling-1", "loader-3.sling-2"]
    assert (red[0].value, red[0].t, red[0].stage, red[0].limit) == (peak["tension"], peak["time"], "swing", 3.68e6 / 5)
    cells = {row[1]: row for row in found.tables[0].rows}
    hook = rec.fact("peaks")["crane.H3"]
    assert cells["hook load"][3] == f"{(hook['tension'] / 9.80665 - 25e3) / 1e3:.1f} t", (
        "the block belongs to the crane"
    )
    lead, own = 10 * 0.02 / (1 - 0.98**10), 7.92 * 9.80665 * 64.4  # [N] of a part while the block is lifted off
    pull = lead * hook["tension"] / 20 + own
    assert float(cells["rope factor"][3]) == pytest.approx(1351e3 / pull, rel=1e-3)


def test_the_report_of_a_run_describes_each_overload_in_words(overloaded: Path, tmp_path: Path) -> None:
    text = report(overloaded, tmp_path / "lift.html").read_text()
    peak = Recording(overloaded).fact("peaks")["loader-3.sling-1"]["tension"]
    for message in (
        '<td class="s red">red</td><td class="s">sling tension</td>',
        f'<td>loader-3.sling-1 (of 2)</td><td class="s">{peak / 1e3:.1f} kN</td>',
        '<td class="s">101 %</td>',
        '<td class="s">rope factor</td><td>crane.H3 (of 3)</td>',
        "2 drum ends, sheave efficiency 0.98: lead part 1.093 of the mean",
        "was 743.5 kN, 101 %; 736 kN is allowed",
        "Verdict, as recorded: RED: ",
        "worst: sling tension of loader-3.sling-1 was 743.5 kN",
        "Dynamic factor required: 1.05 (0027/ND rev 11.2, table 5-1, onshore)",
        "HC1 1.051, HC2 1.102, HC3 1.153, HC4 1.203",
        ">no wind is modelled</td>",
    ):
        assert message in text, message
    assert "{&quot;actor" not in text
    result = CliRunner().invoke(app, ["report", str(overloaded), "-o", str(tmp_path / "by-command.html")])
    assert result.exit_code == 0
    assert (tmp_path / "by-command.html").read_text() == text


def test_a_trolley_exactly_at_its_end_position_passes_its_check(tmp_path: Path) -> None:
    """A trolley that runs on to the end of its girder, against which its servo presses."""
    run_on = 'actions=[{lower trolleys: "traverse 20 m/min until tension of crane.H1 >= 5 MN"}]'
    scene = bare("lift", [run_on, "cranes.crane.girder=[60 m, 81.2 m]", "rig.slack=0.4 m", "end=30 s"])
    run(scene, tmp_path / "limit.mcap", in_process=True)
    found = verdict_of(Recording(tmp_path / "limit.mcap"))
    assert found is not None
    assert "end" not in {f.quantity for f in found.findings}
    row = next(row for row in found.tables[0].rows if row[1] == "girder")
    assert (row[2], row[3], row[5]) == ("crane lower (of 2)", "81.20 m", "60 to 81.2 m")


def test_empty_hooks_hoisted_at_full_speed_give_no_red_check(tmp_path: Path) -> None:
    """Empty hooks are hoisted as fast as they go: their loads jump, and they hold nothing that could lead off."""
    empty = 'actions=[{all hooks: "unhook"}, {stage: empty, all hooks: "hoist 10 m/min by 3 m"}, {wait: 10 s}]'
    run(bare("lift", [empty, "end=60 s"]), tmp_path / "empty.mcap", in_process=True)
    text = report(tmp_path / "empty.mcap", tmp_path / "empty.html").read_text()
    assert ' red">' not in text.partition("</style>")[2]
    assert '<td class="s">off-lead along</td><td>crane.H1 (of 3)</td><td class="s"></td>' in text
    assert "it did not occur" in text


def test_a_lift_within_its_limits_has_no_red_check(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = bare("lift", PRECISE[1:])
    result = run(scene, tmp_path / "lift.mcap", in_process=True)
    summary(scene.plan, result, as_json=True)
    message = json.loads(capsys.readouterr().out)["verdict"]
    assert result.verdict
    assert [f for f in result.verdict.findings if f.word != "note"] == []
    assert not message["red"]
    assert {row["state"] for row in message["checks"]} == {"green", "amber", "none"}
