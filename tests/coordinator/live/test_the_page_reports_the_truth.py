"""Every command of LIVE.md, in its order, on one run; only names and words are put in the sledge's place."""

import re
import shlex
from pathlib import Path

import pytest
from heavylift.coordinator.commands import app
from running import PATIENCE_s, command, found, going
from sledge import SLEDGE
from typer.testing import CliRunner

PAGE = (Path(__file__).parents[3] / "coordinator/live/LIVE.md").read_text()
LINES = [shlex.split(line, comments=True)[1:] for line in re.findall(r"^ {4}(heavylift .*?)(?:  .*)?$", PAGE, re.M)]
ANSWERS = {
    "pause": r"paused at \d+\.\d{9} s\n",
    "step": r"paused at \d+\.\d{9} s\n",
    "continue": r"goes on\n",
    "command": r"pusher: drive 6 m/min by 0.5 m: began at \d+\.\d{9} s\n",
    "stop": r"ends at \d+\.\d{9} s\n",
}


@pytest.mark.large
def test_all_commands_printed_on_the_page_about_live_runs_give_the_printed_answers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    head, _, _ = SLEDGE.partition("  - stage: out")
    rests = "".join(f"  - stage: rest {n}\n    wait: 2 s\n" for n in range(900))
    (tmp_path / "sledge.yaml").write_text(head + rests)
    (started,) = [line for line in LINES if line[0] == "run" and "--rate" in line]
    with going(tmp_path, "run", "sledge.yaml", *started[2:]) as process:
        found(tmp_path / "sledge.mcap")
        lines = [[word.replace("turnover", "sledge") for word in line] for line in LINES]
        watching = [command(tmp_path, *line) for line in lines if line[0] == "watch" and "--ticket" not in line]
        text: list[str] = []
        for line in lines:
            words = ["pusher: drive 6 m/min by 0.5 m" if word.startswith("west H1") else word for word in line]
            if line[0] in ANSWERS:
                message = CliRunner().invoke(app, words)
                assert message.exit_code == 0, (line, message.exception)
                assert re.fullmatch(ANSWERS[line[0]], message.output), line
                text.append(line[0])
        assert process.wait(PATIENCE_s) == 0
        seen = [observer.communicate(timeout=PATIENCE_s)[0].splitlines() for observer in watching]
    assert text == ["pause", "step", "step", "continue", "command", "stop"]
    everything, stages, numbered = seen
    assert len(everything) == len(numbered) > len(stages) > 1
    assert everything[-1] == stages[-1]
    assert everything[-1].startswith("finished at ")
