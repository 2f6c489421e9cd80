"""Faults of disks: no space, no rights, vanished folders, a corrupted cache, after parts of the bytes of a run."""

from __future__ import annotations

import os
import resource
import shutil
from collections.abc import Callable
from pathlib import Path

from .starting import limited, mounted, namespaces
from .trial import RESUMED, SAME, SENTENCE, Kind, Trial
from .workloads import COMMANDS, HEAVYLIFT, undisturbed

PAGE_bytes = 4096
SHARES = {"start": (0.0, 0.15), "run": (0.15, 0.9), "exit": (0.9, 1.05)}  # of the bytes of a whole recording
SCENE_bytes = 40_000  # within which the scene has reached a recording: before, there is nothing to resume
KEPT = f"{SENTENCE}; what was recorded is {RESUMED}"


def _room(trial: Trial) -> int:
    """Bytes up to a moment of the run."""
    low, high = SHARES[trial.case.moment]
    return PAGE_bytes * max(1, round(trial.random.uniform(low, high) * _whole(trial) / PAGE_bytes))


def _whole(trial: Trial) -> int:
    return len(undisturbed(trial.case.workload)[1])


def no_space(trial: Trial) -> None:
    small = trial.folder / "small"
    small.mkdir()
    command = [HEAVYLIFT, *COMMANDS[trial.case.workload], "-o", small / "run.mcap"]
    ended = trial.run(mounted(small, f"size={_room(trial)}", command, keep=trial.folder))
    trial.same_or_sentence(ended)
    trial.resumed(least_bytes=SCENE_bytes)


def quota(trial: Trial) -> None:
    trial.same_or_sentence(trial.run(preexec_fn=limited(resource.RLIMIT_FSIZE, _room(trial))))
    trial.resumed(least_bytes=SCENE_bytes)


def temporary_full(trial: Trial) -> None:
    room = PAGE_bytes * trial.random.randint(1, 60)
    trial.same_or_sentence(trial.run(mounted(trial.temporary, f"size={room}", trial.command)))
    trial.resumed(least_bytes=SCENE_bytes)


def temporary_read_only(trial: Trial) -> None:
    trial.same_or_sentence(trial.run(mounted(trial.temporary, "ro", trial.command)))


def read_only(trial: Trial) -> None:
    trial.output = trial.folder / "read only" / "run.mcap"
    trial.output.parent.mkdir()
    trial.sentence(trial.run(mounted(trial.output.parent, "ro", trial.command)), "run.mcap")


def few_names(trial: Trial) -> None:
    """A file system with room, but without room for names."""
    small = trial.folder / "small"
    small.mkdir()
    command = [HEAVYLIFT, *COMMANDS[trial.case.workload], "-o", small / "run.mcap"]
    names = trial.random.randint(1, 4)
    trial.same_or_sentence(trial.run(mounted(small, f"nr_inodes={names}", command, keep=trial.folder)))


def _meanwhile(do: Callable[[Path, Path], None]) -> Callable[[Trial], None]:
    """While it runs, something happens to the folder of the recording; the second path is another place."""

    def happens(trial: Trial) -> None:
        trial.output = trial.folder / "runs" / "run.mcap"
        trial.output.parent.mkdir()
        process = trial.start()
        trial.struck = trial.begun(_later(trial), process) is not None
        if trial.struck:
            do(trial.output.parent, trial.folder / "other")
        ended = trial.end(process)
        trial.same_or_sentence(ended)

    return happens


def _later(trial: Trial) -> float:
    return trial.random.uniform(0.0, {"start": 0.02, "run": 0.9, "exit": 1.3}[trial.case.moment])


def _replace(folder: Path, other: Path) -> None:
    folder.rename(other)
    folder.mkdir()


def full_device(trial: Trial) -> None:
    with open("/dev/full", "wb") as full:
        ended = trial.run(stdout=full)
    trial.sentence(ended, "standard output")
    trial.compare(trial.output)


def full_error(trial: Trial) -> None:
    with open("/dev/full", "wb") as full:
        trial.same(trial.run(stderr=full))


