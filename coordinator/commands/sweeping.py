"""`heavylift sweep`: many runs of one scene.

`heavylift limits`, `heavylift plan`: how far a number of a scene may go, and the shortest timing of a lift.
"""

import json
import tempfile
import time
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from heavylift.coordinator.commands.common import options as o
from heavylift.coordinator.commands.common.app import app
from heavylift.kernel.description.findings import STATES
from heavylift.kernel.errors import SceneError, Stopped

if TYPE_CHECKING:
    from heavylift.coordinator.sweeps.study import Study
    from heavylift.coordinator.uncertainty.certificate import Certificate
    from heavylift.nodes.scene import LoadedScene
    from heavylift.recordings.sheets.sheet import Sheet

EFFORT = 0.1  # of the solver's own seconds in one of the wall, as it works alone
REPLICATIONS = 100  # of a yard
SEEDS = 30  # of each sea of a scatter table
REPORT_s = 10.0  # between two lines where there is no terminal


@app.command()
def sweep(
    context: typer.Context,
    scene: o.Scene,
    vary: Annotated[
        list[str] | None, typer.Option("--vary", help="'block.mass=200..400 t by 25 t', 'PATH={one, another}'")
    ] = None,
    sample: Annotated[int, typer.Option("--sample", help="draw so many of --vary and of the uncertain inputs")] = 0,
    design: Annotated[str, typer.Option("--design", help="of the sample: sobol or lhs")] = "sobol",
    seed: Annotated[int, typer.Option("--seed", help="of the sample")] = 1,
    output: Annotated[Path, o.written_to("folder of the study")] = Path("study"),
    workers: Annotated[int, typer.Option("--workers", help="processes; default all cores")] = 0,
    scheduler: Annotated[str, typer.Option("--scheduler", help="of dask: tls://HOST:8786")] = "",
    insecure: Annotated[
        bool, typer.Option("--insecure-scheduler", help="it may be one without certificates and encryption, tcp://")
    ] = False,
    keys: o.Certificates = Path("certificates"),
    response: Annotated[
        list[str] | None, typer.Option("--response", help="a column of your own: 'sway=own.py:sway'")
    ] = None,
    keep: Annotated[str, typer.Option("--keep", help="recordings of: none, failed, all")] = "none",
    verify: Annotated[int, typer.Option("--verify", help="run so many again here and compare digests")] = 0,
    limit: Annotated[str, typer.Option("--limit", help="wall time of a run, then it is cut")] = "60 s",
    sets: o.Sets = None,
    strict: o.Strict = False,
    fail_on: o.FailOn = "",
    as_json: o.Json = False,
) -> None:
    """Run variants of a scene.    heavylift sweep lift --vary 'block.mass=200..400 t by 25 t' -o study

    Each run adds a row to study/rows.parquet, with the command that repeats it; study/summary.html
    summarises the results. A path is one that --set takes; all combinations of values are run, or
    --sample draws them. The same command continues a study that was stopped. A --response is a Python
    function that returns a number for the Result of a run, as `heavylift.simulate` does. Of a yard file:
    --sample replications of each combination.
    """
    from heavylift.coordinator.run.arguments import whole
    from heavylift.coordinator.sweeps.dask_workers import dask_workers
    from heavylift.coordinator.sweeps.function_studies import responses_of
    from heavylift.coordinator.sweeps.page import status_line, study_sheet
    from heavylift.coordinator.sweeps.summary import measured_error, summary
    from heavylift.coordinator.sweeps.sweeping import sweep as run_all, verified
    from heavylift.recordings.sheets.sheet import page_of

    if o.yard_file(context, scene, {"vary", "sample", "seed", "output", "workers", "scheduler", "insecure", "keys"}):
        from heavylift.coordinator.supervision.pool import Pool, cores

        with dask_workers(scheduler, keys, insecure) if scheduler else Pool(workers or cores()) as executor:
            sheet = o.study_of(scene, sets, sample or REPLICATIONS, seed, executor=executor).varied(vary or [])
        output.mkdir(parents=True, exist_ok=True)
        o.tell_study(sheet, output / "summary.html", True, as_json)
        o.end_by(strict, fail_on, sheet.state)
        return
    loaded, verify = o.scene_of(scene, sets), whole("--verify", verify)
    seconds = o.wall_s("--limit", limit)
    o.find_own_modules(response or ())
    responses = responses_of(response or ())
    progress = _Progress()
    with dask_workers(scheduler, keys, insecure) if scheduler else nullcontext() as executor:
        try:
            study = run_all(
                loaded, vary or [], into=output, sample=sample, design=design, seed=seed, executor=executor,
                workers=workers, keep=keep, limit=seconds, watch=progress, responses=responses,  # type: ignore[arg-type]
            )  # fmt: skip
        except Stopped:
            if progress.study is not None:
                (output / "summary.html").write_text(page_of(study_sheet(progress.study)), encoding="utf-8")
            raise
        finally:
            progress.end()
    (output / "summary.html").write_text(page_of(study_sheet(study)), encoding="utf-8")
    found, again = summary(study), verified(study, verify)
    differing = [number for number, equal in again if not equal]
    if as_json:
        more = {"error": error} if (error := measured_error(study)) else {}
        counted = {"study": str(output), **found.counts, "verified": len(again), "differing": differing}
        typer.echo(json.dumps(counted | more))
    else:
        typer.echo("\n".join([status_line(study, found), *([error] if (error := measured_error(study)) else [])]))
        for number, equal in again:
            typer.echo(f"variant {number}: {'the same digest again' if equal else 'ANOTHER DIGEST'}")
        typer.echo(f"wrote {output / 'summary.html'} and {output / 'rows.parquet'}")
    states = {str(row.get("state") or ("green" if row["status"] == "done" else "red")) for row in study.rows.values()}
    o.end_by(strict, fail_on, *states)
    if differing:
        raise typer.Exit(1)


