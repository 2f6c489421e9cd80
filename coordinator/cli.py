"""The command line: `heavylift COMMAND`; every command says what to type next, every error is one sentence.

Exit codes: 0 done; 1 the run or the file failed; 2 the command line is wrong; 130 stopped by Ctrl-C.
"""

from __future__ import annotations

import sys
import tempfile
import traceback
from pathlib import Path
from typing import Annotated

import typer
from heavylift.kernel.errors import HeavyliftError, Stopped

__all__ = ["main"]

app = typer.Typer(
    add_completion=True,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    help="Simulates tandem crane lifts: one scene file, one process per model, every message on record.",
)

Scene = Annotated[
    str, typer.Argument(help="a scene file, or the name of a bundled scene (turnover, lift, arm, pendulum)")
]
File = Annotated[Path, typer.Argument(help="a recording (.mcap)")]
At = Annotated[float | None, typer.Option("--at", help="time of the run [s]; default its start")]
After = Annotated[str, typer.Option("--after", help="at the end of this stage of the run")]
Json = Annotated[bool, typer.Option("--json", help="one JSON object, SI units")]
Sets = Annotated[list[str] | None, typer.Option("--set", help="override a key: --set accuracy=0.5%")]


@app.command()
def run(
    scene: Scene,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="recording; default NAME.mcap")] = None,
    sets: Sets = None,
    in_process: Annotated[bool, typer.Option("--in-process", help="all models in this process")] = False,
    method: Annotated[str, typer.Option("--method", help="of integration: dopri5, radau5, ...")] = "",
    step: Annotated[str, typer.Option("--step", help="fixed steps: --step '2 ms'")] = "",
) -> None:
    """Simulate a scene and record it.    heavylift run turnover -o monday.mcap"""
    from .participant import PRELOAD
    from .processes import Processes

    crew = None if in_process else Processes(PRELOAD)  # starts while the rest is imported
    try:
        from heavylift.nodes.scene import load

        from .progress import Progress, summary
        from .run import run as simulate

        given = [f"{key}={text}" for key, text in (("method", method), ("step", step)) if text]
        loaded = load(scene, [*(sets or []), *given])
        path = output or Path(f"{loaded.plan.name}.mcap")
        with Progress(loaded.plan) as watch:
            result = simulate(loaded, path, in_process, watch, crew)
    finally:
        if crew is not None:
            crew.end()
    summary(loaded.plan, result, path)


@app.command()
def check(scene: Scene, sets: Sets = None) -> None:
    """Check a scene and show its static loads; starts nothing.    heavylift check my-lift.yaml"""
    from heavylift.nodes.scene import check as examine
    from heavylift.nodes.scene import load

    typer.echo(str(examine(load(scene, sets or []))))


@app.command()
def tree(scene: Scene, sets: Sets = None) -> None:
    """Print the tree of DEVS models.    heavylift tree turnover"""
    from heavylift.nodes.models import tree as draw
    from heavylift.nodes.scene import load

    typer.echo(draw(load(scene, sets or []).plan))


@app.command()
def equations(
    scene: Scene,
    formulation: Annotated[
        str, typer.Option("--formulation", help="recursive, articulated, embedding or augmented")
    ] = "recursive",
    latex: Annotated[bool, typer.Option("--latex", help="a LaTeX document")] = False,
    sets: Sets = None,
) -> None:
    """Print graph, path matrix and the equations of motion, body by body.    heavylift equations arm"""
    from heavylift.kernel.equations import equations as write
    from heavylift.nodes.models import system
    from heavylift.nodes.scene import load

    plan = load(scene, sets or []).plan
    typer.echo(write(system(plan), formulation, latex, f"Equations of motion: {plan.name}"))


@app.command()
def statics(scene: Scene, at: At = None, after: After = "", as_json: Json = False, sets: Sets = None) -> None:
    """Find where a scene comes to rest, and what ropes, pads and joints then carry.    heavylift statics lift"""
    import json

    from heavylift.kernel.analysis import equilibrium, reactions
    from heavylift.kernel.analysis import modes as about
    from heavylift.kernel.analysis.tables import statics_data, statics_text
    from heavylift.nodes.scene import load

    from .pause import paused

    simulation = paused(load(scene, sets or []), at, after)
    found = equilibrium(simulation)
    shown = found, reactions(simulation), about(simulation).growth
    typer.echo(json.dumps(statics_data(*shown)) if as_json else statics_text(*shown))


