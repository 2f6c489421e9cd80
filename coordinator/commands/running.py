"""`heavylift run`, `heavylift branch`, `heavylift resume`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated

import typer
from heavylift.coordinator.commands.common import options as o
from heavylift.coordinator.commands.common.app import app

from .hosts import open_listener
from .replicating import run_seeds, run_yard_file

if TYPE_CHECKING:
    from heavylift.coordinator.run.watch import RunObserver
    from heavylift.coordinator.uncertainty.certificate import Certifying
    from heavylift.nodes.scene import LoadedScene
    from heavylift.recordings import Spectator


@app.command()
def run(
    context: typer.Context,
    scene: o.Scene,
    output: Annotated[Path | None, o.written_to("recording; default NAME.mcap")] = None,
    force: o.Force = False,
    sets: o.Sets = None,
    in_process: o.InProcess = False,
    method: Annotated[str, typer.Option("--method", help="of integration: dopri5, radau5, ...")] = "",
    step: Annotated[str, typer.Option("--step", help="fixed steps: --step '2 ms'")] = "",
    processes: o.Processes = 0,
    view: Annotated[bool, typer.Option("--view", help="show the lift in a browser while it runs")] = False,
    foxglove: Annotated[bool, typer.Option("--foxglove", help="serve Foxglove and Lichtblick while it runs")] = False,
    publish: Annotated[
        float, typer.Option("--publish", min=0.001, max=10_000.0, help="samples a simulated second for who subscribes")
    ] = 10.0,
    places: o.Places = None,
    remote: o.Remote = None,
    external: o.External = None,
    listen: o.Listen = "",
    keys: o.Certificates = Path("certificates"),
    deadline: o.Deadline = "60 s",
    rate: Annotated[
        float | None, typer.Option("--rate", help="by the clock: 1 is real time, 10 ten times as fast")
    ] = None,
    drive: Annotated[
        list[str] | None, typer.Option("--drive", help="a drive follows a log: 'west.H1.hoist=log.csv:hoist_speed'")
    ] = None,
    certify: Annotated[
        bool, typer.Option("--certify", help="estimate the errors of peaks, swings, times and places by further runs")
    ] = False,
    within: Annotated[
        str, typer.Option("--within", help="as accurate as this machine can be in this time, start included: '10 s'")
    ] = "",
    accuracy: Annotated[
        str, typer.Option("--accuracy", help="of what the scene asks, else of tensions, swing, places, stages: '1 %'")
    ] = "",
    decide: Annotated[bool, typer.Option("--decide", help="as accurate as its checks need to be decided")] = False,
    real_time: Annotated[
        float | None, typer.Option("--real-time", help="the same, so many times as fast as real time")
    ] = None,
    replications: Annotated[
        int,
        typer.Option("--replications", min=1, help="runs with other seeds of a sea, or of a yard", show_default=False),
    ] = 0,
    seed: Annotated[int, typer.Option("--seed", help="of the replications")] = 1,
    report: Annotated[
        list[Path] | None,
        typer.Option(
            "--report",
            help="of replications, a yard file: .html, .pdf, .xlsx, .json, .txt; its schedule: .csv, .xml, .ics, .svg",
        ),
    ] = None,
    strict: o.Strict = False,
    fail_on: o.FailOn = "",
    verbose: o.Verbose = False,
    as_json: o.Json = False,
) -> None:
    """Simulate a scene, or a yard file, and record it.    heavylift run turnover -o monday.mcap

    With --replications, a scene in an irregular sea is run with so many seeds and not recorded; its limits are checked
    against the quantile stated for the waves.
    """
    runs, own = {"replications", "seed", "report"}, {"output", "force", "in_process", "processes"}
    if o.yard_file(context, scene, own | runs, () if replications else runs):
        drawn = replications, seed, report
        run_yard_file(scene, output, force, sets, in_process, processes, *drawn, strict, fail_on, as_json)
        return
    if replications:
        loaded = _asked(scene, sets or [], accuracy)
        run_seeds(context, loaded, replications, seed, report, force, strict, fail_on, as_json)
        return
    from heavylift.coordinator.participants import PRELOAD_SCENE
    from heavylift.coordinator.supervision.processes import Processes

    here = o.one_process(in_process, processes, places)
    crew = None if here else Processes(PRELOAD_SCENE)  # starts while the rest is imported
    try:
        from heavylift.coordinator.ladder.beside import Beside
        from heavylift.coordinator.ladder.choosing import chosen, decided, forestalled
        from heavylift.coordinator.live.keys import Keyboard
        from heavylift.coordinator.live.pace import RealTime
        from heavylift.coordinator.run import run as simulate
        from heavylift.coordinator.run.progress import Progress, summary
        from heavylift.coordinator.transport.placement import Placement, place
        from heavylift.nodes.models import node_names
        from heavylift.nodes.plan.fidelity import MEANT

        pace = None if rate is None else RealTime(rate)
        keys_given = ("method", method), ("step", step)
        given = [f"{key}={text}" for key, text in keys_given if text]
        patience = o.deadline_s(deadline)
        settings, fitted = [*(sets or []), *given], None
        if within or real_time is not None:
            from heavylift.coordinator.ladder.within import within as best

            settings += [f"accuracy={accuracy}"] if accuracy else []
            fitted = best(scene, settings, MEANT, within, real_time, rate)
        beside = Beside(crew.aside if crew else None)
        with forestalled(beside):
            loaded = fitted.scene if fitted else _asked(scene, settings, accuracy)
        if drive:
            from heavylift.coordinator.measured.mapping import driven

            loaded = driven(loaded, drive)
        find = decided if decide else chosen
        loaded = find(loaded, lambda message: typer.echo(f"  {message}", err=True), beside)
        nodes = node_names(loaded.plan)

        def tried(count: int, watch: RunObserver) -> object:
            with TemporaryDirectory() as folder:
                at = Path(folder) / "tried.mcap"
                return simulate(loaded, at, watch=watch, placement=Placement.spread(nodes, count), deadline=patience)

        if not places:
            elsewhere = [*loaded.facts.remote, *(remote or []), *(external or [])]
            processes = o.paying_processes(processes, len(nodes), tried, elsewhere)
        placement = place(
            nodes, loaded.facts.placement, places or [], processes, [*loaded.facts.remote, *(remote or [])],
            external or [],
        )  # fmt: skip
        listener = open_listener(placement.remote, listen, keys, in_process, placement.external)
        path = output or Path(f"{loaded.plan.name}.mcap")
        with (
            live_page(view) as page,
            viewers(loaded.plan.name, foxglove, publish, page) as observers,
            Keyboard() as keyboard,
            certified(loaded, certify) as certifying,
            Progress(loaded.plan, as_json) as watch,
        ):
            if fitted:
                watch.say(fitted.message)
            result = simulate(
                loaded, path, in_process, watch, crew, placement=placement, listener=listener, page=observers,
                deadline=patience, pace=pace, keyboard=keyboard, force=force, publish_hz=publish,
            )  # fmt: skip
            certificate = certifying.written(result.recording) if certifying else None
    finally:
        if crew is not None:
            crew.end()
    summary(loaded.plan, result, as_json, certificate, loaded.answer, verbose)
    o.end_by(strict, fail_on, result.verdict.state if result.verdict else "")


def _asked(scene: str, settings: list[str], accuracy: str) -> LoadedScene:
    """Load a scene; if an accuracy is given and the scene requests no quantities, request the usual ones."""
    from heavylift.nodes.plan.fidelity import MEANT

    loaded = o.scene_of(scene, settings := [*settings, *([f"accuracy={accuracy}"] if accuracy else [])])
    return loaded if loaded.facts.ask or not accuracy else o.scene_of(scene, [*settings, f"ask=[{', '.join(MEANT)}]"])


@app.command()
def branch(
    file: o.File,
    at: Annotated[str, typer.Option("--at", help="where: 'stage travel', 'end of stage travel', '120 s' or 2:00")],
    sets: o.Sets = None,
    edited: Annotated[str, typer.Option("--scene", help="an edited scene, in place of the one in the recording")] = "",
    output: Annotated[Path | None, o.written_to("recording; default NAME-branch.mcap")] = None,
    force: o.Force = False,
    strict: o.Strict = False,
    fail_on: o.FailOn = "",
    verbose: o.Verbose = False,
    as_json: o.Json = False,
) -> None:
    """Rerun a lift with changes from some time on.    heavylift branch lift.mcap --at 'stage up' --set end='2 min'

    The what-if run is refused if an event or sample before that time differs from the recorded one. The mechanics
    restart from the last checkpoint in the recording, or from the beginning if none fits the changed scene.
    """
    from heavylift.coordinator.run.branch import RunBranch, branch as simulate
    from heavylift.coordinator.run.progress import Progress, summary

    what = RunBranch.of(file, at, sets or [], edited or None)
    with Progress(what.scene.plan, as_json) as watch:
        result = simulate(what, output, watch, force)
    summary(what.scene.plan, result, as_json, verbose=verbose)
    o.end_by(strict, fail_on, result.verdict.state if result.verdict else "")


@app.command()
def resume(
    file: Annotated[
        Path,
        typer.Argument(
            help="a cut-off recording (.mcap.part), or one of a run that failed", autocompletion=o.recording_files
        ),
    ],
    output: Annotated[Path | None, o.written_to("default NAME-resumed.mcap")] = None,
    force: o.Force = False,
    strict: o.Strict = False,
    fail_on: o.FailOn = "",
    verbose: o.Verbose = False,
    as_json: o.Json = False,
) -> None:
    """Complete a run that was cut off, and check it against its recording.    heavylift resume lift.mcap.part"""
    from heavylift.coordinator.participants import PRELOAD
    from heavylift.coordinator.supervision.processes import Processes

    with Processes(PRELOAD) as crew:
        from heavylift.coordinator.run.progress import Progress, summary
        from heavylift.coordinator.run.resume import Beginning, RecordingOfModelError, resume as go_on, resume_model

        try:
            begun = Beginning.of(file, crew.directory.path)
        except RecordingOfModelError:
            made = resume_model(file, output, force)
            typer.echo(f"wrote {made.recording}\ndigest {made.digest}")
            return
        with Progress(begun.scene.plan, as_json) as watch:
            result = go_on(file, begun, output, watch, crew, force=force)
    summary(begun.scene.plan, result, as_json, verbose=verbose)
    o.end_by(strict, fail_on, result.verdict.state if result.verdict else "")


@contextmanager
def certified(scene: LoadedScene, wanted: bool) -> Iterator[Certifying | None]:
    """Yield the additional runs that estimate the errors of a run's figures, started on idle cores; None if not
    `wanted`."""
    if not wanted:
        yield None
        return
    from heavylift.coordinator.uncertainty.certificate import certifying

    with certifying(scene) as found:
        typer.echo(found.price, err=True)
        found.begin()
        yield found


@contextmanager
def live_page(view: bool) -> Iterator[Spectator | None]:
    """Serve a live page of the run, and open a browser if there is a display."""
    if not view:
        yield None
        return
    from heavylift.recordings.render.server import LivePage

    with LivePage() as page:
        o.browse(page.url)
        yield page


@contextmanager
def viewers(name: str, wanted: bool, hz: float, page: Spectator | None) -> Iterator[Spectator | None]:
    """Return the observers of the run: the live page, and a server for Foxglove if `wanted`."""
    if not wanted:
        yield page
        return
    from heavylift.recordings import Spectator
    from heavylift.recordings.render.foxglove import FoxgloveServer
    from heavylift.recordings.write.broadcast import Broadcast, Spectators

    with FoxgloveServer(name) as server:
        typer.echo(f"Foxglove and Lichtblick connect to {server.url}", err=True)
        yield Spectators(page or Spectator(), Broadcast(server, hz))
