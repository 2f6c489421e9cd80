"""All commands of `heavylift`, whoever wrote them: help with an example, plain output, JSON, exit codes, completion."""

from __future__ import annotations

import json
import re
import shlex
from importlib.metadata import version
from pathlib import Path

import pytest
import typer
from heavylift.coordinator.cli import main
from heavylift.coordinator.commands import app
from heavylift.coordinator.commands.common import recording_files, scene_names
from heavylift.nodes.scene import bundled

COMMANDS = typer.main.get_command(app).commands
OF_DATA = {  # what a machine would read has --json; all others write files, serve, or say one sentence
    *("check", "tree", "statics", "modes", "doctor"),
    *("run", "resume", "devs", "watch"),
    *("info", "compare", "replay", "trace"),
    *("pause", "step", "continue", "command", "stop"),
}
OF_FILES = ("info", "plot", "view", "report", "export", "recover", "replay", "layout", "resume", "trace")
HARMLESS = {"check", "tree", "statics", "modes", "equations", "schema"}  # of which a test runs the example
CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f]")


def heavylift(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of the command, in this process."""
    code = 0
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["heavylift", *words])
        try:
            main()
        except SystemExit as end:
            code = int(end.code or 0)
    text = capsys.readouterr()
    return code, text.out, text.err


def example(name: str) -> list[str]:
    """The words of a command's example, without `heavylift`, comment or redirection."""
    _, *words = shlex.split(COMMANDS[name].example)
    return words[: words.index(">")] if ">" in words else words


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_help_ends_with_an_example_that_is_a_valid_command_line(
    capsys: pytest.CaptureFixture[str], name: str
) -> None:
    code, message, _ = heavylift(capsys, name, "--help")
    assert code == 0
    lines = message.splitlines()
    assert lines[lines.index("Example:") + 1].startswith(f"  heavylift {name}")
    command, *words = example(name)
    assert command == name
    COMMANDS[name].make_context(name, words)  # raises on an unknown option, a missing argument, a wrong type
    assert COMMANDS[name].get_short_help_str(200).endswith((".", ")"))


@pytest.mark.parametrize("name", sorted(HARMLESS))
def test_the_example_in_the_help_of_a_command_runs(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert heavylift(capsys, "new", "my-lift")[0] == 0
    code, message, _ = heavylift(capsys, *example(name))
    assert code == 0
    assert message
    assert not CONTROL.search(message)


def test_commands_that_print_data_have_a_json_option() -> None:
    assert {name for name, c in COMMANDS.items() if any("--json" in p.opts for p in c.params)} >= OF_DATA


@pytest.mark.parametrize(
    "command", [("check", "lift"), ("tree", "arm"), ("statics", "pendulum"), ("modes", "pendulum")]
)
def test_the_json_output_of_a_command_is_one_object(
    capsys: pytest.CaptureFixture[str], command: tuple[str, ...]
) -> None:
    code, message, _ = heavylift(capsys, *command, "--json")
    assert code == 0
    assert isinstance(json.loads(message), dict)


def test_the_help_lists_all_commands_and_exit_codes(capsys: pytest.CaptureFixture[str]) -> None:
    code, message, _ = heavylift(capsys, "--help")
    assert code == 0
    assert set(COMMANDS) <= set(re.findall(r"^  ([a-z-]+)  ", message, re.M))
    assert "Exit codes: 0 done; 1 the scene, the run or the file is at fault" in message
    assert not CONTROL.search(message)


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        (("ifno", "x.mcap"), 2, "No such command 'ifno'. Did you mean 'info'?"),
        (("info", "--jason", "x.mcap"), 2, "No such option: --jason"),
        (("run",), 2, "Missing argument '"),
        (("replay", "x.mcap", "--rate", "fast"), 2, "Invalid value for '--rate'"),
        (
            ("run", "turnovr"),
            1,
            "there is no scene 'turnovr', neither a file nor a bundled one: did you mean 'turnover'?",
        ),
        (("check", "no.yaml"), 1, "there is no scene file 'no.yaml'"),
        (("run", "arm", "--set", "ned=1 s"), 1, "did you mean 'end'?"),
        (("new", "lift", "--like", "lfit"), 1, "did you mean 'lift'?"),
        (
            ("compare", "no.mcap", "no.mcap"),
            1,
            "no.mcap: the file does not exist; check the name or make it with `heavylift run`",
        ),
        *(((name, "no.mcap", *(("-o", "x.csv") * (name == "export"))), 1, "no.mcap") for name in OF_FILES),
    ],
)
def test_mistakes_on_the_command_line_end_with_a_one_sentence_error(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    words: tuple[str, ...],
    code: int,
    sentence: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    found, text, message = heavylift(capsys, *words)
    assert (found, text) == (code, "")
    assert sentence in message
    assert "Traceback" not in message
    assert "internal error" not in message
    assert list(tmp_path.iterdir()) == []


def test_shell_completion_offers_scenes_and_recordings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("turn.yaml", "run.mcap", "cut.mcap.part", "notes.txt", ".hidden.mcap"):
        (tmp_path / name).touch()
    (tmp_path / "yard").mkdir()
    (tmp_path / "yard" / "west.mcap").touch()
    assert scene_names("tur") == ["turnover-untuned", "turnover", "turn.yaml"]
    assert scene_names("") == [*bundled(), "turn.yaml", "yard/"]
    assert recording_files("") == ["cut.mcap.part", "run.mcap", "yard/"]
    assert recording_files("yard/w") == ["yard/west.mcap"]
    assert recording_files("nowhere/") == []


@pytest.mark.parametrize(
    ("line", "offered"), [("heavylift run tur", "turnover-untuned\nturnover\n"), ("heavylift info r", "run.mcap\n")]
)
def test_heavylift_answers_a_request_for_shell_completion(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, line: str, offered: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "run.mcap").touch()
    monkeypatch.setenv("_HEAVYLIFT_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", line)
    monkeypatch.setenv("COMP_CWORD", "2")
    assert heavylift(capsys)[1] == offered


def test_the_option_version_prints_the_version_of_heavylift(capsys: pytest.CaptureFixture[str]) -> None:
    assert heavylift(capsys, "--version") == (0, f"heavylift {version('heavylift')}\n", "")
