"""All that a recording has about a part of the scene: a crane, a rope, the block, or what a pattern names.

`rec["west"].tension` are the tensions of all ropes named west.*; the last word of a signal's name is the attribute,
after `measured_` or `error_` where a log stands beside the run.  What hangs on a hook has its rope, too, since
its tension is what people ask for.
"""

from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, NoReturn, Protocol

from heavylift.kernel.errors import SignalError
from heavylift.recordings.format.samples import ERROR, MEASURED, POSE
from heavylift.recordings.format.schema import RecordedEvent
from heavylift.recordings.format.text import meant
from heavylift.recordings.sheets.page import table_html
from heavylift.recordings.sheets.sheet import words

from .signal import Signal, heading, joined, only

HANGING = "loaders"  # fact: machines that hang on a hook of another one, by its rope


class SignalSource(Protocol):
    """What parts need of their recording (`reader.Recording`)."""

    @property
    def path(self) -> Path: ...
    def signals(self) -> list[str]: ...
    def columns(self, name: str) -> list[str]: ...
    def signal(self, name: str) -> Signal: ...
    def load(self, names: Sequence[str]) -> None: ...
    def fact(self, name: str, default: Any = None) -> Any: ...
    def events(self, source: str | None = None) -> list[RecordedEvent]: ...


def chosen(rec: SignalSource, pattern: str) -> list[tuple[str, str]]:
    """(signal, column) pairs selected by `signal`, `signal/column` or a pattern such as "rope/tension/*"."""
    every = [(name, column) for name in rec.signals() for column in rec.columns(name)]
    return [(name, column) for name, column in every if name == pattern or fnmatchcase(f"{name}/{column}", pattern)]


class RecordedPart:
    """Signals by attribute: `part.tension`, `part.pose`; dir(part) and `part.signals` list them."""

    def __init__(self, rec: SignalSource, name: str, columns: dict[str, list[str]]) -> None:
        self._rec, self.name, self._columns = rec, name, columns
        self._words: dict[str, list[str]] = {}
        for signal in columns:
            word = "pose" if signal.startswith(POSE) else signal.rpartition("/")[2]
            word = f"{signal.partition('/')[0]}_{word}" if signal.startswith((MEASURED, ERROR)) else word
            self._words.setdefault(word, []).append(signal)

    @staticmethod
    def of(rec: SignalSource, name: str) -> "RecordedPart":
        """The part of this name; "legs/1" is legs-1."""
        names = (name, name.replace("/", "-"))
        carried = {rope for hung, rope in rec.fact(HANGING, {}).items() if hung in names}
        found: dict[str, list[str]] = {}
        parts: set[str] = set()
        for signal in rec.signals():
            if signal.startswith(POSE):
                owner = signal.removeprefix(POSE)
                columns = rec.columns(signal) if _in(owner, names) else []
                parts |= {owner, owner.partition(".")[0]}
            else:
                every = rec.columns(signal)
                rope = signal.startswith("rope/")
                columns = [c for c in every if rope and c in carried] + [c for c in every if _in(c, names)]
                parts |= {c for c in every} | {c.partition(".")[0] for c in every}
            if columns:
                found[signal] = columns
        if not found:
            near = meant(name, [*rec.signals(), *sorted(parts)])
            raise SignalError(f"{rec.path}: has no signal or part {name}; {near}")
        return RecordedPart(rec, name, found)

    @property
    def signals(self) -> list[str]:
        """Names of the signals with columns of this part."""
        return list(self._columns)

    @property
    def events(self) -> list[RecordedEvent]:
        """Events that the model of this name has sent."""
        return self._rec.events(source=self.name.replace("/", "-"))

    def __getattr__(self, word: str) -> Signal:
        if word.startswith("_") or word not in self._words:
            raise AttributeError(f"{self.name} has no {word}; {meant(word, list(self._words))}")
        names = self._words[word]
        self._rec.load(names)
        parts = [only(self._rec.signal(name), self._columns[name]) for name in names]
        if len(parts) == 1:
            return parts[0]
        if word == "pose":  # of several bodies
            parts = [Signal(s.t, s.values, [f"{s.name[len(POSE) :]}.{x}" for x in s.names], s.unit) for s in parts]
            return joined(f"{POSE}{self.name}.*", parts)
        return joined(f"*/{word}", parts)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._words]

    def _repr_html_(self) -> str:
        return heading(self.name) + table_html(words("", ["signal"], [[name] for name in self.signals]))

    def __repr__(self) -> str:
        return f"<{self.name}: {', '.join(self._words)}>"

    def __getstate__(self) -> NoReturn:
        raise TypeError("a part belongs to its recording; keep its signals instead")


def _in(column: str, names: tuple[str, ...]) -> bool:
    return any(column == name or column.startswith(f"{name}.") for name in names)
