"""`heavylift replay`, `heavylift measured`, `heavylift sensitivities`: rerun a recording, compare it with a real lift,
vary uncertain inputs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import msgspec
import typer
from heavylift.coordinator.commands.common import options as o
from heavylift.coordinator.commands.common.app import app
from heavylift.kernel.errors import UNREADABLE, RecordingError
from heavylift.kernel.version import __version__

from .running import live_page

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from heavylift.coordinator.replay import RecordedRun, ReplayResult
    from heavylift.coordinator.run.watch import RunObserver


@app.command()
def replay(
    file: o.File,
    rate: Annotated[float, typer.Option("--rate", help="seconds of the run per second of the wall")] = 1.0,
    start: Annotated[float | None, typer.Option("--from", help="time of the run [s]; default its start")] = None,
    end: Annotated[float | None, typer.Option("--to", help="time of the run [s]; default its end")] = None,
    loop: Annotated[bool, typer.Option("--loop", help="again and again")] = False,
    paused: Annotated[bool, typer.Option("--paused", help="wait for a key: space goes on, s steps")] = False,
    topics: Annotated[
        list[str] | None, typer.Option("--topics", help="only these, such as 'commander/*'; may be repeated")
    ] = None,
    verify: Annotated[bool, typer.Option("--verify", help="simulate again: is every event reproduced?")] = False,
    live: Annotated[
        str, typer.Option("--live", help="run this model for real against the recorded rest, such as crane/west")
    ] = "",
    view: Annotated[bool, typer.Option("--view", help="show the lift in a browser while it is played")] = False,
    as_json: o.Json = False,
) -> None:
    """Replay or verify a recording, or rerun one of its models.    heavylift replay turnover.mcap --rate 20

    Keys: space pauses and continues, s steps, + and - change the rate, q quits. --verify and --live: exit code 1 if
    anything deviates.
    """
    from heavylift.coordinator.replay import RecordedRun, single
    from heavylift.coordinator.run.verify import verify as prove

    run = RecordedRun(file)
    if verify and live:
        raise RecordingError(f"{file}: --verify runs all models and --live only one; use one of the two options")
    playing = {"--rate": rate != 1.0, "--from": start is not None, "--to": end is not None, "--loop": loop}
    playing |= {"--paused": paused, "--topics": bool(topics), "--view": view}
    given = [option for option, is_given in playing.items() if is_given]
    if given and (verify or live):
        alone = "--verify" if verify else "--live"
        raise RecordingError(
            f"{file}: {alone} runs models as fast as possible and replays nothing; leave out {', '.join(given)}"
        )
    if verify:
        _report(run, prove(run), "the run", as_json)
    elif live:
        _report(run, single(run, live), live, as_json)
    else:
        _publish(run, rate, start, end, loop, paused, topics or [], view)


def _report(run: RecordedRun, found: ReplayResult, who: str, as_json: bool) -> None:
    """Print the result of a comparison; exit with code 1 if anything deviates."""
    if as_json:
        typer.echo(msgspec.json.encode(found).decode())
    elif found.deviation:
        typer.echo(f"{who} deviates after {found.events} equal events, {found.deviation}")
        typer.echo(f"the recording was made by heavylift {run.recording.version}, this is {__version__}")
    elif found.digest:
        typer.echo(f"reproduced: {found.events} events and all samples, digest {found.digest}")
        typer.echo(f"checked again: {found.judged}" if found.judged else "facts of the result are the same")
    elif found.same:
        upto = "" if run.complete else f", as far as the recording goes, {run.end}"
        typer.echo(f"{who}: no deviation in {found.events} events{upto}")
    if not as_json:
        for what in found.others:
            typer.echo(f"{who} is not what was recorded: {what}")
        if found.as_recorded:
            typer.echo(f"as recorded, not computed again: {', '.join(found.as_recorded)}")
    if not found.same:
        raise typer.Exit(1)


def _publish(
    run: RecordedRun,
    rate: float,
    start: float | None,
    end: float | None,
    loop: bool,
    paused: bool,
    topics: list[str],
    view: bool,
) -> None:
    from heavylift.coordinator.live.keys import Keyboard
    from heavylift.coordinator.replay import Player, PublishedItem, Publisher, Replay
    from heavylift.coordinator.replay.publish import ReplayPage
    from heavylift.coordinator.run.progress import command

    if not 0.0 < rate < float("inf"):
        raise RecordingError(
            f"{run.path}: --rate {rate:g} is not a valid rate; give a number greater than 0, such as 20"
        )
    if loop and view:
        raise RecordingError(f"{run.path}: --view shows a replay only once; leave out --loop")
    asked = Replay(run, topics, start, end)
    with (
        live_page(view) as page,
        Keyboard() as keyboard,
        Publisher(run.recording.run.get("scene", run.path.stem), run.path) as publisher,
    ):
        if paused and not keyboard.there:
            raise RecordingError(f"{run.path}: --paused waits for keys, but there is no terminal; leave it out")
        keys = "; space pauses, s steps, + - rate, q ends" if keyboard.there else ""
        typer.echo(f"run {publisher.run} in {publisher.directory}; {command()} watch {publisher.run}{keys}", err=True)
        count = 0
        replay_page = ReplayPage(run, page, asked.start) if page is not None else None
        with _watching(run) as progress:

            def say(one: PublishedItem) -> None:
                publisher.say(one)
                if one.event is not None:
                    progress.event(one.event)
                    if replay_page is not None:
                        replay_page.event(one.event)

            def message(t_ns: int) -> None:
                progress.progress(t_ns)
                if replay_page is not None:
                    replay_page.reached(t_ns)

            player = Player(say, rate, paused, keyboard, on_time=message)
            while True:
                count += player.play(asked)
                if not count and not player.over:
                    raise RecordingError(f"{run.path}: nothing was recorded in this time range; give an earlier --from")
                if player.over or not loop:
                    break
        if replay_page is not None:
            replay_page.end()
    typer.echo(f"replayed {count} messages of {len(asked.topics)} topics")


def _watching(run: RecordedRun) -> AbstractContextManager[RunObserver]:
    """Return the progress display of a replay: stages, if the recording is one of a scene."""
    from contextlib import nullcontext

    from heavylift.coordinator.record.scene import RESOLVED
    from heavylift.coordinator.run.progress import Progress
    from heavylift.coordinator.run.watch import RunObserver
    from heavylift.nodes.plan.plan import decode

    try:
        return Progress(decode(run.recording.attachments[RESOLVED]))
    except (KeyError, *UNREADABLE):
        return nullcontext(RunObserver())


Inputs = Annotated[
    list[str] | None, typer.Option("--input", help="uncertainty of an input (95 %): 'block.mass +- 3 %'")
]


@app.command()
def sensitivities(
    context: typer.Context, scene: o.Scene, inputs: Inputs = None, sets: o.Sets = None, as_json: o.Json = False
) -> None:
    """Find the effect of each uncertain input on each peak.    heavylift sensitivities lift --input 'block.mass +- 3 %'

    Uncertainties are those of the scene (mass: 480 t +- 3 %, 480 t sd 5 t, 460..500 t) and of --input. Each input takes
    two runs, four if its effect is not proportional. Uncertainties are given at a level of 95 %; the share of an input
    is its part of the sum of squares. Of a yard file: what resources, spreads and weather cost in days.
    """
    if o.yard_file(context, scene, ()):
        from heavylift.coordinator.supervision.pool import Pool, cores

        with Pool(cores()) as pool:
            o.tell(o.study_of(scene, sets, 100, executor=pool).sensitivities(), as_json)
        return
    from heavylift.coordinator.uncertainty.sensitivities import sensitivities as find

    found = find(o.scene_of(scene, sets), inputs or [], say=lambda x: typer.echo(f"  {x}", err=True))
    typer.echo(json.dumps(found.data()) if as_json else str(found))


@app.command()
def measured(
    file: o.File,
    log: Annotated[Path, typer.Argument(help="log of the real lift, .csv")],
    maps: Annotated[
        list[str], typer.Option("--map", help="map.yaml, or 'cell_H1=rope/tension/west.H1 [kN] +- 5 kN' (95 %)")
    ],
    offset: Annotated[str, typer.Option("--offset", help="time 0 of the log in the run; default estimated")] = "",
    estimate: Annotated[
        list[str] | None, typer.Option("--estimate", help="input of the scene to fit: block.mass, block.com.x, ...")
    ] = None,
    inputs: Inputs = None,
    output: Annotated[Path | None, o.written_to("default NAME-measured.mcap")] = None,
    force: o.Force = False,
    as_json: o.Json = False,
) -> None:
    """Compare a measured log with its run, and estimate inputs.    heavylift measured lift.mcap log.csv --map map.yaml

    Writes a new recording with the channels of the log beside those of the run; plot, view and report draw them dashed.
    For each channel: E = run - log and its uncertainty u_val, 95 %, after ASME V&V 20; uncertainties of inputs come
    from the scene or --input, each input takes two runs. --estimate fits inputs of the scene, names those that the log
    does not determine, and writes the others into a scene beside the recording.
    """
    from heavylift.coordinator.measured.measuring import measure
    from heavylift.nodes.scene.text.units import TIME

    given = o.quantity("--offset", offset, TIME) if offset else None
    wanted = estimate or [], inputs or []
    found = measure(file, log, maps, given, *wanted, output, force, lambda x: typer.echo(f"  {x}", err=True))
    typer.echo(json.dumps(found.data()) if as_json else "\n".join(found.message))
    if not as_json:
        typer.echo(f"wrote {found.recording}" + (f" and {found.scene}" if found.scene else ""))
