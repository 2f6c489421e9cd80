"""Every command of TUTORIAL.md, in its order, prints the output shown on the page."""

from pathlib import Path

import pytest
from page_blocks import follow


def test_following_the_tutorial_produces_the_files_that_it_describes(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert follow("nodes/scenes/TUTORIAL.md", tmp_path, capfd, monkeypatch) == 24
    assert {path.name for path in tmp_path.iterdir()} >= {
        "my-lift.html",
        "my-lift-report.html",
        "both.png",
        "mine.mcap",
        "pair-lift.png",
    }
