"""The exception tree of heavylift; every error that a user can cause is a one-sentence message of one of these classes.

    HeavyliftError
    |- SceneError       a scene file or its physics            file:line:column, or the scene key
    |- ModelError       a DEVS model broke the formalism       model path and (t, microstep)
    |- KernelError      equations, laws, integration           body, joint or rope, and simulation time
    |- ProtocolError    a message or process of a run          node, run and the offending message
    |- RecordingError   a recording or an output file          path and remedy
    |  |- SignalError   the recording has no such signal       also a KeyError; suggests similar names
    |  `- OutputError   the output cannot be written           existing files are kept; exit code 2
    `- Stopped          the user ended the run (Ctrl-C)        simulation time; the recording is finished

All other rooms import these classes and add none: `except HeavyliftError` catches every error that a user can cause.
"""

import errno
import os
from collections.abc import Iterable
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import msgspec

UNREADABLE = (msgspec.MsgspecError, UnicodeDecodeError, OverflowError, RecursionError, MemoryError)
"""Exceptions of msgspec for data from outside that are malformed or of a wrong type."""


def path_text(path: Path | str) -> str:
    """Return a path as printable text; bytes that are not UTF-8 are escaped."""
    return os.fsencode(path).decode(errors="backslashreplace")


SPACES = "".join(map(chr, [0x20, 0xA0, 0x1680, *range(0x2000, 0x200B), 0x202F, 0x205F, 0x3000]))
"""Unicode spaces of all widths; none is a control character."""


def printable(text: str, longest: int = 0, keep: str = "") -> str:
    """Return foreign text with control characters escaped, so that it cannot imitate lines that heavylift prints.

    Control characters, line ends and changes of writing direction become escapes, except those in `keep`; above U+001F
    the escapes are those of JSON, so that JSON stays JSON. `longest`: cut the text to this length (0: do not cut).
    """
    shown = text if text.isprintable() else "".join(c if c.isprintable() or c in keep else _escape(c) for c in text)
    return f"{shown[:longest]}..." if 0 < longest < len(shown) else shown


def _escape(c: str) -> str:
    if c < " ":
        return c.encode("unicode_escape").decode()
    units = c.encode("utf-16-be", "surrogatepass").hex()
    return "".join(f"\\u{units[i : i + 4]}" for i in range(0, len(units), 4))


def out_of_memory(error: BaseException | None) -> bool:
    """Return whether an error or its cause is a lack of memory, including errors raised in libraries and threads."""
    seen = set[int]()
    while error is not None and id(error) not in seen:  # who raises an error from itself makes a circle
        seen.add(id(error))
        refused = isinstance(error, ImportError | OSError) and "failed to map segment" in str(error)
        refused |= isinstance(error, RuntimeError) and "can't start new thread" in str(error)
        if refused or isinstance(error, MemoryError) or getattr(error, "errno", None) == errno.ENOMEM:
            return True
        error = error.__cause__ or error.__context__
    return False


class HeavyliftError(Exception):
    """An error with one sentence for the user: place, simulation time, what is wrong, what to do.

    `verdict`: the verdict on the part of a run that was recorded before the error ended it.
    """

    verdict: object = None


def closest(word: str, known: Iterable[str]) -> str:
    """Return `did you mean 'x'?` for the known word most similar to `word`; if none is, the list of known words."""
    from difflib import get_close_matches  # of those who err

    words = list(known)
    near = get_close_matches(word, words, 1) or get_close_matches(
        word.lower(), [w for w in words if w.lower() == word.lower()], 1
    )
    if near:
        return f"did you mean '{near[0]}'?"
    return f"known: {', '.join(words[:12])}{', ...' if len(words) > 12 else ''}" if words else ""


def error_text(error: BaseException, most: int = 500) -> str:
    """Return the text of any error as one line of printable characters, cut to `most` characters; never fails."""
    try:
        text = str(error)
        start = " ".join(text[: 2 * most].split())
        more = f" ... ({len(text)} characters)" if len(text) > 2 * most or len(start) > most else ""
        return printable(start[:most]) + more
    except (Exception, SystemExit):
        return "its text cannot be had"


def extra(package: str, missing: HeavyliftError) -> Any:
    """Import and return an optional package; raises `missing` if it is absent, a similar error if it is broken."""
    try:
        return import_module(package)
    except Exception as error:
        if isinstance(error, ModuleNotFoundError) and f"{package}.".startswith(f"{error.name}."):
            raise missing from None
        message = " ".join(str(error).split()) or type(error).__name__
        raise type(missing)(f"{package} is installed but fails ({message}); install another version of it") from None


class PlacedFault(NamedTuple):
    """A fault at a place in the files of a scene: sentence, hint, line and column from 1, and `path` of the key."""

    file: str
    line: int
    column: int
    path: str
    sentence: str
    hint: str = ""


class SceneError(HeavyliftError):
    """Raised for a scene that cannot be read or built; `faults`: all faults that have a place in its text."""

    faults: tuple[PlacedFault, ...] = ()


class ModelError(HeavyliftError):
    """Raised for a DEVS model that breaks a rule of the formalism."""


class KernelError(HeavyliftError):
    """Raised for mechanics that cannot be compiled or integrated."""


class ProtocolError(HeavyliftError):
    """Raised for a process or message that violates the protocol."""


class RecordingError(HeavyliftError):
    """Raised for a recording that cannot be read or written."""


class SignalError(RecordingError, KeyError):
    """Raised for a signal name that a recording does not contain."""

    __str__ = Exception.__str__  # not in quotes as that of a KeyError


class OutputError(RecordingError):
    """Raised if an output cannot be written because its name is unsuitable or another file has this name."""


class Stopped(HeavyliftError):
    """Raised when the user ends a run."""
