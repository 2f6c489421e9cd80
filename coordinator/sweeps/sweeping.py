"""Run the variants of a study on any executor of concurrent.futures or alike; each row is written as it comes.

The executor gets only a few more variants than it has workers, so that memory does not grow with the study. A worker
that dies breaks its pool: the variants in the pool are run again one by one, and a variant that kills its worker again
becomes a row "lost". After Ctrl-C all completed rows are kept, and the same study can be continued later.
"""

import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from heavylift.coordinator.ladder.choosing import level_of
from heavylift.coordinator.run.arguments import texts, time_s, whole
from heavylift.coordinator.run.models import referred
from heavylift.coordinator.run.result import Result
from heavylift.coordinator.supervision.pool import Pool, cores, finished, submits
from heavylift.kernel.errors import ProtocolError, SceneError, Stopped
from heavylift.nodes.scene import LoadedScene, loaded
from heavylift.nodes.scene.text.units import DURATION

from .axes import Variant, axes_of, grid, sampled
from .study import Study, StudyPlan
from .summary import DESIGNS, drawn
from .variant import KEEP, Keep, Row, Task, answered, played, received

AHEAD, MOST = 3, 256  # variants with the executor for each worker; in all, if nobody says how many there are
WAIT_s, WRITE_s = 0.2, 1.0  # for a variant to be done; between two files of rows
LIMIT_s = 60.0  # of wall time that a run may take
Watch = Callable[[Study, Row | None], None]


def planned(
    scene: LoadedScene | str | Path, vary: Sequence[str] = (), sample: int = 0, design: str = DESIGNS[0], seed: int = 1
) -> StudyPlan:
    """Return the definition of a study of a scene; raises SceneError for a path that cannot be varied."""
    scene = level_of(loaded(scene))
    sample, seed, text = whole("--sample", sample), whole("--seed", seed), texts(vary)
    if text is None:
        raise SceneError(f"--vary {vary!r}: give texts PATH=VALUES, such as 'block.mass=200..400 t by 25 t'")
    axes = axes_of(scene, text, sample > 0)
    variants = sampled(axes, drawn(design, sample, len(axes), seed)) if sample else grid(axes)
    return StudyPlan(scene, axes, variants, design if sample else "", sample, seed)


def sweep(
    scene: LoadedScene | str | Path,
    vary: Sequence[str] = (),
    *,
    into: str | Path,
    sample: int = 0,
    design: str = DESIGNS[0],
    seed: int = 1,
    executor: Executor | None = None,
    workers: int = 0,
    keep: Keep = "none",
    judged: bool = True,
    limit: float = LIMIT_s,
    watch: Watch = lambda study, row: None,
    responses: Mapping[str, str | Callable[[Result], float]] = MappingProxyType({}),
) -> Study:
    """Run those variants of a scene that the folder `into` does not contain yet; the returned study has all results as
    `rows`.

    `vary`: axes such as "block.mass=200..400 t by 25 t": all combinations of values, or with `sample` this number of
    draws of them and of the scene's uncertain inputs. `executor`: any object whose `submit` returns a future; default:
    a pool of `workers` processes (default: all cores). `keep`: recordings of "failed" or "all" variants. Without
    `judged` there is no verdict, and actions are not checked statically first, for which `run` may refuse a scene.
    `limit`: wall time of a run [s]. `responses`: functions of a run's `Result`, or their references, that give the
    columns "response/NAME".
    Raises HeavyliftError, and Stopped on Ctrl-C.
    """
    if keep not in KEEP:
        raise SceneError(f"--keep '{keep}' is not a known choice; choose {', '.join(KEEP)}")
    workers, limit = whole("--workers", workers), time_s("--limit", limit, DURATION)
    if executor is not None and not submits(executor):
        raise SceneError(f"executor={executor!r}: give an object with `submit`, such as one of concurrent.futures")
    plan = planned(scene, vary, sample, design, seed)
    own = tuple((name, referred(function)) for name, function in responses.items())
    with Study(into, plan, replace(Task.of(plan.scene, limit, keep, judged), responses=own)) as study:
        watch(study, None)
        try:
            if study.waiting:
                _run(study, executor, workers or (0 if executor else cores()), watch)
        except KeyboardInterrupt:
            done, count = len(study.rows), len(plan.variants)
            message = f"stopped after {done} of {count} runs, which are kept; the same command continues"
            raise Stopped(f"{study.path}: {message}") from None
        finally:
            study.join()
    return study


