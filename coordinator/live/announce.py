"""Announcement of a run to observers: `run.json` in its private directory, locked while it runs; an operator's orders.

Nobody but its owner may enter the directory. The lock distinguishes a run in progress from the leftovers of a killed
one. An order is a query on the run's control key. A command that waits for a paused run gets a reply at once, and
another with the commander's answer when the run continues; every other order has one reply.
"""

import fcntl
import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from io import FileIO
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import msgspec
import zenoh
from heavylift.coordinator.transport.frame import OPERATOR, key, places
from heavylift.coordinator.transport.session import guest_session
from heavylift.kernel.errors import UNREADABLE, ProtocolError, path_text
from heavylift.kernel.version import __version__, install
from heavylift.nodes.devs import NEVER

NAME = "run.json"


class Notice(msgspec.Struct, frozen=True):
    """Announcement of a run in its file `run.json`; `started`: system clock [s]."""

    run: str
    scene: str
    recording: str
    pid: int
    started: float
    units: dict[str, dict[str, str]] = {}  # of the fields of an event, by its type
    angles: tuple[str, ...] = ()  # actuators whose coordinate is an angle
    version: str = "0.1.0"  # of heavylift


class AnnouncedRun(NamedTuple):
    """A run in progress and its private directory."""

    notice: Notice
    directory: Path

    @property
    def lives(self) -> bool:
        """Whether the coordinator of the run is alive."""
        return _locked(self.directory / NAME)


@contextmanager
def announced(
    directory: Path, run: str, scene: str, recording: Path | None, units: Mapping[str, Mapping[str, str]],
    angles: tuple[str, ...],
) -> Iterator[None]:  # fmt: skip
    """Announce a run to other commands while this context is open, so that they can observe it and give it orders."""
    plain = {name: dict(fields) for name, fields in units.items()}
    given = path_text(recording.absolute()) if recording else ""
    notice = Notice(run, scene, given, os.getpid(), time.time(), plain, angles, __version__)
    fresh = directory / (NAME + ".new")
    with FileIO(fresh, "w", opener=lambda name, flags: os.open(name, flags, 0o600)) as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        file.write(msgspec.json.encode(notice))
        os.replace(fresh, directory / NAME)  # whole and locked from the first look on
        yield


def running() -> list[AnnouncedRun]:
    """Return all runs of this user in progress, oldest first."""
    found = []
    for path in {path.resolve() for place in places() for path in Path(place).glob(f"heavylift-*/{NAME}")}:
        try:
            if path.stat().st_uid == os.getuid() and _locked(path):
                found.append(AnnouncedRun(msgspec.json.decode(path.read_bytes(), type=Notice), path.parent))
        except (OSError, *UNREADABLE):  # it ends just now, or another version wrote it
            continue
    return sorted(found, key=lambda run: (run.notice.started, run.notice.run))


def find(which: str = "") -> AnnouncedRun:
    """Find a run in progress by its recording, its run id (or the beginning of the id) or its scene; "" finds the only
    one."""
    runs = running()
    if not which:
        if len(runs) == 1:
            return runs[0]
        message = (
            "several runs are in progress; name one by its recording or run id" if runs else "no run is in progress"
        )
        raise ProtocolError(f"{message}{_list(runs) if runs else '; start one with `heavylift run`'}")
    file = Path(which).absolute()
    by_file = [found for found in runs if _same(found.notice.recording, file)]
    by_name = [found for found in runs if found.notice.run.startswith(which) or found.notice.scene == which]
    named = by_file or by_name
    if len(named) == 1:
        return named[0]
    if named:
        raise ProtocolError(f"{which}: several runs have this name; name one by its recording or run id{_list(named)}")
    if file.is_file():
        raise ProtocolError(f"{which}: its run has ended; `heavylift info {which}` lists its contents")
    raise ProtocolError(
        f"{which}: no run has this name; {'in progress' if runs else 'none is in progress'}{_list(runs)}"
    )


def _same(recording: str, file: Path) -> bool:
    return recording in (path_text(file), path_text(file).removesuffix(".part"))


def _locked(path: Path) -> bool:
    try:
        file = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return False
    try:
        fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        return False
    except BlockingIOError:
        return True
    finally:
        os.close(file)


def _list(runs: list[AnnouncedRun]) -> str:
    lines = (f"\n    {found.notice.run}  {found.notice.recording or found.notice.scene}" for found in runs)
    return "".join([":", *lines]) if runs else ""


PATIENCE_s = 30.0  # for the last reply: a command waits for the time at which it can be given
STEP_s = 86400.0  # the same for a step, which takes as long as it takes


class RunOrder(msgspec.Struct, frozen=True, omit_defaults=True):
    """An order to a run in progress: pause, continue, step, stop, give a command, or change the rate.

    `wait`: while the run is paused, a command waits for its answer; otherwise the reply says when it will take effect.
    """

    do: Literal["pause", "continue", "stop", "step", "command", "rate"]
    by_ns: Annotated[int, msgspec.Meta(gt=0, le=NEVER)] | None = None  # [ns] of a step; None: to the next event
    text: str = ""
    factor: Annotated[float, msgspec.Meta(gt=0.0)] = 1.0
    wait: bool = False


class Reply(msgspec.Struct, frozen=True):
    """Reply to an order: whether it was carried out, a sentence, simulation time [ns], and whether this is the last
    reply."""

    done: bool
    said: str
    t_ns: int | None = None
    last: bool = True


def order(run: str | Path | AnnouncedRun, what: RunOrder) -> str:
    """Send an order to a run in progress and return the last reply; raises ProtocolError if the run refuses the
    order."""
    answer = ask(run, what)
    if not answer.done:
        raise ProtocolError(answer.said)
    return answer.said


def ask(
    run: str | Path | AnnouncedRun,
    what: RunOrder,
    patience: float = PATIENCE_s,
    hear: Callable[[str], None] | None = None,
) -> Reply:
    """Send an order to a run in progress and return the last reply; `hear` receives the earlier replies.

    Raises ProtocolError if the last reply takes longer than `patience` [s], or STEP_s for the order `step`.
    """
    found = run if isinstance(run, AnnouncedRun) else find(str(run))
    timeout, text = STEP_s if what.do == "step" else patience, ""
    with guest_session(found.directory, OPERATOR) as session:
        control = key(found.notice.run, "control")
        each = zenoh.ConsolidationMode.NONE  # not the latest reply alone
        for reply in session.get(control, payload=msgspec.msgpack.encode(what), timeout=timeout, consolidation=each):
            if reply.ok is None:
                continue
            try:
                answer = msgspec.msgpack.decode(reply.ok.payload.to_bytes(), type=Reply)
            except UNREADABLE:
                made = found.notice.version
                raise ProtocolError(
                    f"run {found.notice.run} is of heavylift {made} and uses a protocol that "
                    f"{__version__} cannot read; {install(made)} to give it orders"
                ) from None
            if answer.last:
                return answer
            text = answer.said
            if hear is not None:
                hear(text)
    if text:
        raise ProtocolError(f"{what.text}: no answer within {timeout:g} s: {text}")
    message = f"run {found.notice.run} has not answered within {timeout:g} s; it ended, or it hangs"
    late = ", or has not come so far: `heavylift watch` shows whether the commander answers" if what.text else ""
    raise ProtocolError(message + late)
