"""Rows of samples: the assignment of the columns of a kernel sample to topics, and the rounding of numbers in the file.

A sample is one float64 row; the layout is announced once and divides the row into channels. Batches are sent as msgpack
`[first number, [t_ns, ...], rows, notes, period, lift]`: `rows` are little-endian float64 in C order, or a single row
if all are equal; `notes` are sentences for people, `[number, t_ns, sentence]`; with a `period` [ns] these are predicted
samples, valid unless an event occurs, the last one repeated; `lift`: name of the single lift to which the rows belong,
which are numbered separately and have columns of their own. Channels `pose/<body>` (x y z, quaternion x y z w of the
body frame in the world) are written as foxglove.FrameTransforms; all others are fields of one `heavylift.Samples`
message per row (schema.py). Coordinates of free joints are omitted, as the poses of their bodies contain them.

Numbers are recorded in steps far below what any reader can need, as the last digits of a double are noise of the
integration, which cannot be compressed: a sample of exact doubles takes 1.9 kB, of rounded ones 1.1 kB. A step is a
binary fraction of the unit (4e-12 m, 2e-10 m/s, 6e-5 N, 6e-5 J, 1 us) or a billionth (for energies a millionth) of the
largest value of the column so far, whichever is finer; numbers in other units are not rounded. Digest and comparisons
use the rounded numbers, so any reader of the file can compute them again.
"""

import re
from collections.abc import Sequence
from itertools import chain, count
from typing import Annotated

import msgspec
import numpy as np
from heavylift.kernel.errors import UNREADABLE, RecordingError
from numpy.typing import NDArray

REEVING = "reeving/tension"  # of each part of a rope over sheaves, called rope.1, rope.2 ...
POSE = "pose/"
MEASURED, ERROR = "measured/", "error/"  # before the name of a signal: as measured, and the run's less that
POSE_COLUMNS = ("x", "y", "z", "qx", "qy", "qz", "qw")
SAMPLER = "kernel"  # who speaks in notes
POSE_UNIT = "m, quaternion x y z w"
_TURNING = re.compile(r"(angle|rate)\d*|w[xyz]")  # coordinates and velocities of joints that turn
_QUATERNION = re.compile(r"q[xyzw]")
_PAIRS = {"m or rad": ("m", "rad"), "m/s or rad/s": ("m/s", "rad/s"), POSE_UNIT: ("m", "1")}


class SamplerNote(msgspec.Struct, frozen=True, array_like=True):
    """A note for the user from the node that sends samples: number, simulation time [ns] and sentence."""

    number: int
    t_ns: int
    sentence: str


class _Wire(msgspec.Struct, frozen=True, array_like=True, forbid_unknown_fields=True):
    """A batch of samples in the form in which it is sent."""

    first: int
    times: list[int]
    rows: bytes
    notes: list[SamplerNote] = []
    period: Annotated[int, msgspec.Meta(ge=0)] = 0
    lift: str = ""


_decode_batch = msgspec.msgpack.Decoder(_Wire).decode


def reeved(part: str) -> str:
    """Return the name of the rope over sheaves to which a rope part belongs."""
    return part.rpartition(".")[0]


def unit_of(unit: str, column: str) -> str:
    """Return the unit of one column of a signal, such as m or rad for a signal whose unit is "m or rad"."""
    along, turning = _PAIRS.get(unit, (unit, unit))
    last = column.rpartition(".")[2]
    if along != turning and _QUATERNION.fullmatch(last):
        return "1"
    return turning if _TURNING.fullmatch(last) else along


class SampleChannel(msgspec.Struct, frozen=True):
    """The columns `start` to `stop` of a sample row: topic such as "rope/tension", column names, common unit."""

    topic: str
    names: list[str]
    unit: str
    start: int
    stop: int


class SampleLayout(msgspec.Struct, frozen=True):
    """Layout of sample rows: the channels to which their columns belong.

    `recalled`: number of leading rows that come from another recording; `most`: the largest value of each column in
    that recording; `lifts`: layouts of the rows of single lifts, which are written at events of the lift.
    """

    channels: list[SampleChannel]
    recalled: int = 0
    most: list[float] = []
    lifts: "dict[str, SampleLayout]" = {}

    @property
    def width(self) -> int:
        """Number of columns of a row."""
        return max((channel.stop for channel in self.channels), default=0)

    def find(self, topic: str) -> SampleChannel | None:
        """Return the channel with this topic; None if the row has none."""
        return next((channel for channel in self.channels if channel.topic == topic), None)

    def check(self) -> "SampleLayout":
        """Return the layout unchanged; raises RecordingError unless topics are unique and each column has a name."""
        topics: set[str] = set()
        for channel in self.channels:
            columns = channel.stop - channel.start
            if channel.start < 0 or columns != len(channel.names):
                raise RecordingError(
                    f"sample channel {channel.topic}: {len(channel.names)} names for the columns "
                    f"{channel.start} to {channel.stop}; give one name per column"
                )
            if channel.topic.startswith(POSE) and columns != len(POSE_COLUMNS):
                raise RecordingError(
                    f"sample channel {channel.topic}: a pose has 7 columns (x y z qx qy qz qw), not {columns}"
                )
            if channel.topic in topics:
                raise RecordingError(f"sample channel {channel.topic}: announced twice; name each topic once")
            topics.add(channel.topic)
        return self


