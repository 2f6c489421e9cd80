"""`--strict` and `--fail-on` mean the same in check, run, branch, resume, sweep and limits."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.coordinator.commands import app
from typer.testing import CliRunner

STATES = ("red", "undecided", "amber", "green")  # worst first
OPTIONS = {(): 0, ("--strict",): 2, ("--fail-on", "red"): 1, ("--fail-on", "undecided"): 2, ("--fail-on", "amber"): 3}
SETS = {"red": ["limits.touch=0.5 m/min"], "amber": ["ask=[]"], "green": []}  # of a lift that creeps at 1 m/min

CHANGE = ("--set", "limits.clearance=0.4 m")


def code(*words: str) -> int:
    return CliRunner().invoke(app, [*words]).exit_code


def sets(state: str) -> list[str]:
    return [word for one in SETS[state] for word in ("--set", one)]


def expected(state: str, option: tuple[str, ...], always: int = 0) -> int:
    """The exit code for a state, if `always` so many of the worst states end with 1."""
    return int(STATES.index(state) < max(OPTIONS[option], always))


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("runs")
    found = {state: folder / f"{state}.mcap" for state in SETS}
    for state, path in found.items():
        assert code("run", "jib", "--in-process", "-o", str(path), *sets(state)) == 0
    return found


@pytest.mark.large(beyond=2)
@pytest.mark.parametrize("option", OPTIONS)
@pytest.mark.parametrize("state", SETS)
def test_the_verdict_decides_the_exit_code_of_the_commands_run_resume_and_branch(
    state: str, option: tuple[str, ...], recordings: dict[str, Path], tmp_path: Path
) -> None:
    path, wanted = recordings[state], expected(state, option)
    cut = tmp_path / "cut.mcap.part"
    cut.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    again = str(tmp_path / "again.mcap")
    assert code("run", "jib", "--in-process", "--force", "-o", again, *sets(state), *option) == wanted
    assert code("resume", str(cut), "-o", str(tmp_path / "resumed.mcap"), *option) == wanted
    assert code("branch", str(path), "--at", "200 s", *CHANGE, "-o", str(tmp_path / "branch.mcap"), *option) == wanted


@pytest.mark.large(beyond=2)
@pytest.mark.parametrize("option", OPTIONS)
def test_the_commands_check_and_limits_exit_with_code_1_on_a_red_verdict(
    option: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for state, given in (("red", sets("red")), ("amber", ["--set", "limits.off-lead=unknown"]), ("green", [])):
        assert code("check", "jib", *given, *option) == expected(state, option, always=1)
    assert code("limits", "jib", "--of", "block.mass=10..30 t", *sets("red"), *option) == 1


@pytest.mark.large(beyond=2)
@pytest.mark.parametrize("option", OPTIONS)
def test_the_worst_verdict_in_a_study_decides_the_exit_code_of_its_command(
    option: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Errors are not measured in each row, so that a row is amber at best."""
    monkeypatch.chdir(tmp_path)
    for state, values in (("red", "0.5 m/min, 2 m/min"), ("amber", "2.5 m/min, 3 m/min")):
        found = code("sweep", "jib", "--vary", f"limits.touch={{{values}}}", "-o", state, *option)
        assert found == expected(state, option)