def _cache(spoil: Callable[[Path, Trial], None]) -> Callable[[Trial], None]:
    """A cache that was filled before, and is spoiled."""

    def spoiled(trial: Trial) -> None:
        cache = trial.folder / "cache"
        trial.environment["HEAVYLIFT_CACHE"] = str(cache)
        trial.run([HEAVYLIFT, "check", "lift"])
        spoil(cache, trial)
        trial.same(trial.run())

    return spoiled


def _damaged(cache: Path, trial: Trial) -> None:
    for path in cache.iterdir():
        data = bytearray(path.read_bytes())
        data[trial.random.randrange(len(data))] ^= 1 << trial.random.randrange(8)
        path.write_bytes(data)


def _cut(cache: Path, trial: Trial) -> None:
    for path in cache.iterdir():
        os.truncate(path, trial.random.randrange(path.stat().st_size))


def _folders(cache: Path, trial: Trial) -> None:
    for path in cache.iterdir():
        path.unlink()
        path.mkdir()


def _pipes(cache: Path, trial: Trial) -> None:
    for path in cache.iterdir():
        path.unlink()
        os.mkfifo(path)


def _file(cache: Path, trial: Trial) -> None:
    shutil.rmtree(cache)
    cache.write_text("no folder")


def _link(cache: Path, trial: Trial) -> None:
    cache.rename(cache.with_name("other"))
    cache.symlink_to("other")


def cache_without_room(trial: Trial) -> None:
    options = f"size={PAGE_bytes * trial.random.randint(1, 20)}" if trial.random.random() < 0.7 else "ro"
    cache = trial.folder / "cache"
    cache.mkdir(mode=0o700)
    trial.environment["HEAVYLIFT_CACHE"] = str(cache)
    trial.same(trial.run(mounted(cache, f"{options},mode=700", trial.command)))


RUNS = ("lift", "alone", "network")
MOUNTED = [
    Kind("disk: no space", KEPT, no_space, tuple(SHARES), RUNS),
    Kind("disk: no space for more names", f"{SAME}, or {SENTENCE}", few_names, ("start",), RUNS),
    Kind("disk: no space in TMPDIR", f"{SAME}, or {KEPT}", temporary_full, ("run",), RUNS),
    Kind("disk: TMPDIR is read-only", f"{SAME}, or {SENTENCE}", temporary_read_only, ("start",), RUNS),
    Kind("disk: read-only folder", SENTENCE, read_only, ("start",), RUNS),
    Kind("disk: no space in the cache", SAME, cache_without_room, ("compile",), ("lift", "alone")),
]
MEANWHILE: dict[str, Callable[[Path, Path], None]] = {
    "removed": lambda folder, other: shutil.rmtree(folder),
    "moved": lambda folder, other: Path(folder.rename(other)).touch(),
    "replaced by another": _replace,
}
CACHES: dict[str, Callable[[Path, Trial], None]] = {
    "damaged files": _damaged,
    "cut files": _cut,
    "folders for files": _folders,
    "pipes for files": _pipes,
    "a file": _file,
    "a link": _link,
    "for all to write": lambda cache, trial: cache.chmod(0o777),
    "empty": lambda cache, trial: shutil.rmtree(cache),
}
KINDS = [
    *(MOUNTED if namespaces() else []),
    Kind("disk: quota", KEPT, quota, tuple(SHARES), RUNS),
    *(
        Kind(f"disk: folder {name}", f"{SAME}, or {SENTENCE}", _meanwhile(do), tuple(SHARES), ("paced", "network"))
        for name, do in MEANWHILE.items()
    ),
    Kind("disk: standard output is full", f"{SENTENCE}; {SAME}", full_device, ("exit",), RUNS),
    Kind("disk: standard error is full", SAME, full_error, ("run",), RUNS),
    *(Kind(f"disk: cache, {name}", SAME, _cache(do), ("compile",), ("lift", "alone")) for name, do in CACHES.items()),
]