class Batch(msgspec.Struct, frozen=True):
    """Consecutive samples: number of the first sample, simulation times [ns], rows (n, width), and notes.

    `period` [ns]: 0 for actual samples, otherwise these are predicted samples with this period, valid unless an event
    occurs. `lift`: the single lift to which they belong; "" for samples of all lifts.
    """

    first: int
    times: list[int]
    rows: NDArray[np.float64]
    notes: list[SamplerNote] = []
    period: int = 0
    lift: str = ""


def decode_batch(payload: bytes, layout: SampleLayout) -> Batch:
    """Decode a batch of samples; raises RecordingError unless it consists of complete rows."""
    try:
        wire = _decode_batch(payload)
    except UNREADABLE as error:
        raise RecordingError(f"a batch of samples cannot be decoded as [number, times, rows]: {error}") from None
    first, times, data = wire.first, wire.times, wire.rows
    if wire.lift and wire.lift not in layout.lifts:
        raise RecordingError(
            f"a batch has samples of lift '{wire.lift[:60]}', whose columns are unknown; record the run again"
        )
    width = (layout.lifts[wire.lift] if wire.lift else layout).width
    n = 1 if times and len(data) == 8 * width else len(times)
    if len(data) != 8 * width * n:
        raise RecordingError(
            f"samples from number {first}: {len(times)} rows of {width} values are {8 * width * len(times)} "
            f"bytes, but {len(data)} arrived; the sender's layout differs from the announced one"
        )
    rows = np.frombuffer(data, "<f8").reshape(n, width)
    return Batch(first, times, np.broadcast_to(rows, (len(times), width)), wire.notes, wire.period, wire.lift)


class Field(msgspec.Struct, frozen=True):
    """Place of a signal in the messages of `/samples`: its name, message field and unit, and names of its columns."""

    signal: str
    field: str
    unit: str
    columns: list[str]


def sample_fields(channels: Sequence[SampleChannel]) -> list[Field]:
    """Return the message fields for these channels, such as the field rope_peak_time for the channel
    `rope/peak_time`."""
    fields: list[Field] = []
    taken: set[str] = set()
    for channel in channels:
        stem = re.sub(r"\W", "_", channel.topic, flags=re.ASCII)
        stem = stem if stem[:1].isalpha() else f"x{stem}"
        names = chain([stem], (f"{stem}_{i}" for i in count(2)))
        name = next(name for name in names if name.replace("_", "").lower() not in taken)
        taken.add(name.replace("_", "").lower())  # protobuf's JSON names must differ, too
        fields.append(Field(channel.topic, name, channel.unit, list(channel.names)))
    return fields