class _Progress:
    """Progress of a study: a bar on a terminal, else an occasional line."""

    def __init__(self) -> None:
        from heavylift.coordinator.live.terminal import Terminal, changing_line

        self.study: Study | None = None
        self._console = Terminal(err=True)
        self._live = changing_line(self._console, 4)
        self._done, self._counts = 0, dict[str, int]()
        self._began = self._message = time.monotonic()

    def __call__(self, study: "Study", row: dict[str, Any] | None) -> None:
        """Show the start of a study (`row` is None), or a new row."""
        if row is None:
            self.study = study
            known = len(study.rows)
            if known:
                self._console.print(f"{known} of {len(study.plan.variants)} runs are there already")
            if self._console.is_terminal:
                self._live.start()
            self._began, self._left = time.monotonic(), len(study.waiting)
            return
        self._began = self._began if self._done else time.monotonic()  # workers take a while to start
        self._done += 1
        self._counts[row["status"]] = self._counts.get(row["status"], 0) + 1
        now = time.monotonic()
        if self._console.is_terminal:
            self._live.update(self._line(now))
        elif now - self._message > REPORT_s:
            self._message = now
            self._console.print(self._line(now), soft_wrap=True)

    def end(self) -> None:
        """Remove the progress display from the terminal."""
        if self._live.is_started:
            self._live.stop()

    def _line(self, now: float) -> str:
        from heavylift.kernel.description.findings import clock

        rate = max(self._done - 1, 0.5) / max(0.5, now - self._began)
        counts = ", ".join(f"{n} {status}" for status, n in sorted(self._counts.items()))
        left = clock((self._left - self._done) / rate)
        return f"{self._done} of {self._left} runs, {rate:.1f} a second, {left} to go: {counts}"


@app.command()
def limits(
    context: typer.Context,
    scene: o.Scene,
    of: Annotated[list[str] | None, typer.Option("--of", help="'block.com.x', 'hoist accel', 'PATH=1..20 m'")] = None,
    every: Annotated[bool, typer.Option("--all", help="of all moves, usual and uncertain inputs")] = False,
    output: Annotated[Path | None, o.written_to("page with table and figure: limits.html")] = None,
    workers: Annotated[int, typer.Option("--workers", help="processes; default all cores")] = 0,
    limit: Annotated[str, typer.Option("--limit", help="wall time of a run")] = "60 s",
    replications: Annotated[int, typer.Option("--replications", help="seeds of a random sea, for each value")] = 0,
    scatter: Annotated[
        Path | None, typer.Option("--scatter", help="table of seas, Hs by Tp: in how much of the time it passes")
    ] = None,
    sets: o.Sets = None,
    force: o.Force = False,
    strict: o.Strict = False,
    fail_on: o.FailOn = "",
    as_json: o.Json = False,
) -> None:
    """Find how far a number may go before the verdict is red.    heavylift limits lift --of 'block.mass=300..900 t'

    Each value is checked by a run; the limit lies between the last green and the first red value. A number is one that
    --set takes, or 'hoist speed', 'trolley accel' and the like, which scale all such orders. Exit code 1 if the verdict
    is red at the start, never turns red, or is green again beyond the limit; with --all only if it is red at the start.
    With --strict undecided counts as red, with --fail-on amber everything but green. Of a yard file:
    'resources.welders=72..40' until a contract date is missed. With --replications, --of 'waves.seas.wind.Hs=0.5..3 m'
    finds the sea whose quantile over seeds is within the limits, and --scatter the share of a table of seas.
    """
    if o.yard_file(context, scene, {"of", "output", "workers", "force"}):
        from heavylift.coordinator.supervision.pool import Pool, cores

        with Pool(workers or cores()) as pool:
            sheet = o.study_of(scene, sets, REPLICATIONS, executor=pool).limit((of or [""])[0])
        o.tell_study(sheet, output, force, as_json)
        o.end_by(strict, fail_on or "red", sheet.state)
        return
    from heavylift.coordinator.sweeps.limiting import askable, limits_of_all
    from heavylift.coordinator.sweeps.page import limits_sheet, limits_table
    from heavylift.recordings.sheets.sheet import table_text
    from heavylift.recordings.sheets.workbook import write

    if scatter:
        sheet = _operability(o.scene_of(scene, sets), scatter, of or [""], replications, o.wall_s("--limit", limit))
        o.tell_study(sheet, output, force, as_json)
        o.end_by(strict, fail_on or "red", sheet.state)
        return
    if bool(of) == every:
        raise SceneError("limits: give --of, such as --of 'block.mass=300..900 t', or --all")
    loaded, seconds = o.scene_of(scene, sets), o.wall_s("--limit", limit)
    fails = max(("red", "undecided" if strict or replications else "red", fail_on or "red"), key=STATES.index)
    asked = of or askable(loaded)
    say = partial(typer.echo, err=True)
    found = limits_of_all(loaded, asked, seconds, workers, say, fails, replications)
    if as_json:
        typer.echo(json.dumps([one.data() for one in found]))
    elif every:
        typer.echo(table_text(limits_table(found)))
    else:
        typer.echo("\n".join(map(str, found)))
    if output is not None:
        path = write(limits_sheet(loaded, found), output, "a table of limits", force)
        typer.echo(f"wrote {path}", err=as_json)
    if any(one.wrong for one in found) and (of or all(one.wrong for one in found)):
        raise typer.Exit(1)


