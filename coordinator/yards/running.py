"""The run of a yard file: one with expected durations, which is recorded, or replications with drawn ones."""

from collections.abc import Sequence
from pathlib import Path

from heavylift.coordinator.run.models import ModelRun, run_models
from heavylift.coordinator.run.replications import numbers, replicate
from heavylift.nodes.yard.answers import answered, spans
from heavylift.nodes.yard.exchange import exported
from heavylift.recordings.sheets.sheet import Sheet

from .model import load_yard


def run_yard(
    file: str,
    settings: Sequence[str] = (),
    output: str | Path | None = None,
    in_process: bool = False,
    processes: int = 0,
    force: bool = False,
    replications: int = 0,
    seed: int = 1,
    exports: Sequence[Path] = (),
    drawn: bool = False,
) -> tuple[Sheet, ModelRun | None]:
    """Run a yard file once or in replications, export its schedule, and return the results; raises HeavyliftError."""
    yard = load_yard(file, settings)
    build = f"heavylift.coordinator.yards.model:yard({str(file)!r}, {[*settings]!r})"
    if replications:
        values, run = replicate(build, replications, seed, workers=processes).values, None
    else:
        run = run_models(build, None, output, in_process, processes=processes, force=force)
        values = {key: [x] for path, result in run.results.items() for key, x in numbers(path, result)}
    values = {key.partition(".")[2]: x for key, x in values.items()}
    for out in exports:
        exported(yard, spans(yard, values), out, force)
    return answered(yard, values, drawn), run
