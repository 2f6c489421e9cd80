"""Commands of heavylift printed on pages and in help: the test that runs each, and the files in its folder."""

from __future__ import annotations

import re
import shutil
from functools import cache
from pathlib import Path

import typer
from heavylift.coordinator.commands import app
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from heavylift.recordings import Recording
from page_blocks import ROOT

FOLLOWED = {"nodes/scenes/TUTORIAL.md", "coordinator/HOWTO.md"}  # block by block, in tests of their own
HOWTO = ROOT / "coordinator/HOWTO.md"
PLACEHOLDER = re.compile(r"\b(SCENE|FILE|DIR|DIRECTORY|NAME|MODEL|RUN|LOG|N)\b")
EXCEPTIONS = {  # what is not run as it is printed, and why
    r"(watch|pause|continue|step|command|stop) ": "speaks to a run that goes on: tests/coordinator/live",
    r"node ": "waits for a coordinator on another host: tests/coordinator/hosts",
    r"workbench ": "serves until it is stopped: tests/coordinator/workbench",
    r".*--foxglove\b": "serves a port: tests/coordinator/live/test_any_program_may_listen.py",
    r".*--external\b": "waits for a program of another kind: tests/coordinator/external",
    r".*--view\b": "opens a browser and waits for it: tests/recordings/test_a_page_shows_a_run_that_goes_on.py",
    r"run turnover --rate 1$": "takes as long as the lift, 67 minutes: tests/coordinator/live/test_a_run_keeps_time.py",
    r"tradeoff ": "runs the whole ladder: tests/coordinator/ladder",
    r"devs my_models.py:build$": "has no end, as no `--until` is given: tests/coordinator/participants",
    r"(run|devs) --[a-z-]+$": "names an option",
    r".*\blog\.csv": "needs the log of a crane: coordinator/HOWTO.md",
    r".*--scheduler\b": "needs a scheduler and its workers: tests/coordinator/sweeps",
    r"plot run\.mcap 'station/\*'": "is of a DEVS model: coordinator/HOWTO.md",
    r"branch ": "needs a whole lift with that stage: coordinator/HOWTO.md",
    r"gallery ": "runs scenes and draws them: tests/gallery, tests/coordinator/commands/test_a_beginner_starts.py",
}
QUICK = {  # done in less than a second each; the others are run in tests/full
    *("info", "export", "compare", "trace", "layout", "recover", "trust", "new", "schema", "equations", "tree"),
}


@cache
def printed() -> list[str]:
    """Every command once, without placeholders and comments; those that make recordings first."""
    texts = [command.example for command in typer.main.get_command(app).commands.values()]
    for page in sorted(ROOT.rglob("*.md")):
        name = page.relative_to(ROOT).as_posix()
        if name[0] == "." or "node_modules" in name:
            continue
        text = page.read_text()
        texts += re.findall(r"`(heavylift [^\s`]+ [^`\n]*)`", text)
        if name not in FOLLOWED:
            texts += re.findall(r"^ {4}(heavylift .*?)(?:  .*)?$", text, re.M)
            blocks = re.findall(r"^```sh\n(.*?)^```", text, re.M | re.S)
            texts += [line for block in blocks for line in block.splitlines() if line.startswith("heavylift ")]
    found = dict.fromkeys(text for text in texts if not PLACEHOLDER.search(text))
    return sorted(found, key=lambda text: not text.startswith("heavylift run "))


def is_quick(command: str) -> bool:
    """Whether a command is run each day."""
    return command.split()[1] in QUICK and ">" not in command  # which takes a shell, and a start of Python


def exception(command: str) -> str:
    """Why a command is not run as it is printed; "" if it is."""
    words = command.removeprefix("heavylift ")
    return next((why for pattern, why in EXCEPTIONS.items() if re.match(pattern, words)), "")


def prepare(folder: Path, scene: str) -> None:
    """What the commands take for granted: recordings, one that was cut off, a model, a folder of laws."""
    run(load(scene, ["end=2 s"]), folder / "turnover.mcap", in_process=True)
    chunk = Recording(folder / "turnover.mcap")._file.summary.chunk_indexes[-1]
    cut_off = (folder / "turnover.mcap").read_bytes()[: chunk.chunk_start_offset + chunk.chunk_length + 3]
    for name in ("a.mcap", "b.mcap", "run.mcap", "lift.mcap", "slower.mcap"):
        shutil.copyfile(folder / "turnover.mcap", folder / name)
    for name in ("turnover.mcap.part", "lift.mcap.part", "cut.mcap.part"):
        (folder / name).write_bytes(cut_off)
    (folder / "my_laws").mkdir()
    (workshop,) = re.findall(r"^cat > workshop\.py <<'END'\n(.*?)^END$", HOWTO.read_text(), re.M | re.S)
    (folder / "my_models.py").write_text(workshop)
    page = (ROOT / "nodes/yard/YARD.md").read_text()
    for kind, name in (("yaml", "yard.yaml"), ("csv", "blocks.csv")):
        (folder / name).write_text(re.findall(rf"^```{kind}\n(.*?)^```", page, re.M | re.S)[0])