def verified(study: Study, count: int) -> list[tuple[int, bool]]:
    """Repeat `count` variants in this process; return for each its number, and whether its digest equals the one in its
    row."""
    known = [n for n in sorted(study.rows) if study.rows[n].get("digest")]
    chosen = [known[round(i * (len(known) - 1) / max(1, count - 1))] for i in range(min(count, len(known)))]
    found = []
    for n in dict.fromkeys(chosen):
        again = played(study.task, study.plan.variants[n])
        found.append((n, again.get("digest") == study.rows[n]["digest"]))
    return found


def _run(study: Study, executor: Executor | None, workers: int, watch: Watch) -> None:
    """Run all variants that have no row."""
    most = AHEAD * workers if workers else MOST
    waiting, suspects = deque(study.waiting), deque[Variant]()
    while waiting or suspects:
        if executor is None:
            with Pool(min(workers, len(waiting) + len(suspects))) as pool:
                _with(pool, study, waiting, suspects, most, watch)
        elif broken := _with(executor, study, waiting, suspects, most, watch):
            raise ProtocolError(
                f"the executor has lost its workers ({broken}); restart it and repeat the command to continue the study"
            )


def _with(
    pool: Executor, study: Study, waiting: deque[Variant], suspects: deque[Variant], most: int, watch: Watch
) -> str:
    """Run variants on a pool until none is left; returns why the pool is broken, or "". `suspects` were running when a
    pool broke: each is run alone, so that the next break has a known cause."""
    running: dict[Future[bytes], Variant] = {}
    alone = False
    rows: list[Row] = []
    written = time.monotonic()
    try:
        while waiting or suspects or running:
            while (waiting or suspects) and len(running) < (1 if suspects or (alone and running) else most):
                alone, variant = bool(suspects), (suspects or waiting)[0]
                try:
                    future = pool.submit(answered, study.task, variant)
                except BrokenExecutor as error:
                    suspects.extend(running.values())
                    return str(error)
                (suspects or waiting).popleft()
                running[future] = variant
            broken: dict[Variant, BaseException] = {}
            for future in finished(running, WAIT_s):
                variant, why = running.pop(future), future.exception()
                if isinstance(why, BrokenExecutor):
                    broken[variant] = why
                    continue
                try:
                    rows.append(_lost(variant, _reason(why)) if why else received(future.result(), variant))
                except ProtocolError as error:
                    rows.append(_lost(variant, str(error)))
                watch(study, rows[-1])
            if broken:
                message = str(next(iter(broken.values())))
                if alone and len(broken) + len(running) == 1:
                    rows.append(_lost(next(iter(broken)), f"its worker died: {message}"))
                    watch(study, rows[-1])
                else:
                    suspects.extend([*broken, *running.values()])
                return message
            if rows and time.monotonic() - written > WRITE_s:
                study.append(rows)
                rows, written = [], time.monotonic()
        return ""
    finally:
        for future in running:
            future.cancel()
        study.append(rows)


def _reason(why: BaseException) -> str:
    """Return why there is no row; pickles of a dask worker are not read."""
    if why.args and isinstance(why.args[0], bytes):
        return "its worker died, or answered with code, which is not run here"
    return f"{type(why).__name__}: {why}"


def _lost(variant: Variant, sentence: str) -> Row:
    return {"number": variant.number, "status": "lost", "sentence": sentence}
