"""Comparison of two recordings: whether everything that a run determines is equal, or else the first difference and the
deviations of signals.

Stored results are not trusted: digests are computed again, events compared in their total order, and rows one by one;
then facts and attachments, except the circumstances of a run, which are only reported. Signals are compared at the
times of the first recording, with linear interpolation between samples of the second one, over their common time span.
A difference is reported as its largest absolute value and its RMS over time.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format.samples import unit_of
from heavylift.recordings.read.export import matching
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.verdict import complaints, contents
from heavylift.recordings.sheets.sheet import listed
from numpy.typing import NDArray

from .curves import Curve, Figure, Panel, checked, drawn, larger
from .differences import ROWED, attachments, channels, circumstances, event, facts, notes, rows

MOST = 12  # panels of an overlay
ROWS = 24  # signals in the text


@dataclass(frozen=True)
class Difference:
    """Difference of one column between the recordings a and b.

    Largest |b - a| and its time [s], RMS of b - a over time, largest |a|, unit.
    """

    name: str
    most: float
    when: float
    rms: float
    scale: float
    unit: str


@dataclass(frozen=True)
class RecordingComparison:
    """Comparison of two recordings: first difference, and differences of signals, rows and facts."""

    a: Path
    b: Path
    equal: bool
    first: str  # difference in events and samples, "" if there is none
    differences: list[Difference]
    only_a: list[str]  # signals of one recording only
    only_b: list[str]
    rows: list[str] = field(default_factory=list)  # rows of one recording only
    others: list[str] = field(default_factory=list)  # other differences
    wrong: list[str] = field(default_factory=list)  # contradictions within a recording
    circumstances: list[str] = field(default_factory=list)  # differences in how the runs were computed
    as_recorded: str = ""  # why there is no digest

    def __str__(self) -> str:
        n = len(self.differences)
        lines = [f"run in other circumstances: {', '.join(self.circumstances)}"] if self.circumstances else []
        if self.equal:
            text = "same digest, computed again of both, and the same facts and attachments"
            if self.as_recorded:
                text = f"same events, rows, facts and attachments; the digest is as recorded ({self.as_recorded})"
            return "\n".join([f"{self.a} and {self.b} are equal: {text}, {n} signals", *lines])
        share = _shares(self.differences)
        rows = [
            [d.name, _number(d.most), f"{d.when:.3f} s", _number(d.rms), _percent(share[d.name]), d.unit]
            for d in sorted(self.differences, key=lambda d: -share[d.name])
            if d.most > 0.0
        ]
        head = ["signal", "largest", "at", "RMS", "of its signal", "unit"]
        parts = [f"{self.a} and {self.b} differ", *self.wrong]
        parts += [f"first difference: {self.first}" if self.first else "events and samples are equal"]
        parts += [*self.rows, listed(head, rows[:ROWS])]
        if len(rows) > ROWS:
            parts.append(f"  and {len(rows) - ROWS} signals that differ less; all with --json")
        same = sum(d.most == 0.0 for d in self.differences)
        where = " in the rows that both have" if self.rows else ""
        parts.append(f"{same} of {n} signals are equal{where}")
        parts += [
            f"only in {p}: {', '.join(names)}" for p, names in ((self.a, self.only_a), (self.b, self.only_b)) if names
        ]
        parts += [f"other {what}" for what in self.others]
        return "\n".join(part for part in [*parts, *lines] if part)


def _shares(differences: Sequence[Difference]) -> dict[str, float]:
    """Return the largest difference of each column relative to the largest value of its whole signal. Relative to its
    own values, a column that is zero except for rounding would have the largest difference."""
    scales: dict[str, float] = {}
    for d in differences:
        signal = d.name.rpartition("/")[0]
        scales[signal] = max(scales.get(signal, 0.0), d.scale)
    return {d.name: d.most / scales[d.name.rpartition("/")[0]] for d in differences}


def compare(a: str | Path, b: str | Path, but: Collection[str] = ()) -> RecordingComparison:
    """Compare two recordings; raises RecordingError if one of them cannot be read. `but`: names of facts, topics and
    attachments to ignore."""
    A, B = Recording(a), Recording(b)
    with A.reading(), B.reading():
        return _compared(A, B, but)


def _compared(A: Recording, B: Recording, but: Collection[str]) -> RecordingComparison:
    for rec in (A, B):
        rec.load(rec.signals())
    unlike, moved = list[str](), [*notes(A, B)]
    for topic in sorted({x for rec in (A, B) for x in rec.topics if x.startswith(ROWED) and x not in but}):
        missing, at = rows(A, B, topic)
        unlike += missing
        moved += at
    first = min([*moved, *event(A, B)], default=(0.0, ""))[1]
    names_a, names_b = set(A.signals()), set(B.signals())
    wrong = [what for rec in dict.fromkeys((A, B)) for what in complaints(rec)]
    others = [*channels(A, B, but), *facts(A, B, but), *attachments(A, B, but)]
    equal = not (first or unlike or others or wrong) and "digest" in A.result and "digest" in B.result
    if not (first or unlike or others or wrong or equal):
        first = "none in events and samples: the recordings tell of equal motions, but are not both complete"
    return RecordingComparison(
        A.path, B.path, equal=equal, first=first,
        differences=[d for name in A.signals() if name in names_b for d in _signal(A, B, name)],
        only_a=sorted(names_a - names_b), only_b=sorted(names_b - names_a), rows=unlike, others=others, wrong=wrong,
        circumstances=[*circumstances(A, B)], as_recorded=contents(A).unknown or contents(B).unknown,
    )  # fmt: skip


def overlay(a: str | Path, b: str | Path, out: str | Path, patterns: Sequence[str] = (), force: bool = False) -> Path:
    """Draw matching columns of two recordings into one figure; return its path.

    Default: the columns of the four signals that differ most.
    """
    out = checked(out)
    A, B = Recording(a), Recording(b)
    with A.reading(), B.reading():
        return drawn(_figure(A, B, patterns), out, force)


def _figure(A: Recording, B: Recording, patterns: Sequence[str]) -> Figure:
    common = [name for name in A.signals() if name in B.signals()]
    found = [d for name in common for d in _signal(A, B, name)]
    if patterns:
        wanted = {f"{name}/{column}" for name, column in matching(A, patterns)}
        found = [d for d in found if d.name in wanted]
    share = _shares(found)
    found.sort(key=lambda d: -share[d.name])
    first = {d.name.rpartition("/")[0]: d for d in reversed(found)}  # of each signal the worst column
    most = found if patterns else [d for d in found if d in first.values()][:4]
    if not most or len(most) > MOST:
        raise RecordingError(
            f"{A.path} and {B.path}: {len(most)} columns differ, too many for one figure; name 1 to {MOST} of them"
        )
    panels = []
    for d in most:
        factor, unit = larger(d.unit)
        name, _, column = d.name.rpartition("/")
        off = f"largest difference {d.most * factor:.4g} {unit} at {d.when:.3f} s, RMS {d.rms * factor:.4g} {unit}"
        parts = [(rec.signal(name), rec.path.name, rec is B) for rec in (A, B)]
        lines = [Curve(path, signal.t, signal[column] * factor, int(second), second) for signal, path, second in parts]
        panels.append(Panel(unit, lines, title=f"{d.name}: {off}"))
    return Figure(f"{A.path.name} and {B.path.name}", panels, A.stages())


def _signal(A: Recording, B: Recording, name: str) -> Iterator[Difference]:
    a, b = A.signal(name), B.signal(name)
    n = min(len(a.t), len(b.t))
    if not n:
        return
    row_by_row = np.array_equal(a.t[:n], b.t[:n])  # also where one of them ends before the other
    common = slice(n) if row_by_row else a.t <= b.t[-1]
    t = a.t[common]
    for i, column in enumerate(a.names):
        if column in b.names and len(t):
            x, y = a.values[common, i], b.values[:, b.names.index(column)]
            y_at = y[:n] if row_by_row else np.interp(t, b.t, y)
            off = np.where(np.isnan(x) & np.isnan(y_at), 0.0, np.nan_to_num(np.abs(y_at - x), nan=np.inf))
            k = int(np.argmax(off))
            scale = float(np.max(np.abs(x))) or float(np.max(np.abs(y))) or 1.0
            unit = unit_of(a.unit, column)
            yield Difference(f"{name}/{column}", float(off[k]), float(t[k]), _rms(t, off), scale, unit)


def _rms(t: NDArray[np.float64], x: NDArray[np.float64]) -> float:
    """Return the root mean square of x over time."""
    if len(t) < 2 or t[-1] == t[0]:
        return float(np.max(x))
    return float(np.sqrt(np.trapezoid(x * x, t) / (t[-1] - t[0])))


def _number(x: float) -> str:
    return f"{x:.4g}"


def _percent(share: float) -> str:
    """Return a share in per cent to two digits, without an exponent above 100 %."""
    return f"{100 * share:.0f} %" if share >= 0.1 else f"{100 * share:.2g} %"
