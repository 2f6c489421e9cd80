"""Commands printed on pages and in help work: quick ones run here, others in tests/full, exceptions are listed."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from page_blocks import ROOT, type_command
from printed_commands import EXCEPTIONS, exception, is_quick, prepare, printed

TYPED = re.compile(r"`(?:\.venv/bin/)?((?:pytest|python) [^`\n]+)`")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("printed")
    prepare(found, "pendulum")
    return found


@pytest.mark.parametrize("command", [text for text in printed() if is_quick(text) and not exception(text)])
def test_every_fast_command_printed_on_the_pages_succeeds(
    command: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    type_command(command, folder, monkeypatch)


@pytest.mark.parametrize("pattern", EXCEPTIONS)
def test_every_listed_exception_to_the_test_of_printed_commands_is_still_needed(pattern: str) -> None:
    assert any(re.match(pattern, text.removeprefix("heavylift ")) for text in printed())


def test_tests_named_in_the_exceptions_for_printed_commands_exist() -> None:
    named = [path for why in EXCEPTIONS.values() for path in re.findall(r"tests/[\w/.]*\w", why)]
    assert [path for path in named if not (ROOT / path).exists()] == []


@pytest.mark.parametrize("page", ["README.md", "coordinator/DESIGN.md", "CONTRIBUTING.md"])
def test_tests_and_benches_that_pages_name_exist(page: str) -> None:
    """They are run as tests, and by .ci/run."""
    for typed in TYPED.findall((ROOT / page).read_text()):
        paths = [word for word in shlex.split(typed)[1:] if word.startswith("tests")]
        assert [path for path in paths if not (ROOT / path).exists()] == [], typed
