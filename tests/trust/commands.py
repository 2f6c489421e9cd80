"""Runs commands of heavylift in this process, for a user whose list of trusted folders is empty at the start."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from heavylift.coordinator.cli import main

Command = Callable[..., tuple[int, str]]

RAIL = """\
heavylift: 1
name: rail
end: 1 s
mechanism:
  bodies:
    car: {mass: 2 t, inertia: [1 t*m2, 1 t*m2, 1 t*m2]}
  joints:
    rail: {type: prismatic, child: car, axis: [1, 0, 0], speed: 1 m/s}
  forces:
    own: {type: law, function: "FUNCTION", joint: rail, parameters: [1000]}
"""
LAW = "open('MARK', 'a').write('x')\n\n\ndef push(x):\n    return -x.parameters[0] * x.q\n"


def user(tmp_path: Path, patch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Command:
    """`heavylift(command, ...)` -> exit code and all that it said."""
    patch.chdir(tmp_path)
    patch.setenv("XDG_CONFIG_HOME", str(tmp_path / "configuration"))

    def command(*words: object) -> tuple[int, str]:
        capfd.readouterr()
        patch.setattr("sys.argv", ["heavylift", *map(str, words)])
        try:
            main()
            code = 0
        except SystemExit as end:
            code = int(end.code or 0)
        return code, "".join(capfd.readouterr())

    return command


def law(folder: Path, function: str = "mine.py:push", name: str = "mine.py") -> Path:
    """A scene with a law in a file beside it, which leaves a mark when it is imported."""
    folder.mkdir(exist_ok=True)
    (folder / name).write_text(LAW.replace("MARK", str(folder / "mark")))
    (folder / "rail.yaml").write_text(RAIL.replace("FUNCTION", function))
    return folder / "rail.yaml"
