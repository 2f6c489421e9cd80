"""A run as a Python function: from a scene or a system to named arrays, in seconds and SI units.

    result = simulate("lift", keep=["rope/tension"])
    result.t, result["rope/tension"]["crane.H1"], result["rope/tension"].unit       # (n,) [s], (n,), "N"
    result.stages, result.peaks, result.events, result.verdict, result.to_pandas()
    result.at([1.0, 1.5])["rope/tension"]              # between samples, too

It writes no file and starts no process, thread or session, so any thread or pool may call it; a result can be pickled.
"""

from collections.abc import Callable, Sequence
from fnmatch import fnmatchcase
from operator import itemgetter
from pathlib import Path
from typing import Any, overload

import msgspec
import numpy as np
from heavylift.coordinator.ladder.choosing import chosen
from heavylift.coordinator.live.command_queue import TimedCommand
from heavylift.coordinator.participants.configuration import COMMAND, OPERATOR
from heavylift.coordinator.record.in_memory import Played, play
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.errors import KernelError, ModelError, SceneError, SignalError
from heavylift.kernel.islands import choice
from heavylift.kernel.islands.dense_output import DenseRows, check_same, trail_of
from heavylift.kernel.islands.islands import Islands
from heavylift.kernel.simulation.commands import CommandTarget
from heavylift.kernel.simulation.native.samples import channels, published
from heavylift.kernel.simulation.simulation import Simulation
from heavylift.nodes.devs import Tag, encode, seconds
from heavylift.nodes.models.parts.messages import OperatorAnswer, OperatorCommand
from heavylift.nodes.plan.places import located
from heavylift.nodes.scene import LoadedScene, loaded
from heavylift.nodes.scene.operator_command import spoken
from heavylift.nodes.scene.text.units import DURATION
from heavylift.recordings.format.schema import RecordedEvent
from heavylift.recordings.format.text import meant
from heavylift.recordings.read.signal import Signal
from heavylift.recordings.write.sink import Peak
from numpy.typing import NDArray

from .arguments import DENSEST, PERIOD, Order, patterns, time_s, timed
from .control import Control, steering
from .result import Course, Result, StageSpan

Command = Callable[[CommandTarget], object]  # what is done with the simulation

SAMPLES = 1000  # of a system that nobody asks for others
STOP = "stop"


@overload
def simulate(
    model: System,
    until: float,
    *,
    every: float | None = None,
    orders: Sequence[Order[Command]] = (),
    keep: Sequence[str] = ("*",),
    tolerance: float = 1e-7,
    method: str = "dopri5",
    step: float | None = None,
    control: Control | None = None,
    period: float | None = None,
) -> Result: ...


@overload
def simulate(
    model: LoadedScene | str | Path,
    until: float | None = None,
    *,
    every: float | None = None,
    orders: Sequence[Order[str]] = (),
    keep: Sequence[str] = ("*",),
) -> Result: ...


def simulate(
    model: System | LoadedScene | str | Path,
    until: float | None = None,
    *,
    every: float | None = None,
    orders: Sequence[Any] = (),
    keep: Sequence[str] = ("*",),
    **options: Any,
) -> Result:
    """Simulate a scene (object, path or name) to its end or to `until` [s], or a system of the kernel to `until` [s].

    Samples are taken every `every` [s]; default: as the scene says, for a system a thousandth of the run. `orders`:
    (time [s], order): for a scene in an operator's words, "crane H1: hoist 1 m/min by 1 m"; for a system a function of
    the simulation, `lambda s: s.set_brake("b", True)`. `keep`: names or patterns of signals in the result. `tolerance`,
    `method`, `step` [s]: for a system; a scene has its own. `control`: for a system, called every `period` [s] with the
    time [s] and a dict of all sampled values, such as "joint/position/rail.travel"; it returns values of the driven
    signals of forces, and speeds of drives and winches, which hold from a period later on. Raises HeavyliftError.
    """
    until = None if until is None else time_s("until", until, DURATION)
    every = None if every is None else time_s("every", every, PERIOD)
    keep = patterns(keep)
    if isinstance(model, System):
        calls: list[Order[Command]] = timed(orders, "a function of the simulation", callable)
        return _of_system(model, until, every, calls, keep, **options)
    if options:
        raise SceneError(
            f"{', '.join(options)}: these options are for systems; change a scene by "
            "its settings, such as load(scene, ['method=radau5'])"
        )
    words: list[Order[str]] = timed(orders, "an operator's words", lambda text: isinstance(text, str))
    return _of_scene(chosen(loaded(model)), until, every, words, keep)


