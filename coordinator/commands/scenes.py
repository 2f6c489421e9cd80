"""Commands for a scene without a run: check, tree, equations, statics, modes, tradeoff, types, new, gallery, ..."""

import json
from pathlib import Path
from typing import Annotated, Literal

import msgspec
import typer
from heavylift.coordinator.commands.common import options as o
from heavylift.coordinator.commands.common.app import app
from heavylift.kernel.errors import SceneError


@app.command()
def check(
    context: typer.Context,
    scene: o.Scene,
    strict: o.Strict = False,
    fail_on: o.FailOn = "",
    verbose: Annotated[bool, typer.Option("--verbose", help="every check, with its limit and source")] = False,
    as_json: o.Json = False,
    sets: o.Sets = None,
) -> None:
    """Check a scene without running it; show static loads and modelled effects.    heavylift check lift

    Exit code 1 if the scene cannot run, or if a check is red at rest, such as a contact that no order allows. Of a yard
    file: its schedules with expected durations.
    """
    if o.yard_file(context, scene, ()):
        from heavylift.coordinator.yards.model import load_yard
        from heavylift.nodes.yard.answers import examined

        sheet = examined(load_yard(scene, sets or []))
        o.tell(sheet, as_json)
        o.end_by(strict, fail_on or "red", sheet.state)
        return
    from heavylift.coordinator.ladder.choosing import known
    from heavylift.coordinator.participants.mechanics_at import check_steps
    from heavylift.coordinator.transport.placement import Placement
    from heavylift.coordinator.verdict.judging import near_at_rest
    from heavylift.coordinator.verdict.worst_corners import with_worst_clearances
    from heavylift.nodes.models import node_names
    from heavylift.nodes.plan.fidelity import percent
    from heavylift.nodes.scene import check as examine

    loaded = with_worst_clearances(o.scene_of(scene, sets))
    check_steps(loaded)
    found, answer = examine(loaded, near_at_rest(loaded.plan, loaded.statics)), known(loaded)
    if as_json:
        message: dict[str, object] = msgspec.to_builtins(found)
        own = {key: message.pop(key) for key in ("state", "line", "checks", "tables", "lines")}
        del own["lines"], message["brief"]
        message |= {"verdict": {"red": found.state == "red", **own}}  # as of a run
        message |= {"modelled": msgspec.to_builtins(answer) | {"told": str(answer)} if answer else None}
        typer.echo(msgspec.json.encode(message).decode())
    else:
        lines = [*(found.lines if verbose else found.brief)]
        if loaded.facts.ask:
            lines.append(f"\nasked: {', '.join(loaded.facts.ask)}, to {percent(loaded.facts.accuracy)} of each")
            lines.append(f"  {answer or 'errors are not measured yet; the first run measures them'}")
        crowd = Placement.of(node_names(loaded.plan), loaded.facts.placement).crowd
        typer.echo("\n".join([*lines, *([f"\n  {crowd}"] if crowd else [])]))
    o.end_by(strict, fail_on or "red", found.state)


@app.command()
def tree(scene: o.Scene, as_json: o.Json = False, sets: o.Sets = None) -> None:
    """Print the tree of DEVS models.    heavylift tree turnover"""
    from heavylift.nodes.models import tree as draw, tree_data

    plan = o.scene_of(scene, sets).plan
    typer.echo(json.dumps(tree_data(plan)) if as_json else draw(plan))


@app.command()
def equations(
    scene: o.Scene,
    formulation: Annotated[
        str, typer.Option("--formulation", help="recursive, articulated, embedding or augmented")
    ] = "recursive",
    latex: Annotated[bool, typer.Option("--latex", help="a LaTeX document")] = False,
    sets: o.Sets = None,
) -> None:
    """Print graph, path matrix and equations of motion, body by body.    heavylift equations arm"""
    from heavylift.kernel.equations import equations as write
    from heavylift.nodes.models import system

    plan = o.scene_of(scene, sets).plan
    typer.echo(write(system(plan), formulation, latex, f"Equations of motion: {plan.name}"))


