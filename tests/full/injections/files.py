"""Faults of recordings: changed while written, or cut at any byte as by a power failure."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from .trial import RESUMED, SAME, SENTENCE, Kind, NotAsPromised, Trial
from .workloads import undisturbed

TOLD = "was (deleted or renamed|replaced|cut|written to)"  # while it was written
ENDS = {"start": (0.2, 0.4), "run": (0.4, 0.9), "exit": (0.9, 1.0)}  # the scene is in what is left


def _replaced(part: Path) -> None:
    part.with_name("other").write_bytes(part.read_bytes())
    part.with_name("other").replace(part)


def _linked(part: Path) -> None:
    part.rename(part.with_name("away"))
    part.symlink_to("away")


def _overwritten(part: Path) -> None:
    with part.open("r+b") as file:
        file.seek(50)
        file.write(b"other bytes")


def _longer(part: Path) -> None:
    with part.open("ab") as file:
        file.write(b"more")


HARM: dict[str, Callable[[Path], object]] = {
    "deleted": lambda part: part.unlink(),
    "renamed": lambda part: part.rename(part.with_name("away")),
    "replaced": _replaced,
    "linked": _linked,
    "cut": lambda part: os.truncate(part, part.stat().st_size // 2),
    "emptied": lambda part: os.truncate(part, 0),
    "appended to": _longer,
    "overwritten": _overwritten,
}
HARMLESS: dict[str, Callable[[Path], object]] = {
    "touched": lambda part: os.utime(part, ns=(1, 1)),
    "read": lambda part: part.read_bytes(),
    "for its owner to read only": lambda part: part.chmod(0o400),
    "linked a second time": lambda part: os.link(part, part.with_name("backup")),
}


def _while_written(do: Callable[[Path], object], harmful: bool) -> Callable[[Trial], None]:
    def happens(trial: Trial) -> None:
        process = trial.start()
        part = trial.begun(trial.random.uniform(0.0, 0.7), process)
        trial.struck = part is not None
        if part is not None:
            do(part)
        ended = trial.end(process)
        trial.sentence(ended, TOLD) if harmful and trial.struck else trial.same(ended)

    return happens


def taken(trial: Trial) -> None:
    """Somebody else writes a file of the recording's name meanwhile."""
    process = trial.start()
    trial.struck = trial.begun(trial.random.uniform(0.0, 0.7), process) is not None
    if trial.struck:
        trial.output.write_bytes(b"precious")
    ended = trial.end(process)
    if not trial.struck:
        return trial.same(ended)
    if trial.output.read_bytes() != b"precious":
        raise NotAsPromised("it was overwritten")
    trial.same(ended, trial.output.with_name("run-2.mcap"))


def _ends(spoil: Callable[[bytes, Trial], bytes]) -> Callable[[Trial], None]:
    """What a failure of power leaves of a recording, and `resume`."""

    def spoiled(trial: Trial) -> None:
        low, high = ENDS[trial.case.moment]
        whole = undisturbed(trial.case.workload)[1]
        data = spoil(whole[: int(trial.random.uniform(low, high) * len(whole))], trial)
        trial.output.with_name("run.mcap.part").write_bytes(data)
        trial.resumed()

    return spoiled


ENDINGS: dict[str, Callable[[bytes, Trial], bytes]] = {
    "cut": lambda data, trial: data,
    "cut, then zeros": lambda data, trial: data + bytes(trial.random.randint(1, 9000)),
    "cut, then noise": lambda data, trial: data + trial.random.randbytes(trial.random.randint(1, 9000)),
}
RUNS = ("paced", "network")
KINDS = [
    *(Kind(f"recording: {name}", SENTENCE, _while_written(do, True), ("run",), RUNS) for name, do in HARM.items()),
    *(Kind(f"recording: {name}", SAME, _while_written(do, False), ("run",), RUNS) for name, do in HARMLESS.items()),
    Kind("recording: its name is taken", f"that file stays; {SAME}", taken, ("run",), RUNS),
    *(
        Kind(f"recording: {name}", RESUMED, _ends(do), tuple(ENDS), ("lift", "alone", "paced"))
        for name, do in ENDINGS.items()
    ),
]
