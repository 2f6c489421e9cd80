"""Replications of a DEVS model: one run for each of many seeds, and an estimate of each number of its results.

    estimates = replicate("my_models:build", 30, until=3600.0).estimates
    estimates["shop.sink.wait"].mean, estimates["shop.sink.wait"].half

The interval mean +- half is that of Student's t: it covers the expectation with this confidence if the numbers of
single runs are about normal (Law and Kelton, Simulation Modeling and Analysis, 9.4.1).
"""

from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor
from contextlib import nullcontext
from dataclasses import dataclass
from math import isfinite, nan, sqrt
from statistics import fmean, stdev

import msgspec
from heavylift.coordinator.participants.building import built, couplings, seeded, stopping
from heavylift.coordinator.participants.lockstep import Lockstep
from heavylift.coordinator.supervision.pool import Pool, cores, submits
from heavylift.kernel import errors
from heavylift.kernel.errors import HeavyliftError, ModelError, ProtocolError, Stopped
from heavylift.nodes.devs import FOREVER, Coupled, Message, Simulator, Tag
from heavylift.nodes.devs.execution.rules import LIMIT

from .arguments import end_ns, whole
from .models import referred


@dataclass(frozen=True)
class Estimate:
    """Estimate of a number from all replications: mean, half-width of its confidence interval, standard deviation; NaN
    where undefined."""

    mean: float
    half: float
    deviation: float


@dataclass(frozen=True)
class Replications:
    """Results of replications: seeds of all runs, their numbers by "path.field", and the confidence level of the
    estimates."""

    seeds: list[int]
    values: dict[str, list[float]]
    confidence: float = 0.95

    @property
    def estimates(self) -> dict[str, Estimate]:
        """Estimates of all results by name, from the replications finished so far."""
        return {name: _estimate(x, self.confidence) for name, x in self.values.items()}


def replicate(
    build: str | Callable[..., Coupled],
    count: int,
    seed: int = 1,
    until: float | None = None,
    stop: str = "",
    microsteps: int = LIMIT,
    executor: Executor | None = None,
    workers: int = 0,
    confidence: float = 0.95,
) -> Replications:
    """Run a DEVS model `count` times, each time in one process and with another random seed.

    The seeds follow from `seed`. `executor`: any of concurrent.futures, by default a pool of `workers` processes
    (default: all cores); results do not depend on it. Raises HeavyliftError that names the replication, Stopped on
    Ctrl-C.
    """
    if whole("--replications", count) < 1 or not 0 < confidence < 1:
        raise ModelError(f"{count} replications, confidence {confidence}: give one run or more, and 0 < confidence < 1")
    if executor is not None and not submits(executor):
        raise ModelError(f"executor={executor!r}: give one of concurrent.futures, or a client's get_executor()")
    end_ns(until)  # complains before anything begins
    reference, seeds = referred(build), _seeds(whole("--seed", seed), count)
    tasks = [(number, seeded(reference, own), until, stop, microsteps) for number, own in enumerate(seeds, 1)]
    runs: list[dict[str, float]] = []
    try:
        with nullcontext(executor) if executor else Pool(min(workers or cores(), count)) as pool:
            begun = [pool.submit(_once, task) for task in tasks]
            runs += [_read(future.result()) for future in begun]
    except BrokenExecutor as error:
        raise ProtocolError(
            f"a worker of the executor has died ({error}); use fewer workers if memory is short"
        ) from None
    except KeyboardInterrupt:
        raise Stopped(f"stopped before all of {count} replications were done; no results are kept") from None
    for number, run in enumerate(runs, 1):
        if differing := sorted({*runs[0]} ^ {*run}):
            raise ModelError(
                f"replication {number} (seed {seeds[number - 1]}): {differing[0]} is a result of only some "
                "replications; the model must have the same atomic models for every seed"
            )
    return Replications(seeds, {name: [run[name] for run in runs] for name in runs[0]}, confidence)


def _seeds(seed: int, count: int) -> list[int]:
    """Return independent seeds; the first ones do not depend on `count`."""
    from numpy.random import SeedSequence

    return [int(child.generate_state(1, "u8")[0]) >> 1 for child in SeedSequence(seed).spawn(count)]


def _read(answer: bytes) -> dict[str, float]:
    """Return the numbers in an answer of `_once`, or raise its error."""
    values, kind, sentence = msgspec.msgpack.decode(answer, type=tuple[dict[str, float], str, str])
    if sentence:
        raise getattr(errors, kind, ModelError)(sentence)
    return values


def _once(task: tuple[int, str, float | None, str, int]) -> bytes:
    """Run the model once and return the numbers of its results, by "path.field"."""
    number, reference, until, stop, microsteps = task
    try:
        results = _results(built(reference), Tag(end_ns(until)), stop, microsteps)
    except HeavyliftError as error:
        return msgspec.msgpack.encode(({}, type(error).__name__, f"replication {number}, {reference}: {error}"))
    values = {name: x for path, result in results.items() for name, x in numbers(path, result)}
    return msgspec.msgpack.encode((values, "", ""))


def _results(model: Coupled, end: Tag, stop: str, microsteps: int) -> dict[str, Message]:
    """Return the results of a run in the flat simulator, which passes values instead of the protocol's bytes."""
    if finish := stopping(model, stop):
        own = {model.name: [*model.children]}
        flat = Simulator([*model.children.values()], microsteps=microsteps, wires=couplings(model, finish))
        run = Lockstep({model.name: flat}, [], end, finish, microsteps=microsteps, models=own)
        run.advance()
        end = run.end
    else:
        flat = Simulator(model, microsteps=microsteps)
        flat.start()
        flat.run(end.t)
    results = flat.results(end if end < FOREVER else Tag(0))
    return {path: results[path] for path in sorted(results, key=lambda path: path.split("."))}


def numbers(path: str, result: Message | msgspec.Struct) -> Iterator[tuple[str, float]]:
    """Yield name and value of each number in a result; names have the form "path.field", or "path.field[0]" for
    tuples."""
    for field in result.__struct_fields__:
        x = getattr(result, field)
        if isinstance(x, msgspec.Struct):
            yield from numbers(f"{path}.{field}", x)
        elif isinstance(x, tuple):
            yield from ((f"{path}.{field}[{i}]", float(y)) for i, y in enumerate(x) if isinstance(y, int | float))
        elif isinstance(x, int | float):
            yield f"{path}.{field}", float(x)


def _estimate(x: list[float], confidence: float) -> Estimate:
    if len(x) < 2:
        return Estimate(x[0], nan, nan)
    from scipy.special import stdtrit  # Student's t, inverted

    if not all(map(isfinite, x)):  # of some run there was nothing to observe
        return Estimate(nan, nan, nan)
    mean = fmean(x)
    deviation = stdev(x, mean)
    return Estimate(mean, float(stdtrit(len(x) - 1, 0.5 + confidence / 2)) * deviation / sqrt(len(x)), deviation)