@app.command()
def statics(scene: o.Scene, at: o.At = None, after: o.After = "", as_json: o.Json = False, sets: o.Sets = None) -> None:
    """Find the equilibrium of a scene, and the loads in ropes, pads and joints.    heavylift statics lift"""
    from heavylift.coordinator.participants.mechanics_at import at_rest
    from heavylift.kernel.analysis import modes as about, reactions
    from heavylift.kernel.analysis.modes import statics_data, statics_text

    found, simulation = at_rest(o.scene_of(scene, sets), at, after)
    shown = found, reactions(simulation), about(simulation).growth
    notes = [note.sentence for note in simulation.notes]
    message = "\n".join([statics_text(*shown), *(f"note: {note}" for note in notes)])
    typer.echo(json.dumps(statics_data(*shown) | {"notes": notes}) if as_json else message)


@app.command()
def modes(scene: o.Scene, at: o.At = None, after: o.After = "", as_json: o.Json = False, sets: o.Sets = None) -> None:
    """Show frequencies, damping and modes about the equilibrium.    heavylift modes lift --after up"""
    from heavylift.coordinator.participants.mechanics_at import at_rest
    from heavylift.kernel.analysis import modes as about
    from heavylift.kernel.analysis.modes import modes_data, modes_text

    _, simulation = at_rest(o.scene_of(scene, sets), at, after)
    found = about(simulation)
    typer.echo(json.dumps(modes_data(found)) if as_json else modes_text(found))


@app.command()
def tradeoff(
    scene: o.Scene,
    output: Annotated[
        list[Path] | None, o.written_to("report: .html, .png, .svg, .csv, .json; default NAME-tradeoff.html")
    ] = None,
    force: o.Force = False,
    ask: Annotated[str, typer.Option("--ask", help="what must be right: --ask 'rope tension, swing'")] = "",
    accuracy: Annotated[
        str, typer.Option("--accuracy", help="of each quantity asked; default the scene's own if it asks, else 1 %")
    ] = "",
    budget: Annotated[str, typer.Option("--budget", help="wall time for all runs")] = "5 min",
    coupling: Annotated[
        bool, typer.Option("--coupling", help="also what processes cost: held forces, messages")
    ] = False,
    sets: o.Sets = None,
    as_json: o.Json = False,
) -> None:
    """Measure speed against accuracy for all model levels and steps.    heavylift tradeoff lift --ask swing"""
    from heavylift.coordinator.ladder.page import checked, data, write
    from heavylift.coordinator.ladder.tradeoff import measure
    from heavylift.coordinator.trace.communication import communicating, hanging
    from heavylift.nodes.scene.text.units import ACCURACY

    loaded = o.scene_of(scene, sets)
    outputs = [checked(path) for path in output or ([] if as_json else [Path(f"{loaded.plan.name}-tradeoff.html")])]
    limit = o.quantity("--accuracy", accuracy, ACCURACY) if accuracy else None
    seconds = o.wall_s("--budget", budget)
    if coupling:
        hanging(loaded)
    measured = measure(loaded, ask, limit, seconds, lambda message: typer.echo(f"  {message}", err=True))
    if coupling:
        measured = communicating(loaded, measured)
    outputs = [write(measured, path, force) for path in outputs]
    if as_json:
        typer.echo(json.dumps(data(measured)))
        return
    for line in (measured.advice, *([f"  {measured.pick.command}"] if measured.pick else [])):
        typer.echo(line)
    for path in outputs:
        typer.echo(f"wrote {path}")


@app.command()
def types(
    name: Annotated[str, typer.Argument(help="a type whose file is printed, to copy and to change")] = "",
    as_json: o.Json = False,
) -> None:
    """List the types of cranes and vessels that come with heavylift, or print one.    heavylift types jib-60"""
    from heavylift.nodes.scene.text.machine_types import library, machine_type, vessel_types
    from heavylift.nodes.scenes import vessels_folder

    if name in vessel_types():
        typer.echo((vessels_folder() / f"{name}.yaml").read_text(encoding="utf-8"), nl=False)
        return
    if name:
        machine_type(name)
        typer.echo(library()[name].read_text(encoding="utf-8"), nl=False)
        return
    keys = ("about", "capacity", "source")
    found = {each: {key: machine_type(each).about(key) for key in keys} for each in library()}
    found |= {each: {key: str(data[key]) for key in keys} for each, data in vessel_types().items()}
    if as_json:
        typer.echo(json.dumps(found))
        return
    for each, text in found.items():
        typer.echo(f"{each}: {text['about']}\n    capacity: {text['capacity']}\n    source: {text['source']}")


