"""How far a run is off the measurement: E = S - D of each channel, and the uncertainty u_val of that difference.

ASME V&V 20-2009: u_val^2 = u_num^2 + u_input^2 + u_D^2, standard uncertainties.  Where |E| is well above u_val, E is
the error of the model; where it is within, model and measurement cannot be told apart.  u_num: what the run's tolerance
promises of its tensions, or its certificate tells, and straight lines between its samples; u_input: of runs with inputs
one standard uncertainty more and less; u_D: what the map states of the sensor, and the log's time.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from heavylift.nodes.plan.plan import TOLERANCE_OF_ACCURACY
from heavylift.recordings import Recording, Signal
from heavylift.recordings.format.samples import ERROR, MEASURED
from heavylift.recordings.render.curves import larger
from numpy.typing import NDArray

from .alignment import Alignment, Curve, overlapping
from .mapping import LogChannel, LogSignals

LEVEL = 2.0  # standard uncertainties of a level of 95 %
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class ChannelComparison:
    """A channel over the overlap: mean, RMS and largest E and when [s]; u_val and its parts, root mean squares of
    standard uncertainties; share of the rows with |E| <= 2 u_val; `lacks`: what nobody has stated."""

    channel: str
    unit: str
    mean: float
    rms: float
    largest: float
    when: float
    u_val: float
    u_num: float
    u_input: float
    u_D: float
    within: float
    lacks: tuple[str, ...]

    def __str__(self) -> str:
        factor, unit = larger(self.unit)
        mean, rms, most = (f"{factor * x:.3g}" for x in (self.mean, self.rms, self.largest))
        val, num, given, D = (f"{factor * LEVEL * x:.2g}" for x in (self.u_val, self.u_num, self.u_input, self.u_D))
        off = f"E {mean} +- {val} {unit} in the mean, RMS {rms}, {most} at {self.when:.2f} s"
        lacks = (
            f"; u_val lacks the uncertainty of {' and '.join(self.lacks)}, which is not stated" if self.lacks else ""
        )
        return (
            f"{self.channel}: {off}; u_val of num {num}, input {given}, D {D}; {100 * self.within:.0f} % within{lacks}"
        )


def curves_of(rec: Recording, channels: Sequence[LogChannel]) -> list[Curve]:
    """The run's own of some channels."""
    rec.load([*dict.fromkeys(channel.signal for channel in channels)])
    return [(rec.signal(channel.signal).t, rec.signal(channel.signal)[channel.column]) for channel in channels]


def compared(
    rec: Recording, log: LogSignals, at: Alignment, u_input: Sequence[Floats]
) -> tuple[list[ChannelComparison], list[Floats]]:
    """Comparison of each channel that the run has too, and its E (n,) at the rows that overlap.

    `u_input`: by channel, at the samples of the run; none where no input's uncertainty is stated.
    """
    out, errors = list[ChannelComparison](), list[Floats]()
    for k, (channel, (T, S)) in enumerate(zip(log.compared, curves_of(rec, log.compared), strict=True)):
        rows = overlapping((T, S), log.t, at.offset)
        t = log.t[rows] + at.offset
        s = np.interp(t, T, S)
        error = s - channel.values[rows]
        num = np.full(len(t), np.hypot(accuracy(rec) * float(np.abs(S).max()) / LEVEL, _straight(S)))
        given = np.interp(t, T, u_input[k]) if u_input else np.zeros(len(t))
        sensor = np.hypot(channel.sigma[rows], np.gradient(s, t) * at.sigma)
        val = np.sqrt(num**2 + given**2 + sensor**2)
        most = int(np.argmax(np.abs(error)))
        lacks = ("the sensor",) * (not channel.stated) + ("inputs",) * (not u_input)
        out.append(ChannelComparison(
            channel.name, channel.unit, mean=float(error.mean()), rms=_rms(error), largest=float(error[most]),
            when=float(t[most]), u_val=_rms(val), u_num=_rms(num), u_input=_rms(given), u_D=_rms(sensor),
            within=float(np.mean(np.abs(error) <= LEVEL * val)), lacks=lacks,
        ))  # fmt: skip
        errors.append(error)
    return out, errors


def beside(log: LogSignals, at: Alignment, errors: list[Floats], rows: NDArray[np.bool_]) -> list[Signal]:
    """Measured signals, and E of those that the run has too, at times of the run."""
    t, found = log.t[rows] + at.offset, dict[str, list[tuple[str, str, Floats]]]()
    parts = [(MEASURED, channel, channel.values[rows]) for channel in log.channels]
    for kind, channel, values in [*parts, *((ERROR, c, e) for c, e in zip(log.compared, errors, strict=True))]:
        found.setdefault(kind + channel.signal, []).append((channel.column, channel.unit, values))
    return [
        Signal(t, np.column_stack([x for _, _, x in parts]), [name for name, _, _ in parts], parts[0][1], signal)
        for signal, parts in found.items()
    ]


def accuracy(rec: Recording) -> float:
    """Accuracy of tensions: by the certificate of the run, else what its tolerance serves; nothing is known of fixed
    steps."""
    bars = [bar for bar in rec.fact("certified", {}).get("bars", []) if bar["quantity"] == "rope tension"]
    if bars and all(bar["numerical"] is not None for bar in bars):
        return float(max(bar["numerical"] / abs(bar["value"]) for bar in bars))
    return 0.0 if "step" in rec.run else float(rec.run.get("tolerance", "0")) / TOLERANCE_OF_ACCURACY


def _straight(S: Floats) -> float:
    """RMS error of straight lines between samples: an eighth of the second differences."""
    return _rms(np.diff(S, 2)) / 8.0 if len(S) > 2 else 0.0


def _rms(x: Floats) -> float:
    return float(np.sqrt(np.mean(x * x)))
