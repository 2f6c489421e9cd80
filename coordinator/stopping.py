"""Stopping a command: by a signal, or because the reader of its output has gone.

SIGINT (Ctrl-C), SIGTERM, SIGHUP and SIGQUIT raise `Interrupted` in the main thread, and the run ends in order. Python
prints and discards exceptions raised in `__del__` or in callbacks of the garbage collector, weak references or foreign
code; a timer that finds the exception object gone before the `end` raises it again. Further signals have no effect
meanwhile, and a signal that was ignored when the command began (`nohup`, a shell's `&`) stays ignored. Work that must
not be interrupted is done under `whole`.

All output of a command goes through this module, which escapes control characters and changes of writing direction;
only code that draws on a terminal, and has checked its texts, writes to `drawn`. If the reader closes standard output
(`| head`), the command ends with 141, as by SIGPIPE; a closed standard error is ignored.
"""

from __future__ import annotations

import io
import os
import signal
import sys
import threading
import weakref
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any, TextIO

STOPPED, UNHEARD = 130, 141  # exit codes: Ctrl-C; nobody reads

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
MAIN = threading.main_thread().ident  # the only one that signals reach
PAST = ("buffer", "detach", "reconfigure")  # of a stream, by which text would pass unseen
POLL_s = 0.05  # between two looks for an exception that was lost


class Interrupted(KeyboardInterrupt):
    """A signal has requested the end of the command."""


class ReaderLeft(BaseException):
    """Raised after the program that reads standard output, such as `head`, has closed the pipe; not an error of the
    command."""


class Stopping:
    """Handles signals during a command: a signal ends the work of the main thread with Interrupted."""

    def __init__(self) -> None:
        self._over = self._stopped = False
        self._signal = signal.SIGINT
        self._raised: Callable[[], object] = lambda: None
        taken = [number for number in SIGNALS if signal.getsignal(number) != signal.SIG_IGN]
        self._before = {number: signal.signal(number, self._asked) for number in taken}
        self._before[signal.SIGALRM] = signal.signal(signal.SIGALRM, self._look)
        self._unraisable, sys.unraisablehook = sys.unraisablehook, self._lost

    def end(self, process: bool = False) -> None:
        """Restore the signal handlers after the command; with `process`, ignore signals until the process has ended."""
        self._over = True
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        sys.unraisablehook = self._unraisable
        for number, before in self._before.items():
            signal.signal(number, signal.SIG_IGN if process and self._stopped else before)
        if process:  # atexit comes too late: Python waits for threads before
            threading._register_atexit(_ignored, tuple(self._before))  # type: ignore[attr-defined]
        self._before = {}

    @property
    def code(self) -> int:
        """Exit code of a command that a signal has ended, by the convention of shells."""
        return 128 + self._signal

    def _asked(self, number: int, frame: FrameType | None) -> None:
        self._signal, self._stopped = signal.Signals(number), True
        signal.setitimer(signal.ITIMER_REAL, POLL_s, POLL_s)
        self._look()

    def _look(self, *signalled: object) -> None:
        """Raise Interrupted, unless an earlier one is still being handled."""
        if self._over or self._raised() is not None:
            return
        if whole.depth:
            whole.asked = self
            return
        error = Interrupted(self._signal.name)
        self._raised = weakref.ref(error)
        try:
            raise error
        finally:
            del error  # whom only this frame holds would never be lost

    def _lost(self, what: sys.UnraisableHookArgs) -> None:
        """Suppress the message of an Interrupted that was raised where Python discards it; a timer raises the exception
        again."""
        if what.exc_type is not Interrupted:
            self._unraisable(what)


def _ignored(numbers: Iterable[int]) -> None:
    for number in numbers:
        signal.signal(number, signal.SIG_IGN)


class whole:
    """Context for work that must not be interrupted: signals that arrive are raised when the work ends."""

    depth = 0
    asked: Stopping | None = None

    def __enter__(self) -> None:
        self._counts = threading.get_ident() == MAIN
        whole.depth += self._counts

    def __exit__(self, kind: object, *error: object) -> None:
        whole.depth -= self._counts
        if whole.asked is not None and kind is None and self._counts and not whole.depth:
            asked, whole.asked = whole.asked, None
            asked._look()


def open_streams() -> None:
    """Replace closed standard streams by /dev/null, and let output streams escape characters that they cannot
    encode."""
    for fd, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(fd)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # gets the lowest number that is free
            if getattr(sys, name) is None:
                setattr(sys, name, open(fd, "w" if fd else "r", encoding="utf-8", closefd=False))  # noqa: SIM115 - lives as long
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors="backslashreplace")


@contextmanager
def heard() -> Iterator[None]:
    """Context for output pipes whose reader may close them: standard output then raises ReaderLeft; standard error
    ignores it."""
    out, err = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = out and _Heard(out, True), err and _Heard(err, False)
    try:
        yield
        if out is not None:
            sys.stdout.flush()
    finally:
        sys.stdout, sys.stderr = out, err


def displayed(text: str) -> str:
    """Return text of any origin in a form that is safe to print on a terminal."""
    if text.replace("\n", "").isprintable():
        return text
    from heavylift.kernel.errors import SPACES, printable  # takes long, and is hardly ever needed

    return printable(text, keep=f"\n{SPACES}")


class _Heard:
    """A stream that handles the loss of its reader (closed pipe or terminal)."""

    def __init__(self, stream: TextIO, tells: bool, raw: bool = False) -> None:
        self._stream, self._tells, self._raw = stream, tells, raw

    @property
    def drawn(self) -> _Heard:
        """This stream without the escaping of control characters, for code that draws on the terminal."""
        return _Heard(self._stream, self._tells, raw=True)

    def write(self, text: str) -> int:
        try:
            self._stream.write(text if self._raw else displayed(text))
        except OSError as error:
            self._left(error)
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        for line in lines:
            self.write(line)

    def flush(self) -> None:
        try:
            self._stream.flush()
        except OSError as error:
            self._left(error)

    def _left(self, error: OSError) -> None:
        if self._tells and not isinstance(error, BrokenPipeError):
            raise error
        with suppress(OSError):  # nobody stumbles over the rest, Python at its end neither
            os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())
        if self._tells:
            raise ReaderLeft

    def __getattr__(self, name: str) -> Any:
        if name in PAST:
            raise AttributeError(name)
        return getattr(self._stream, name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._stream)