@app.command()
def new(
    name: Annotated[str, typer.Argument(help="of the scene; it is written to NAME.yaml")],
    like: Annotated[
        str, typer.Option("--like", help="bundled scene that it begins as", autocompletion=o.scene_names)
    ] = "lift",
    crane: Annotated[str, typer.Option("--crane", help="crane type that lifts the blocks of --blocks")] = "",
    blocks: Annotated[str, typer.Option("--blocks", help="table of blocks in this folder, or blocks.csv#B17")] = "",
) -> None:
    """Write a scene to start from, with comments.    heavylift new my-lift"""
    from heavylift.coordinator.run.progress import command
    from heavylift.nodes.scene import new_scene, new_scene_with

    if bool(crane) != bool(blocks):
        raise SceneError("--crane and --blocks belong together; give both, such as --crane jib-60 --blocks blocks.csv")
    path = Path()
    for made, text in (new_scene_with(name, crane, blocks) if crane else {name: new_scene(name, like)}).items():
        path = Path(f"{made}.yaml")
        try:
            with path.open("x", encoding="utf-8") as file:
                file.write(text)
        except FileExistsError:
            raise SceneError(f"{path}: exists already and will not be overwritten; choose another name") from None
        except OSError as error:
            raise SceneError(f"{path}: the file cannot be written ({error.strerror}); choose another folder") from None
        typer.echo(f"wrote {path}")
    typer.echo(f"\nnext: {command()} check {path}")


@app.command()
def workbench(
    scene: Annotated[
        str,
        typer.Argument(
            metavar="[FOLDER | SCENE]",
            help="a folder with scenes, a scene file, or a bundled scene",
            autocompletion=o.scene_names,
        ),
    ] = ".",
) -> None:
    """See and change scenes in a browser, drawn and checked with each save.    heavylift workbench my-lift.yaml

    Any editor may change the files meanwhile. The page is for this machine only; Ctrl-C ends it.
    """
    from heavylift.kernel.errors import extra

    for package in ("starlette", "uvicorn", "watchfiles"):
        extra(
            package,
            SceneError("the workbench needs Starlette, uvicorn and watchfiles: pip install 'heavylift[workbench]'"),
        )
    from heavylift.coordinator.workbench.server import workbench as serve

    serve(scene, o.browse)


@app.command()
def gallery(
    scenes: Annotated[
        list[str] | None,
        typer.Argument(help="scene files or names; default all bundled ones", autocompletion=o.scene_names),
    ] = None,
    output: Annotated[Path, o.written_to("folder for GALLERY.md and pictures")] = Path("gallery"),
    force: o.Force = False,
) -> None:
    """Run scenes and write a page with a picture of each.    heavylift gallery lift tandem -o my-gallery"""
    from heavylift.nodes.scene import bundled, load
    from heavylift.recordings.write.partfile import written

    from .gallery import draw, draw_yard, page

    loaded = [load(scene) for scene in scenes or bundled()]
    for scene in loaded:
        typer.echo(f"wrote {draw(scene, output / 'pictures', force)}")
    if not scenes:
        typer.echo(f"wrote {draw_yard(output / 'pictures', force)}")
    typer.echo(f"wrote {written(page(loaded), output / 'GALLERY.md', 'a page', ('.md',), force)}")


