"""Every command printed on pages and in help works; quick ones and exceptions: tests/pages."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "pages"))
from page_blocks import type_command
from printed_commands import exception, is_quick, prepare, printed


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("printed")
    prepare(found, "turnover")
    return found


@pytest.mark.parametrize("command", [text for text in printed() if not is_quick(text) and not exception(text)])
def test_every_command_printed_on_the_pages_succeeds(
    command: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    type_command(command, folder, monkeypatch)