@app.command()
def modes(scene: Scene, at: At = None, after: After = "", as_json: Json = False, sets: Sets = None) -> None:
    """Show frequencies, damping and modes about the pose at rest.    heavylift modes turnover --after "hoist" """
    import json

    from heavylift.kernel.analysis import equilibrium
    from heavylift.kernel.analysis import modes as about
    from heavylift.kernel.analysis.tables import modes_data, modes_text
    from heavylift.nodes.scene import load

    from .pause import paused

    simulation = paused(load(scene, sets or []), at, after)
    equilibrium(simulation)
    found = about(simulation)
    typer.echo(json.dumps(modes_data(found)) if as_json else modes_text(found))


@app.command()
def info(file: File) -> None:
    """Say what a recording holds.    heavylift info turnover.mcap"""
    from heavylift.recordings import info as describe

    typer.echo(describe(file))


@app.command()
def plot(
    file: File,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="picture, .png or .svg")] = None,
    lift: Annotated[bool, typer.Option("--lift", help="the lift itself at some instants")] = False,
) -> None:
    """Draw the rope tensions of a recording.    heavylift plot turnover.mcap -o tension.svg"""
    from heavylift.recordings import plot as tensions
    from heavylift.recordings import storyboard

    draw = storyboard if lift else tensions
    typer.echo(f"wrote {draw(file, output or file.with_suffix('.png'))}")


@app.command()
def view(
    file: File,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="page; default NAME.html")] = None,
) -> None:
    """Write one page with the lift in 3D, signals, stages, events.    heavylift view turnover.mcap"""
    from heavylift.recordings import view as write

    typer.echo(f"wrote {write(file, output or file.with_suffix('.html'))}; open it in a browser")


@app.command()
def report(
    file: File,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="document; default NAME-report.html")] = None,
) -> None:
    """Write the planner's document: ropes, cranes, stages, warnings.    heavylift report turnover.mcap"""
    from heavylift.recordings import report as write

    typer.echo(f"wrote {write(file, output or file.with_name(file.stem + '-report.html'))}; open it in a browser")


@app.command()
def compare(
    a: File,
    b: File,
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object")] = False,
) -> None:
    """Say whether two runs are equal (exit code 0) or where they part (1).    heavylift compare a.mcap b.mcap"""
    import msgspec
    from heavylift.recordings import compare as side_by_side

    found = side_by_side(a, b)
    typer.echo(msgspec.json.encode(found, enc_hook=str).decode() if as_json else str(found))
    if not found.equal:
        raise typer.Exit(1)


@app.command()
def export(
    file: File,
    output: Annotated[Path, typer.Option("-o", "--output", help="table, .csv or .parquet")],
    signals: Annotated[
        list[str] | None, typer.Option("--signal", help="signal or pattern, such as 'rope/tension/*'; default all")
    ] = None,
) -> None:
    """Write signals as a table, units in the names.    heavylift export turnover.mcap -o turnover.csv"""
    from heavylift.recordings import export as write

    typer.echo(f"wrote {write(file, output, signals or [])}")


@app.command()
def recover(
    file: Annotated[Path, typer.Argument(help="a cut-off or damaged recording (.mcap or .mcap.part)")],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="default NAME-recovered.mcap")] = None,
) -> None:
    """Save what a killed run has left.    heavylift recover turnover.mcap.part"""
    from heavylift.recordings import recover as save

    found = save(file, output)
    typer.echo(f"wrote {found.path}: {found}")


def main() -> None:
    """Entry point of the command `heavylift`."""
    try:
        app(standalone_mode=False)
    except Stopped as error:
        print(f"heavylift: {error}", file=sys.stderr)
        sys.exit(130)
    except HeavyliftError as error:
        print(f"heavylift: {error}" if "\n" not in str(error) else str(error), file=sys.stderr)
        sys.exit(1)
    except typer.Abort:
        sys.exit(130)
    except KeyboardInterrupt:
        print("heavylift: stopped", file=sys.stderr)
        sys.exit(130)
    except Exception as error:
        if hasattr(error, "format_message") and hasattr(error, "exit_code"):  # how click reports a wrong command line
            asked = type(error).__name__ == "NoArgsIsHelpError"
            print(error.format_message() if asked else f"heavylift: {error.format_message()}", file=sys.stderr)
            sys.exit(error.exit_code)
        with tempfile.NamedTemporaryFile("w", prefix="heavylift-", suffix=".txt", delete=False) as file:
            traceback.print_exc(file=file)
        print(
            f"heavylift: internal error, {type(error).__name__}: {error}; this is a defect of heavylift, {file.name} "
            "tells its makers more",
            file=sys.stderr,
        )
        sys.exit(1)