def _operability(scene: "LoadedScene", scatter: Path, of: list[str], count: int, limit_s: float) -> "Sheet":
    from heavylift.coordinator.ladder.choosing import level_of
    from heavylift.coordinator.supervision.pool import Pool, cores
    from heavylift.coordinator.sweeps.operability import ScatterTable, operability_sheet, sea_of
    from heavylift.coordinator.sweeps.seeds import SeaRuns, check_seeds

    table, name = ScatterTable.read(scatter), sea_of(scene, of[0])
    check_seeds(scene, count := count or SEEDS)
    with Pool(min(count, cores())) as pool:
        runs = SeaRuns(level_of(scene), range(1, count + 1), limit_s, pool)
        return operability_sheet(scene, table, name, runs, partial(typer.echo, err=True))


@app.command()
def plan(
    context: typer.Context,
    scene: o.Scene,
    output: Annotated[Path | None, o.written_to("scene; default NAME-planned.yaml, of a yard .csv or .xml")] = None,
    force: o.Force = False,
    budget: Annotated[str, typer.Option("--budget", help="wall time of the search")] = "15 min",
    certify: Annotated[bool, typer.Option("--certify", help="estimate the errors of the new timing")] = False,
    sets: o.Sets = None,
    as_json: o.Json = False,
) -> None:
    """Find the shortest timing within all limits, and write the scene with it.    heavylift plan lift

    Tries higher speeds of orders, ramps without swing, and overlapping moves, first along the equilibrium path, then in
    runs; the last run is green. Waits, comments and layout of the scene are kept. Exit code 1 if the scene is red as it
    is written, or nothing is gained. Of a yard file: a schedule by CP-SAT, how near it is to a bound, and how robust.
    """
    if o.yard_file(context, scene, {"output", "force", "budget"}):
        from heavylift.coordinator.supervision.pool import Pool, cores

        effort = EFFORT * o.wall_s("--budget", budget)
        with Pool(cores()) as pool:
            study = o.study_of(scene, sets, REPLICATIONS, executor=pool)
            o.tell(study.planned(str(output or f"{Path(scene).stem}-planned.csv"), effort, force), as_json)
        return
    from heavylift.coordinator.sweeps.planning import planned
    from heavylift.recordings.write.outputs import output_path
    from heavylift.recordings.write.partfile import written

    loaded = o.scene_of(scene, sets)
    path = output_path(output or Path(f"{loaded.plan.name}-planned.yaml"), "a scene", (".yaml", ".yml"))
    found = planned(loaded, o.wall_s("--budget", budget), lambda status_line: typer.echo(f"  {status_line}", err=True))
    if found.after is None:
        typer.echo(json.dumps({"wrong": found.wrong}) if as_json else f"{loaded.plan.name}: {found.wrong}")
        raise typer.Exit(1)
    path = written(found.after.text, path, "a scene", (".yaml", ".yml"), force)
    sure = _certified(path) if certify else None
    if as_json:
        status_line = {**found.data(), "scene": str(path), "certified": sure.data() if sure else None}
        typer.echo(json.dumps(status_line))
        return
    typer.echo("\n".join([*found.message, *(sure.message if sure else []), f"wrote {path}"]))


def _certified(path: Path) -> "Certificate":
    """Return the certificate of a run of the scene file; the recording is discarded."""
    from heavylift.coordinator.run.scene import run
    from heavylift.coordinator.uncertainty.certificate import certifying
    from heavylift.nodes.scene import load

    loaded = load(path)
    with tempfile.TemporaryDirectory(prefix="heavylift-") as folder, certifying(loaded) as found:
        typer.echo(f"  {found.price}", err=True)
        found.begin()
        recording = Path(folder) / "run.mcap"
        run(loaded, recording, in_process=True)
        return found.written(recording)
