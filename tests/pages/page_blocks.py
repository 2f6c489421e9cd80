"""Follows a page as a reader would: runs its commands in order in one folder and compares the output.

```sh      each line is a command (a block with a here-document is one); `# exit code 1` behind it is what it ends with
```python  runs with what the blocks before have defined
```text    every line of it occurs in what the blocks since the last text have said
```

Commands of heavylift run in this process, which saves a start of Python each; all others in bash.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from heavylift.coordinator.cli import main

ROOT = Path(__file__).parents[2]
FENCED = re.compile(r"^```(\w*)\n(.*?)^```$", re.M | re.S)
CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f]")
PATIENCE_s = 120.0


def blocks(page: str) -> list[tuple[str, str]]:
    """Language and text of each block of a page, given by its path in the repository."""
    return FENCED.findall((ROOT / page).read_text())


def follow(page: str, folder: Path, capfd: pytest.CaptureFixture[str], patch: pytest.MonkeyPatch) -> int:
    """Run all blocks of a page in a folder; how many commands and Python blocks were run."""
    _settle(folder, patch)
    done, answer, names = 0, "", {}
    for language, text in blocks(page):
        if language == "text":
            missing = [line for line in text.splitlines() if line.strip() not in answer]
            assert not missing, f"{page}: {missing} not in\n{answer}"
            answer = ""
            continue
        if language == "sh":
            for command in _commands(text):
                done += 1
                _run(page, command, patch)
        elif language == "python":
            done += 1
            exec(compile(text, page, "exec"), names)
        out, err = capfd.readouterr()
        assert not CONTROL.search(out + err), f"{page}: a pipe gets plain text, no colours and no bars"
        answer += out + err
    return done


def type_command(command: str, folder: Path, patch: pytest.MonkeyPatch) -> None:
    """Run a single command in a folder."""
    _settle(folder, patch)
    _run("a page", command, patch)


def _settle(folder: Path, patch: pytest.MonkeyPatch) -> None:
    """Stand in a folder, with settings of its own and the commands of this environment."""
    patch.chdir(folder)
    patch.setenv("PATH", f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    patch.setenv("COLUMNS", "200")
    patch.setenv("XDG_CONFIG_HOME", str(folder / ".config"))


def _commands(text: str) -> list[str]:
    """Lines; from a here-document to its end is one."""
    found: list[str] = []
    end = ""
    for line in text.splitlines():
        if end:
            found[-1] += f"\n{line}"
            end = "" if line == end else end
        else:
            found.append(line)
            here = re.search(r"<<'?(\w+)'?", line)
            end = here[1] if here else ""
    return found


def _run(page: str, command: str, patch: pytest.MonkeyPatch) -> None:
    message = re.search(r"  # exit code (\d+)", command)
    wanted = int(message[1]) if message else 0
    if command.startswith("heavylift ") and not re.search(r" [<>&|]", command):
        patch.setattr("sys.argv", shlex.split(command, comments=True))
        try:
            main()
            code = 0
        except SystemExit as end:
            code = int(end.code or 0)
    else:
        code = subprocess.run(["bash", "-euc", command], timeout=PATIENCE_s).returncode
    assert code == wanted, f"{page}: `{command}` ended with {code}"
