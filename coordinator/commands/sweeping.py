"""`heavylift sweep`: many runs of one scene."""

from __future__ import annotations

import json
import time
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from heavylift.coordinator.commands.common import options as o
from heavylift.coordinator.commands.common.app import app
from heavylift.kernel.errors import Stopped

if TYPE_CHECKING:
    from heavylift.coordinator.sweeps.study import Study

TELL_s = 10.0  # between two lines where there is no terminal


@app.command()
def sweep(
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
    keep: Annotated[str, typer.Option("--keep", help="recordings of: none, failed, all")] = "none",
    verify: Annotated[int, typer.Option("--verify", help="run so many again here and compare digests")] = 0,
    limit: Annotated[str, typer.Option("--limit", help="wall time of a run, then it is cut")] = "60 s",
    sets: o.Sets = None,
    strict: o.Strict = False,
    fail_on: o.FailOn = "",
    as_json: o.Json = False,
) -> None:
    """Run variants of a scene.    heavylift sweep lift --vary 'block.mass=200..400 t by 25 t' -o study

    Rows go to study/rows.parquet as they come, with the command that repeats each, and study/summary.html tells what
    they say. A path is one that --set takes; each value is run with each other one, or --sample draws them. The same
    command goes on with a study that was stopped.
    """
    from heavylift.coordinator.run.arguments import whole
    from heavylift.coordinator.sweeps.dask_workers import dask_workers
    from heavylift.coordinator.sweeps.page import study_sheet, told
    from heavylift.coordinator.sweeps.summary import measured_error, summary
    from heavylift.coordinator.sweeps.sweeping import sweep as run_all
    from heavylift.coordinator.sweeps.sweeping import verified
    from heavylift.recordings.sheets.page import page_of

    loaded, verify = o.scene_of(scene, sets), whole("--verify", verify)
    seconds = o.wall_s("--limit", limit)
    progress = _Progress()
    with dask_workers(scheduler, keys, insecure) if scheduler else nullcontext() as executor:
        try:
            study = run_all(
                loaded, vary or [], into=output, sample=sample, design=design, seed=seed, executor=executor,
                workers=workers, keep=keep, limit=seconds, watch=progress,  # type: ignore[arg-type]
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
        typer.echo("\n".join([told(study, found), *([error] if (error := measured_error(study)) else [])]))
        for number, equal in again:
            typer.echo(f"variant {number}: {'the same digest again' if equal else 'ANOTHER DIGEST'}")
        typer.echo(f"wrote {output / 'summary.html'} and {output / 'rows.parquet'}")
    states = {str(row.get("state") or ("green" if row["status"] == "done" else "red")) for row in study.rows.values()}
    if differing or any(o.fails(state, strict, fail_on) for state in states):
        raise typer.Exit(1)


class _Progress:
    """How far a study is: a bar on a terminal, else a line now and then."""

    def __init__(self) -> None:
        from heavylift.coordinator.live.terminal import Terminal, changing_line

        self.study: Study | None = None
        self._console = Terminal(err=True)
        self._live = changing_line(self._console, 4)
        self._done, self._counts = 0, dict[str, int]()
        self._began = self._told = time.monotonic()

    def __call__(self, study: Study, row: dict[str, Any] | None) -> None:
        """The study has begun (None), or a row has come."""
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
        elif now - self._told > TELL_s:
            self._told = now
            self._console.print(self._line(now), soft_wrap=True)

    def end(self) -> None:
        """No more."""
        if self._live.is_started:
            self._live.stop()

    def _line(self, now: float) -> str:
        from heavylift.kernel.description.findings import clock

        rate = max(self._done - 1, 0.5) / max(0.5, now - self._began)
        counts = ", ".join(f"{n} {status}" for status, n in sorted(self._counts.items()))
        left = clock((self._left - self._done) / rate)
        return f"{self._done} of {self._left} runs, {rate:.1f} a second, {left} to go: {counts}"
