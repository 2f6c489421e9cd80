"""Choice of the name of an output: no existing file is lost.

    no file of this name            the name is used
    an earlier output               is kept; the next free name is used: run-2.mcap; with --force it is replaced
    anything else                   OutputError: a folder, a link, a device, a pipe, a file that heavylift has not made

The remains of a run that was cut off, `run.mcap.part` and the journal of orders beside it, are kept even with
--force as long as the run can be resumed or recovered: OutputError.
"""

import os
import stat
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import count
from pathlib import Path

from heavylift.kernel.errors import OutputError, RecordingError
from heavylift.recordings.format.mcapfile import MAGIC
from heavylift.recordings.format.text import GENERATOR

PART, COMMANDS = ".part", ".commands"  # of a run that is being written
CHECK_s = 4096  # [bytes] at the beginning and at the end in which it does
SIGNS = (GENERATOR.encode(), b"time [s],", b"rung,method,", b"RosOut!log")  # first columns of tables, panel of a layout
METADATA = 12  # opcode of the record in which a recording says what was run
HEADER = len(MAGIC) + 9 + 4 + 4  # where the name of the writer begins in a recording: magic, record, profile, length
KINDS = (
    (stat.S_ISLNK, "a link"),
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (lambda mode: not stat.S_ISREG(mode), "a device"),
)


def file_path(path: object) -> Path:
    """Return the path for a file name that is given as text or as a Path; raises RecordingError for anything else."""
    named = os.fspath(path) if isinstance(path, str | os.PathLike) else b""
    if isinstance(named, bytes) or "\0" in named:
        raise RecordingError(f"{path!r} is not a file name; give a path as text or as a Path, such as 'run.mcap'")
    return Path(named)


def unnamable(path: Path) -> str:
    """Return why the operating system refuses this file name with the endings that a run adds; "" if it does not."""
    try:
        _mode(path.with_name(path.name + COMMANDS))
    except OSError as error:
        return error.strerror or type(error).__name__
    return ""


def output_path(path: str | Path, what: str = "", endings: Sequence[str] = ()) -> Path:
    """Return the path if it is free or holds an earlier output; raises OutputError if another file exists there.

    Also if the suffix is not allowed; raises RecordingError if the folder is missing.
    """
    path = file_path(path)
    with writing(path):
        _refuse(path)
        if not path.parent.is_dir():
            raise RecordingError(
                f"{path}: the folder {path.parent} does not exist; create it or choose another folder with -o"
            )
        if endings and path.suffix.lower() not in endings:
            allowed = f"{', '.join(endings[:-1])} or {endings[-1]}" if len(endings) > 1 else endings[0]
            raise OutputError(f"{path}: the file name of {what} must end in {allowed}; choose such a name")
        if path.suffix.lower() == ".mcap":
            for ending in (PART, COMMANDS):
                _refuse(path.with_name(path.name + ending))
    return path


def names(path: Path) -> Iterator[Path]:
    """Yield the path run.mcap, then run-2.mcap, run-3.mcap and so on."""
    yield path
    for number in count(2):
        yield path.with_name(f"{path.stem}-{number}{path.suffix}")


def remains(path: Path) -> list[Path]:
    """Return the existing files of an output with this path: the output itself and its temporary files."""
    every = [path, *(path.with_name(path.name + ending) for ending in (PART, COMMANDS))]
    return [x for x in every if _mode(x) is not None]


def left_by_a_run(part: Path) -> bool:
    """Return whether an incomplete file contains the beginning of a run, which can be resumed or recovered."""
    with part.open("rb") as file:
        file.seek(len(MAGIC))
        for wanted in (1, METADATA):  # header, and what was run
            head = file.read(9)
            if len(head) < 9 or head[0] != wanted:
                return False
            file.seek(int.from_bytes(head[1:], "little"), 1)
        return file.tell() <= os.fstat(file.fileno()).st_size


def beside(path: Path, ending: str) -> Path:
    """Return the default name of a derived file: run.mcap and the ending -report.html give run-report.html."""
    return path.parent / f"{path.stem}{ending}"


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Return a context that converts errors of the operating system about this file into a RecordingError."""
    try:
        yield
    except OSError as error:
        raise RecordingError(
            f"{path}: the file cannot be written ({error.strerror}); choose another folder with -o"
        ) from None


def _refuse(path: Path) -> None:
    """Raise OutputError if something other than an earlier output exists there."""
    mode = _mode(path)
    if mode is None:
        return
    kind = next((kind for test, kind in KINDS if test(mode)), "")
    if kind == "a folder":
        raise OutputError(f"{path}: this is a folder; give the name of a file in it, such as {path / 'run.mcap'}")
    if not kind and not _made(path):
        kind = "a file that heavylift has not made"
    if kind:
        raise OutputError(f"{path}: this is {kind} and will not be overwritten; choose another name with -o")


def _mode(path: Path) -> int | None:
    """Return file type and rights without following a link; None if the file does not exist."""
    try:
        return os.lstat(path).st_mode
    except (FileNotFoundError, NotADirectoryError):
        return None


def _made(path: Path) -> bool:
    """Return whether a regular file was written by heavylift; a journal is recognised by its name."""
    if path.suffix == COMMANDS:
        return True
    try:
        with open(os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
            head = file.read(CHECK_s)
            file.seek(max(0, os.fstat(file.fileno()).st_size - CHECK_s))
            tail = file.read(CHECK_s)
    except OSError:
        return False
    if path.suffix == PART and not head:  # what a run leaves that is killed at once, where files must have names
        return True
    if path.suffix.lower() in (".mcap", PART):
        return head.startswith(MAGIC) and head[HEADER:].startswith(GENERATOR.encode())
    return any(sign in head + tail for sign in SIGNS)
