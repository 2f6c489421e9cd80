"""Fixtures shared by the tests about trust."""

from pathlib import Path

import pytest
from commands import Command, user


@pytest.fixture
def heavylift(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Command:
    """The command line of a user who has trusted nothing yet."""
    return user(tmp_path, monkeypatch, capfd)