@app.command()
def hull(
    data: Annotated[
        Path, typer.Argument(help="netCDF of Capytaine, Nemoh.cal, NAME.1 of WAMIT, or a mesh, z up from the waterline")
    ],
    output: Annotated[Path | None, o.written_to("file of the hull; default NAME.json")] = None,
    volume: Annotated[float, typer.Option(help="displaced [m3], for WAMIT without NAME.out", min=0.0)] = 0.0,
    height: Annotated[float, typer.Option(help="of the centre of mass over the waterline [m], for WAMIT")] = 0.0,
    length: Annotated[float, typer.Option(help="ULEN [m], for WAMIT", min=1e-6)] = 1.0,
    depth: Annotated[
        float | None, typer.Option(help="of the water [m], for WAMIT or a mesh; default deep", min=1e-3)
    ] = None,
    drift: Annotated[Path | None, typer.Option(help="NAME.8 or .9 of WAMIT: mean drift")] = None,
    gap_damping: Annotated[
        float | None, typer.Option(help="of the water between two hulls, part of critical", min=0.0, max=1.0)
    ] = None,
    gap_source: Annotated[str, typer.Option(help="where the gap damping comes from, such as a model test")] = "",
    force: o.Force = False,
) -> None:
    """Convert hydrodynamic data of a hull into a file for `hydrodynamics:`.    heavylift hull barge.nc -o barge.json"""
    import msgspec
    from heavylift.nodes.sea.coefficients import computed, hull_of
    from heavylift.nodes.sea.gap_damping import with_gap_damping
    from heavylift.recordings.write.partfile import written

    wamit, mesh = data.suffix == ".1", data.suffix not in (".nc", ".cal", ".1")
    idle = {
        "--depth": depth is not None and not (wamit or mesh), "--volume": volume and not wamit,
        "--height": height and not wamit, "--length": length != 1.0 and not (wamit or drift),
    }  # fmt: skip
    if names := [name for name, given in idle.items() if given]:
        raise SceneError(f"{data}: hydrodynamic data in this format take no {' or '.join(names)}; leave the option out")
    if (gap_damping is None) == bool(gap_source):
        raise SceneError(f"{data}: give --gap-damping together with --gap-source (its origin), or neither")
    given = computed(data, depth) if mesh else data
    found = hull_of(given, volume, height, length, depth, drift)
    if gap_damping is not None:
        found = with_gap_damping(found, gap_damping, gap_source)
    error = found.radiation.error
    text = msgspec.json.format(msgspec.json.encode(found), indent=0).decode() + "\n"
    typer.echo(f"wrote {written(text, output or Path(f'{found.name}.json'), 'a hull', ('.json',), force)}")
    typer.echo(f"radiation of {len(found.radiation.F)} states misses {error.added_mass:.1%} of added mass, "
               f"{error.damping:.1%} of damping")  # fmt: skip


@app.command()
def schema() -> None:
    """Print the JSON Schema of scene files, for completion in editors.    heavylift schema > heavylift.schema.json"""
    from heavylift.nodes.scene import json_schema

    typer.echo(json.dumps(json_schema(), indent=2))


@app.command("export-fmu")
def export_fmu(
    scene: o.Scene,
    output: Annotated[Path | None, o.written_to("unit; default NAME.fmu")] = None,
    inputs: Annotated[
        list[str] | None,
        typer.Option("--input", help="Drive, winch or `wind` whose speed is an input; repeatable.", metavar="NAME"),
    ] = None,
    fmi: Annotated[Literal["2", "3"], typer.Option(help="Version; 3 returns early at events.")] = "2",
    force: o.Force = False,
    sets: o.Sets = None,
) -> None:
    """Write a scene as a co-simulation unit of FMI 2.0 or 3.0.    heavylift export-fmu lift -o lift.fmu

    Inputs are commands and the speeds that `--input` names; outputs are all signals. The FMU needs this installation of
    heavylift.
    """
    from heavylift.coordinator.ladder.choosing import chosen

    loaded = o.scene_of(scene, sets)
    try:
        from heavylift.coordinator.run.units.exporting import export

        made = export(chosen(loaded), output or Path(f"{loaded.plan.name}.fmu"), force, inputs or (), fmi)
    except ImportError:
        raise SceneError("an FMU is made with pythonfmu: pip install 'heavylift[fmi]'") from None
    typer.echo(f"wrote {made}")
