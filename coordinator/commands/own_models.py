"""Models of your own: `heavylift devs` runs any DEVS model, `heavylift trust` lets Python code of a folder run."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import msgspec
import typer
from heavylift.coordinator.commands.common import options as o
from heavylift.coordinator.commands.common.app import app

from .hosts import open_listener

if TYPE_CHECKING:
    from heavylift.coordinator.run.replications import Replications


@app.command()
def devs(
    model: Annotated[str, typer.Argument(help="module:function or file.py:function that returns a Coupled")],
    until: Annotated[str, typer.Option("--until", help="end of simulation: --until 10s; default no activity")] = "",
    output: Annotated[Path | None, o.written_to("recording; default none")] = None,
    force: o.Force = False,
    processes: o.Processes = 0,
    places: o.Places = None,
    remote: o.Remote = None,
    external: o.External = None,
    listen: o.Listen = "",
    keys: o.Certificates = Path("certificates"),
    in_process: o.InProcess = False,
    stop: Annotated[str, typer.Option("--stop", help="child.port: its first message ends the run")] = "",
    replications: Annotated[
        int | None, typer.Option("--replications", help="runs with seeds, for means of results", show_default=False)
    ] = None,
    seed: Annotated[int | None, typer.Option("--seed", help="for the model's parameter `seed`; default 1")] = None,
    microsteps: Annotated[int, typer.Option("--microsteps", help="so many steps in no time are a loop")] = 10_000,
    deadline: o.Deadline = "60 s",
    as_json: o.Json = False,
) -> None:
    """Run a DEVS model, one process per child.    heavylift devs my_models:build --until 10s -o run.mcap"""
    from heavylift.coordinator.participants.building import built, seeded
    from heavylift.coordinator.run.models import run_models
    from heavylift.coordinator.run.replications import replicate
    from heavylift.coordinator.run.watch import RunObserver
    from heavylift.kernel.errors import printable

    o.find_own_modules([model])
    end = o.duration_s("--until", until) if until else None
    patience = o.deadline_s(deadline)
    if replications is not None:
        if output or places or remote or external or listen or in_process:
            raise typer.BadParameter(
                "each of the --replications runs in one process, without a recording; leave out -o, --place, --remote, "
                "--external, --listen and --in-process"
            )
        workers = 0 if processes == o.AUTO else processes
        found = replicate(model, replications, 1 if seed is None else seed, end, stop, microsteps, workers=workers)
        typer.echo(_replications(found, as_json))
        return
    if seed is not None:
        model = seeded(model, seed)
    away = frozenset(remote or [])
    listener = open_listener(away, listen, keys, o.one_process(in_process, processes, places), external or ())

    class Aloud(RunObserver):
        def say(self, sentence: str) -> None:
            print(printable(sentence), file=sys.stderr)

    def tried(count: int, watch: RunObserver) -> object:
        return run_models(model, end, watch=watch, processes=count, microsteps=microsteps, deadline=patience, stop=stop)

    if not (in_process or places):
        processes = o.paying_processes(processes, len(built(model).children), tried, [*away, *(external or ())])
    run = run_models(
        model, end, output, in_process, watch=Aloud(), processes=processes, microsteps=microsteps, force=force,
        deadline=patience, places=places or (), remote=away, listener=listener, stop=stop, external=external or (),
    )  # fmt: skip
    if as_json:
        row = {**msgspec.to_builtins(run, enc_hook=str), "outcome": run.outcome.name.lower()}
        typer.echo(msgspec.json.encode(row).decode())
        return
    typer.echo(f"last event at {run.sim_s:g} s; {run.outcome.value}")
    typer.echo(f"{run.grants} grants in {run.wall_s:.2f} s\ndigest {run.digest}")
    for path, result in run.results.items():
        typer.echo(f"{path}: {result}")
    if run.recording is not None:
        typer.echo(f"wrote {run.recording}")


def _replications(found: "Replications", as_json: bool) -> str:
    """Return estimates of replicated runs as JSON with all single results, or as a table."""
    from heavylift.recordings.sheets.sheet import listed

    if as_json:
        return msgspec.json.encode({**msgspec.to_builtins(found), "estimates": found.estimates}).decode()
    rows = [[name, f"{x.mean:.6g}", f"+- {x.half:.2g}", f"{x.deviation:.3g}"] for name, x in found.estimates.items()]
    head = [f"{len(found.seeds)} runs", "mean", f"{100 * found.confidence:g} %", "deviation"]
    return listed(head, rows) or "no atomic has a number in its result()"


@app.command()
def trust(
    folder: Annotated[Path | None, typer.Argument(help="folder with Python code; default: list those trusted")] = None,
    withdraw: Annotated[bool, typer.Option("--withdraw", help="trust it no longer")] = False,
    listed: Annotated[bool, typer.Option("--list", help="list the trusted folders")] = False,
) -> None:
    """Allow Python code in a folder to run when scenes or recordings name it.    heavylift trust my_laws"""
    from heavylift.kernel import trust as kept

    if folder is not None:
        if withdraw:
            typer.echo(f"no longer trusted: {kept.withdraw(folder)}", err=True)
        else:
            typer.echo(f"trusted: {kept.trust(folder)}; `heavylift trust --withdraw` takes it back", err=True)
    elif withdraw:
        raise typer.BadParameter("name the folder whose trust is to be withdrawn")
    if listed or folder is None:
        for each in kept.trusted():
            typer.echo(each)
