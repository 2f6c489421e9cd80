"""Commands work in folders with non-ASCII names, whatever the locale and the encoding of standard output."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

UNSET = ("LANG", "LC_ALL", "LC_CTYPE", "PYTHONUTF8", "PYTHONIOENCODING")


@pytest.mark.parametrize("given", [{"LC_ALL": "C", "PYTHONUTF8": "0"}, {"PYTHONIOENCODING": "ascii"}], ids=str)
def test_the_command_check_accepts_a_scene_file_with_any_characters_in_its_name(
    tmp_path: Path, given: dict[str, str]
) -> None:
    folder = tmp_path / "Überhänge 船"
    folder.mkdir()
    (folder / "größe.yaml").write_text("heavylift: 1\nname: a\nextends: pendulum\nend: soon\n", encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", "from heavylift.coordinator.cli import main; main()", "check", "größe.yaml"],
        cwd=folder, env={k: x for k, x in os.environ.items() if k not in UNSET} | given, capture_output=True,
        check=False,
    )  # fmt: skip
    assert done.returncode == 1
    assert b".yaml:4:6: error: end:" in done.stdout + done.stderr
    assert b"internal error" not in done.stderr