def thinned(columns: Sequence[NDArray[np.float64]], rows: int) -> NDArray[np.intp]:
    """Return indices of at most `rows` rows: the first, the last, and those of minima and maxima of these columns."""
    n = len(columns[0])
    if n <= rows or rows < 4:
        return np.arange(n)
    parts = np.array_split(np.arange(n), max(1, (rows - 2) // (2 * len(columns))))
    return np.unique([0, n - 1, *(k[f(y[k])] for k in parts for y in columns for f in (np.argmin, np.argmax))])


LENGTH, ROTATION, SPEED = (38, 30), (42, 0), (32, 30)
# by unit: a step is 2^-first of it or 2^-second of the largest value
STEPS = {"m": LENGTH, "rad": LENGTH, "m or rad": LENGTH, "m/s": SPEED, "rad/s": SPEED, "m/s or rad/s": SPEED}
STEPS |= {"N": (14, 30), "N m": (14, 30), "J": (14, 20), "s": (20, 0)}
NOTHING = -40  # power of two of what is no value


class Columns:
    """The columns of sample rows that a recording stores: numbers of `fields`, then seven columns per body."""

    def __init__(self, layout: SampleLayout) -> None:
        poses = [channel for channel in layout.channels if channel.topic.startswith(POSE)]
        kept = [_picked(channel) for channel in layout.channels if not channel.topic.startswith(POSE)]
        every = [*kept, *((channel, [*range(channel.start, channel.stop)]) for channel in poses)]
        self.fields: list[Field] = sample_fields([channel for channel, _ in kept])
        self.bodies = [channel.topic.removeprefix(POSE) for channel in poses]
        self.signals: dict[str, slice] = {}  # of a recorded row, by name
        at = 0
        for channel, columns in every:
            self.signals[channel.topic] = slice(at, at := at + len(columns))
        self.numbers = at - 7 * len(poses)
        self._columns = np.array([i for _, columns in every for i in columns], np.intp)
        most = [layout.most[i] for i in self._columns] if layout.recalled else []
        self._rounded = Rounding([channel for channel, _ in every], layout.recalled, most)

    def __len__(self) -> int:
        return len(self._columns)

    def spread(self, recorded: NDArray[np.float64], width: int) -> NDArray[np.float64]:
        """Return full rows (n, width) that contain the recorded columns; all other columns are 0."""
        rows = np.zeros((len(recorded), width))
        rows[:, self._columns] = recorded
        return rows

    def __call__(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the recorded columns, rounded, for consecutive rows (n, width)."""
        return self._rounded(rows[:, self._columns])


def _picked(channel: SampleChannel) -> tuple[SampleChannel, list[int]]:
    """Return the channel without coordinates of free joints, and the indices of the columns that it keeps."""
    parts, names = [name.rpartition(".") for name in channel.names], {*channel.names}
    free = {joint for joint, _, _ in parts if all(f"{joint}.{x}" in names for x in POSE_COLUMNS)}
    if channel.topic != "joint/position":
        free = set()
    kept = [i for i, (joint, _, x) in enumerate(parts) if joint not in free or x not in POSE_COLUMNS]
    some = [channel.names[i] for i in kept]
    return SampleChannel(channel.topic, some, channel.unit, 0, len(kept)), [channel.start + i for i in kept]


class Rounding:
    """Rounds the columns of given sample channels; must receive all rows of a run in their order."""

    def __init__(self, channels: list[SampleChannel], recalled: int = 0, most: Sequence[float] = ()) -> None:
        """Prepare the rounding; the first `recalled` rows are rounded already, and `most` are the largest values of
        their columns."""
        steps: list[tuple[int, int] | None] = []
        for channel in channels:
            pose = channel.topic.startswith(POSE)
            steps += 3 * [LENGTH] + 4 * [ROTATION] if pose else len(channel.names) * [STEPS.get(channel.unit)]
        self._exact = np.array([step is None for step in steps], bool)
        powers = np.array([step or (0, 0) for step in steps], np.intp).reshape(-1, 2)
        self._finest, self._digits = powers.T  # powers of two: of the unit, of the largest value
        self._recalled = recalled
        self._largest = np.full(len(steps), NOTHING, np.int32)  # its power of two
        if recalled:
            self._largest = _powers(np.asarray(most, np.float64))
        self._scale = self._scaled(self._largest)

    def _scaled(self, largest: NDArray[np.int32]) -> NDArray[np.float64]:
        """Return the rounding step of each column in its unit, given the exponents of two of the largest values."""
        scale: NDArray[np.float64] = np.ldexp(1.0, np.maximum(self._finest, self._digits - largest))
        return scale

    def __call__(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the rows (n, columns) rounded; negative zeros become positive."""
        if self._recalled:
            known, rows = np.split(rows, [self._recalled])
            self._recalled -= len(known)
            return np.concatenate([known, self(rows)]) if len(rows) else known
        sizes = np.where(np.isfinite(rows), np.abs(rows), 0.0)
        top = np.maximum(self._largest, _powers(sizes.max(axis=0, initial=0.0)))
        scale = self._scaled(top)
        if np.array_equal(scale, self._scale):
            self._largest = top
        else:  # it is the rows before that count, however they are cut into batches
            largest = np.maximum.accumulate(np.vstack([self._largest, _powers(sizes)]))[1:]
            scale = self._scaled(largest)
            self._largest, self._scale = largest[-1], scale[-1]
        with np.errstate(over="ignore", invalid="ignore"):
            out: NDArray[np.float64] = np.rint(rows * scale) / scale + 0.0
        np.copyto(out, rows, where=self._exact | ~np.isfinite(out))
        return out


def _powers(sizes: NDArray[np.float64]) -> NDArray[np.int32]:
    """Return the exponent of the smallest power of two above each value."""
    return np.where(sizes > 0.0, np.maximum(np.frexp(sizes)[1], NOTHING), NOTHING)
