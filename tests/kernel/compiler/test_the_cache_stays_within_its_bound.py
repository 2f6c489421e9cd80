"""The cache has a size limit: recent entries and files of others stay, and concurrent users get no error."""

from __future__ import annotations

import hashlib
import os
import random
import subprocess
import sys
from pathlib import Path

import pytest
from heavylift.coordinator.commands.health import _cache
from heavylift.kernel import (
    BLOCK,
    CHECK_EVERY,
    LEFT,
    OutputError,
    kept,
    kept_folder,
    prune_cache,
    read_cached,
    write_cached,
)

UNIT = "fmu-" + 32 * "a"
HOURS_ns = 3600 * 10**9
WRITER = """
import random, sys
from heavylift.kernel.cache import read_cached, write_cached
rng = random.Random(int(sys.argv[1]))
for _ in range(300):
    number = rng.randrange(40)
    name, content = f"{number:064x}.o", bytes([number]) * (5000 + 1000 * number)
    assert read_cached(name) in (b"", content)
    write_cached(name, content)
"""


def name(number: int) -> str:
    return f"{hashlib.sha256(b'%d' % number).hexdigest()}.o"


def held() -> int:
    return sum(x.size for x in kept())


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("HEAVYLIFT_CACHE_MB", raising=False)
    return tmp_path / "cache"


@pytest.mark.parametrize("seed", range(20))
def test_the_most_recently_used_cache_entries_are_kept(folder: Path, seed: int) -> None:
    rng = random.Random(seed)
    used = list(range(rng.randrange(1, 30)))
    rng.shuffle(used)
    for number, when in enumerate(used):
        write_cached(name(number), bytes(rng.randrange(60_000)))
        os.utime(folder / name(number), ns=(0, when * HOURS_ns))
    before, bound = kept(), rng.randrange(800_000)
    assert [x.used_ns for x in before] == [when * HOURS_ns for when in range(len(used))]
    freed, after = prune_cache(bound), kept()
    assert freed == sum(x.size for x in before) - held()
    assert held() <= bound
    assert after == before[len(before) - len(after) :]
    if freed:
        last = before[len(before) - len(after) - 1]
        assert held() <= LEFT * bound < held() + last.size


def test_a_process_that_writes_many_cache_entries_keeps_the_cache_within_its_bound(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HEAVYLIFT_CACHE_MB", "0.5")
    most = 0
    for number in range(200):
        write_cached(name(number), bytes(10_000))
        most = max(most, held())
        assert len(read_cached(name(number))) == 10_000
    assert LEFT * 0.5e6 < most <= (1 + CHECK_EVERY) * 0.5e6 + 2 * BLOCK + 10_000


def test_reading_a_cache_entry_protects_it_from_being_removed_first(folder: Path) -> None:
    for number in range(10):
        write_cached(name(number), bytes(BLOCK))
        os.utime(folder / name(number), ns=(0, number * HOURS_ns))
    assert read_cached(name(0))
    prune_cache(3 * BLOCK)
    assert [x.name for x in kept()] == [name(9), name(0)]


def test_files_that_heavylift_did_not_write_stay_in_the_cache_folder(folder: Path) -> None:
    """Somebody may name a folder that holds more."""
    folder.mkdir()
    (folder / "thesis.tex").write_bytes(bytes(100_000))
    (folder / "fmu-data").mkdir()
    write_cached(name(1), bytes(1000))
    prune_cache(0)
    assert sorted(x.name for x in folder.iterdir()) == ["fmu-data", "thesis.tex"]


def test_two_processes_may_write_and_evict_cache_entries_at_the_same_time(folder: Path) -> None:
    environment = os.environ | {"HEAVYLIFT_CACHE_MB": "0.2"}
    command = [sys.executable, "-c", WRITER]
    both = [subprocess.Popen([*command, str(seed)], env=environment, stderr=subprocess.PIPE) for seed in range(2)]
    assert [(x.communicate()[1], x.returncode) for x in both] == [(b"", 0)] * 2
    prune_cache(200_000)
    assert 0 < held() <= 200_000
    assert all(x.name.endswith(".o") for x in kept())


def test_a_cache_folder_in_use_is_not_evicted(folder: Path) -> None:
    """As that of a unit of FMI, whose files are read while it runs."""
    folder.mkdir(mode=0o700)
    code = f"""
from heavylift.kernel.cache import kept_folder
print(kept_folder({UNIT!r}, lambda fresh: (fresh / "unit.so").write_bytes(b"code")), flush=True)
input()
"""
    with subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as user:
        assert user.stdout is not None
        assert user.stdout.readline().decode().strip() == str(folder / UNIT)
        assert prune_cache(0) == 0
        assert (folder / UNIT / "unit.so").read_bytes() == b"code"
        user.communicate(b"\n")
    assert prune_cache(0) == BLOCK
    assert not [*folder.iterdir()]


def test_a_failed_cache_write_leaves_no_file(folder: Path) -> None:
    folder.mkdir(mode=0o700)

    def broken(fresh: Path) -> None:
        (fresh / "half").write_bytes(b"")
        raise ValueError("no unit")

    with pytest.raises(ValueError, match="no unit"):
        kept_folder(UNIT, broken)
    assert not [*folder.iterdir()]


@pytest.mark.parametrize("given", ["much", "-1", "nan", "inf", "512 MB"])
def test_an_invalid_cache_size_limit_is_reported_in_one_sentence(
    folder: Path, monkeypatch: pytest.MonkeyPatch, given: str
) -> None:
    monkeypatch.setenv("HEAVYLIFT_CACHE_MB", given)
    for use in (lambda: read_cached("x"), lambda: write_cached("x", b""), _cache):
        with pytest.raises(
            OutputError, match=rf"HEAVYLIFT_CACHE_MB='{given}' is not a valid size; give megabytes, such as 512"
        ):
            use()


def test_the_command_doctor_reports_the_size_of_the_cache(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HEAVYLIFT_CACHE_MB", "20")
    write_cached(name(1), bytes(1_500_000))
    assert _cache().message.endswith("; 1 files, 1.5 MB of at most 20 MB (HEAVYLIFT_CACHE_MB)")
