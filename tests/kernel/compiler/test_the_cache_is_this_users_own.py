"""Cached files are used only if no other user can have written them; otherwise they are computed anew."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from heavylift.coordinator.commands.health import _cache
from heavylift.kernel import read_cached, unsafe_cache, write_cached

OTHER = 12345  # another user
root_only = pytest.mark.skipif(os.getuid() != 0, reason="only root can give a file away")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(tmp_path / "cache"))
    write_cached("one.o", b"code")
    return tmp_path / "cache"


def test_the_cache_is_readable_by_its_user_only(folder: Path) -> None:
    assert (folder.stat().st_mode & 0o777, (folder / "one.o").stat().st_mode & 0o777) == (0o700, 0o600)
    folder.chmod(0o755)  # as an earlier version left it
    assert read_cached("one.o") == b"code"
    assert folder.stat().st_mode & 0o777 == 0o700
    assert (unsafe_cache(), _cache().state) == ("", "ok")


def linked(folder: Path) -> None:
    folder.rename(folder.with_name("theirs"))
    folder.symlink_to("theirs")


FOLDERS = {
    "a link": linked,
    "writable by all": lambda folder: folder.chmod(0o777),
    "writable by a group": lambda folder: (os.chown(folder, -1, 1), folder.chmod(0o770)),
    "of another user": lambda folder: os.chown(folder, OTHER, -1),
}


@pytest.mark.parametrize(
    "spoil",
    [
        pytest.param(f, id=name, marks=root_only if "user" in name or "group" in name else ())
        for name, f in FOLDERS.items()
    ],
)
def test_a_cache_folder_of_another_user_is_neither_read_nor_written(
    folder: Path, spoil: Callable[[Path], object]
) -> None:
    spoil(folder)
    assert read_cached("one.o") == b""
    write_cached("two.o", b"more")
    assert sorted(x.name for x in folder.iterdir()) == ["one.o"]
    found = _cache()
    assert (found.state, found.message.startswith(f"{folder} is not used, so every start compiles anew: it ")) == (
        "broken",
        True,
    )


FILES = {
    "a link": lambda file: (file.rename(file.with_name("x")), file.symlink_to("x")),
    "a pipe": lambda file: (file.unlink(), os.mkfifo(file)),
    "a folder": lambda file: (file.unlink(), file.mkdir()),
    "writable by all": lambda file: file.chmod(0o666),
    "of another user": lambda file: os.chown(file, OTHER, -1),
}


@pytest.mark.parametrize(
    "spoil", [pytest.param(f, id=name, marks=root_only if " user" in name else ()) for name, f in FILES.items()]
)
def test_a_cached_file_of_another_user_is_ignored_and_replaced(folder: Path, spoil: Callable[[Path], object]) -> None:
    spoil(folder / "one.o")
    assert read_cached("one.o") == b""
    write_cached("one.o", b"anew")
    assert read_cached("one.o") == (b"" if (folder / "one.o").is_dir() else b"anew")
    assert not list(folder.glob("one.o.*"))