def _of_scene(
    scene: LoadedScene, until: float | None, every: float | None, orders: Sequence[Order[str]], keep: Sequence[str]
) -> Result:
    changed = {**({"end": until} if until is not None else {}), **({"samples_hz": 1.0 / every} if every else {})}
    plan, given = msgspec.structs.replace(scene.plan, **changed) if changed else scene.plan, list[TimedCommand]()
    words: dict[int, str] = {}
    for t, text in orders:
        t_ns = max(seconds(t), max(words, default=-1) + 1)
        words[t_ns] = text
        order = b"" if text == STOP else msgspec.msgpack.encode(spoken(scene, text))
        given.append(TimedCommand(Tag(t_ns), encode(OperatorCommand(text, order))))
    run = play(plan, commands=given, errors=scene.errors)

    def again(instants: list[int]) -> dict[str, Signal]:
        repeated = play(plan, commands=given, instants=instants)
        check_same(repeated.digest, run.digest)
        return _signals(np.array(instants) / 1e9, repeated.dense, run.layout.channels, keep)

    for e in run.events:
        if isinstance(e.value, OperatorAnswer) and e.value.refused:
            message = located(plan, e.value.refused, e.value.at)
            raise ModelError(f"the order '{e.value.text}' at {e.value.t_ns * 1e-9:g} s is refused: {message}")
    heard = {e.t for e in run.events if (e.source, e.port) == (OPERATOR, COMMAND)}
    if late := [t_ns for t_ns in words if t_ns not in heard]:
        at = late[0]
        raise ModelError(f"the order '{words[at]}' at {at * 1e-9:g} s: too late, the run ends at {_end(run):g} s")
    return result_of(run, keep, again)


def result_of(
    run: Played, keep: Sequence[str] = ("*",), again: Callable[[list[int]], dict[str, Signal]] | None = None
) -> Result:
    """Return the result of a finished run of a scene; `again` computes signals at other times [ns] by repeating the
    run."""
    signals = _signals(run.t, run.rows, run.layout.channels, keep)
    return Result(run.t, signals, run.unfinished, lambda: _course(run), run, again)


def _course(run: Played) -> Course:
    stages = [(t, name) for t, _, name in run.conduct.stages]
    ends = [t for t, _ in stages[1:]] + [_end(run)]
    return Course(
        [StageSpan(name, t, end) for (t, name), end in zip(stages, ends, strict=True)] if stages else [],
        run.peaks,
        [
            RecordedEvent(e.t, e.k, e.source, e.port, e.index, e.type, msgspec.msgpack.decode(e.payload))
            for e in run.events
        ],
        [(t / 1e9, text) for t, text in run.notes],
    )


def _end(run: Played) -> float:
    return run.end_ns / 1e9


def _of_system(
    system: System,
    until: float | None,
    every: float | None,
    orders: Sequence[Order[Command]],
    keep: Sequence[str],
    tolerance: float = 1e-7,
    method: str = "dopri5",
    step: float | None = None,
    control: Control | None = None,
    period: float | None = None,
) -> Result:
    if until is None:
        raise KernelError("a system has no end of its own; give the end time `until` [s]")
    end, sample = seconds(until), seconds(every or max(until / SAMPLES, DENSEST))
    commands = [(seconds(t), order) for t, order in orders] + steering(control, period, end)
    commands.sort(key=itemgetter(0))

    def run(instants: Sequence[int] = ()) -> tuple[Simulation | Islands, DenseRows]:
        s = choice.simulate(system, tolerance, sample, frozenset(), method, step, apart=control is None)
        rows = DenseRows(s, instants)
        s.start()
        for t, order in commands:
            if t >= end:
                raise KernelError(f"an order at {t / 1e9:g} s: too late, the run ends at {until:g} s")
            s.interrupt(t)
            order(s)
            s.settle()
        s.interrupt(end)
        s.settle()
        return s, rows

    def again(instants: list[int]) -> dict[str, Signal]:
        s, rows = run(instants)
        check_same(trail_of(s.rows), trail)
        return _kept(_signals(np.array(instants) / 1e9, rows.finish(), channels(s.method), ("*",)), keep)

    s, _ = run()
    trail = trail_of(s.rows)
    rows = [row for row in s.rows if row[0] < end] + s.rows[-1:]
    times = np.array([t for t, _ in rows]) / 1e9
    signals = _signals(times, published(s.method, np.array([row for _, row in rows])), channels(s.method), ("*",))
    peaks = dict[str, Peak]()
    if "rope/peak" in signals:
        most, when = signals["rope/peak"], signals["rope/peak_time"]
        for i, (name, k) in enumerate(zip(most.names, most.values.argmax(axis=0), strict=True)):
            peaks[name] = Peak(float(most.values[k, i]), float(when.values[k, i]))
    events = [RecordedEvent(t, 0, e.name, e.what, 0, type(e.value).__name__, e.value) for t, e in s.log]
    notes = [(note.t_ns / 1e9, note.sentence) for note in s.notes]
    return Result(times, _kept(signals, keep), "", lambda: Course([], peaks, events, notes), _again=again)


def _signals(
    t: NDArray[np.float64], rows: NDArray[np.float64], columns: Sequence[Any], keep: Sequence[str]
) -> dict[str, Signal]:
    """Return the signals of rows (n, width) by name."""
    known = {c.topic: Signal(t, rows[:, c.start : c.stop], list(c.names), c.unit, c.topic) for c in columns}
    return _kept(known, keep)


def _kept(signals: dict[str, Signal], keep: Sequence[str]) -> dict[str, Signal]:
    """Return the signals to keep, copied so that the others can be freed."""
    if "*" in keep:
        return signals
    for pattern in keep:
        if not any(fnmatchcase(name, pattern) for name in signals):
            raise SignalError(f"keep: there is no signal {pattern}; {meant(pattern, list(signals))}")
    chosen = {name: x for name, x in signals.items() if any(fnmatchcase(name, pattern) for pattern in keep)}
    return {name: Signal(x.t, x.values.copy(), x.names, x.unit, name) for name, x in chosen.items()}
