"""Arguments and options of several commands, and the parsing of their texts.

What a shell may complete (`heavylift --install-completion`): nothing of it may fail or print; what cannot be looked up
is not offered.
"""

import os
import sys
from collections.abc import Callable, Collection, Iterable, Sequence
from importlib.machinery import PathFinder
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from heavylift.kernel.errors import SceneError

if TYPE_CHECKING:
    from heavylift.coordinator.run.watch import RunObserver
    from heavylift.coordinator.yards.studies import YardStudy
    from heavylift.nodes.scene import LoadedScene
    from heavylift.nodes.scene.text.units import Dimension
    from heavylift.recordings.sheets.sheet import Sheet

LEAST_s = 1.0  # that a process has for an answer
AUTO = 1 << 30  # more processes than anybody has: as many as pay


def process_count(text: str | int) -> int:
    """Read the number of processes from the text of an option; `auto` becomes AUTO, which means that the fastest number
    is measured."""
    if text == "auto":
        return AUTO
    try:
        return int(text)
    except ValueError:
        raise typer.BadParameter(f"{text!r} is not a number of processes; give an integer or auto") from None


def paying_processes(
    asked: int, models: int, run: "Callable[[int, RunObserver], object]", elsewhere: Collection[str] | None = None
) -> int:
    """Return the number of processes for a run: `asked` or, if that is AUTO, the fastest number in trial runs."""
    if asked != AUTO:
        return asked
    if elsewhere:
        raise typer.BadParameter(
            "--processes auto measures processes on this computer only; leave out --remote and --external"
        )
    from .process_count import paying

    count, found = paying(run, models)
    typer.echo(f"--processes auto: {count}, for {found}", err=True)
    return count


def one_process(in_process: bool, processes: int, places: Sequence[str] | None) -> bool:
    """Check the option --in-process against the other options, and return it; raises BadParameter if they contradict
    each other."""
    if in_process and (processes or places):
        raise typer.BadParameter("--in-process: all models run in this process; leave out --processes and --place")
    return in_process


def scene_names(incomplete: str) -> list[str]:
    """Return, for shell completion, the names of bundled scenes and the paths of scene files."""
    from heavylift.nodes.scenes import bundled

    return [name for name in bundled() if name.startswith(incomplete)] + _files(incomplete, (".yaml", ".yml"))


def recording_files(incomplete: str) -> list[str]:
    """Return, for shell completion, the paths of recordings, including cut-off ones."""
    return _files(incomplete, (".mcap", ".mcap.part"))


def run_names(incomplete: str) -> list[str]:
    """Return, for shell completion, the recordings of this user's runs in progress, relative to the current folder."""
    from heavylift.coordinator.live import running

    here = Path.cwd()
    written = [Path(found.notice.recording) for found in running() if found.notice.recording]
    shown = [str(path.relative_to(here)) if path.is_relative_to(here) else str(path) for path in written]
    return [path for path in shown if path.startswith(incomplete)]


def _files(incomplete: str, suffixes: tuple[str, ...]) -> list[str]:
    """Return matching files with these suffixes, and folders that may contain them."""
    folder, _, begun = incomplete.rpartition("/")
    where = f"{folder}/" if "/" in incomplete else ""
    try:
        found = sorted(Path(where or ".").iterdir())
    except OSError:
        return []
    fits = [path for path in found if path.name.startswith(begun) and (begun or not path.name.startswith("."))]
    return [f"{where}{p.name}{'/' if p.is_dir() else ''}" for p in fits if p.is_dir() or p.name.endswith(suffixes)]


Scene = Annotated[
    str,
    typer.Argument(
        help="a scene file, or the name of a bundled scene such as turnover or lift", autocompletion=scene_names
    ),
]
File = Annotated[Path, typer.Argument(help="a recording (.mcap)", autocompletion=recording_files)]
Run = Annotated[
    str,
    typer.Argument(
        help="the recording that it writes, its run id, or its scene; default the only one", autocompletion=run_names
    ),
]
At = Annotated[float | None, typer.Option("--at", help="time of the run [s]; default its start")]
After = Annotated[str, typer.Option("--after", help="at the end of this stage of the run")]
Json = Annotated[bool, typer.Option("--json", help="one JSON object, SI units")]
Deadline = Annotated[str, typer.Option("--deadline", help="for a process to show progress")]
Processes = Annotated[
    int,
    typer.Option(
        "--processes",
        help="deal the models out over so many processes, or as many as pay",
        parser=process_count,
        metavar="N|auto",
    ),
]
Places = Annotated[
    list[str] | None, typer.Option("--place", help="models that share a process: --place 'west,east=yard-a'")
]
Remote = Annotated[list[str] | None, typer.Option("--remote", help="this process runs on another host")]
External = Annotated[
    list[str] | None,
    typer.Option("--external", help="a program of another kind plays this process; writes NAME.ticket (WIRE.md)"),
]
Listen = Annotated[str, typer.Option("--listen", help="tls/ADDRESS:PORT for processes of other hosts")]
InProcess = Annotated[bool, typer.Option("--in-process", help="all models in this process")]
Certificates = Annotated[
    Path, typer.Option("--certificates", help="directory made by 'heavylift certificates'", show_default=True)
]
Verbose = Annotated[bool, typer.Option("--verbose", help="also digest, wall-clock times and energy balance")]
Strict = Annotated[bool, typer.Option("--strict", help="exit code 1 if the verdict is red or undecided")]
FailOn = Annotated[
    Literal["", "red", "undecided", "amber"],
    typer.Option("--fail-on", help="exit code 1 if the verdict is that or worse"),
]
Force = Annotated[bool, typer.Option("--force", help="replace an earlier output of this name")]
Sets = Annotated[list[str] | None, typer.Option("--set", help="override a key: --set accuracy=0.5%")]


def written_to(help: str) -> Any:
    """Return the definition of a command's option -o, which names the file or folder to write."""
    return typer.Option("-o", "--output", help=help)


def scene_of(scene: str, sets: list[str] | None) -> "LoadedScene":
    """Load a scene and apply the settings given by `--set`."""
    from heavylift.nodes.scene import load

    return load(scene, sets or [])


BOTH = {"scene", "a", "b", "strict", "fail_on", "as_json", "sets"}  # parameters for scenes and yard files


def yard_file(context: typer.Context, scene: str, allowed: Collection[str], only: Collection[str] = ()) -> bool:
    """Return whether a file is a yard file; raises BadParameter for an option that does not apply to this kind of file.

    `allowed`: further options for yard files; `only`: options for yard files only.
    """
    from heavylift.nodes.yard.beginning import is_yard

    found = is_yard(scene)
    kind = "scenes, and this is a yard file" if found else "yard files, and this is a scene"
    for parameter in given(context):
        name = str(parameter.name)
        if name not in {*BOTH, *allowed, *only} if found else name in only:
            raise typer.BadParameter(f"{parameter.opts[0]} is for {kind}; leave it out")
    return found


def given(context: typer.Context) -> "list[Any]":
    """Return the parameters of a command that are given on the command line."""
    sources = [(x, context.get_parameter_source(str(x.name))) for x in context.command.params]
    return [x for x, source in sources if source and source.name == "COMMANDLINE"]


def find_own_modules(references: Iterable[str]) -> None:
    """Append the current folder to Python's module path if a reference names a module in it."""
    names = (text.partition(":")[0].rpartition("=")[2].partition(".")[0] for text in references)
    if os.getcwd() not in sys.path and any(PathFinder.find_spec(name, [os.getcwd()]) for name in names if name):
        sys.path.append(os.getcwd())


def tell(sheet: "Sheet", as_json: bool) -> None:
    """Print a result sheet as text or as JSON."""
    import msgspec
    from heavylift.recordings.sheets.sheet import data_of, part_text

    lines = [f"{sheet.title}\n{sheet.lead}", *filter(None, map(part_text, sheet.parts))]
    typer.echo(msgspec.json.encode(data_of(sheet)).decode() if as_json else "\n\n".join(lines))


def study_of(
    file: str, sets: list[str] | None, count: int, seed: int = 1, workers: int = 0, executor: Any = None
) -> "YardStudy":
    """Return the study of a yard file, which makes `count` replications and prints a line for each variant."""
    from heavylift.coordinator.yards.studies import YardStudy

    def say(text: str) -> None:
        typer.echo(f"  {text}", err=True)

    return YardStudy(file, tuple(sets or ()), count, seed, executor, workers, say)


def tell_study(sheet: "Sheet", output: Path | None, force: bool, as_json: bool) -> None:
    """Print the result sheet of a yard's study, and write it to a file if requested."""
    tell(sheet, as_json)
    if output:
        from heavylift.recordings.sheets.workbook import write

        typer.echo(f"wrote {write(sheet, output, 'a study', force)}", err=True)


def browse(url: str) -> None:
    """Print the address of a page, and open a browser if there is a display."""
    typer.echo(f"watch it at {url}", err=True)
    display = sys.platform != "linux" or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.stderr.isatty() and display:
        import webbrowser

        webbrowser.open(url)


def quantity(option: str, text: str, dimension: "Dimension") -> float:
    """Read the value of an option, in SI units; raises SceneError if it is not a quantity of this dimension."""
    try:
        return dimension.read(text)
    except ValueError as error:
        raise SceneError(f"{option} '{text}': {error}") from None


def duration_s(option: str, text: str) -> float:
    """Read a non-negative simulation time [s]."""
    from heavylift.nodes.devs import NEVER
    from heavylift.nodes.scene.text.units import TIME

    length = quantity(option, text, TIME)
    if length < 0.0:
        raise SceneError(f"{option} {text}: a time must be zero or more")
    return min(length, NEVER * 1e-9)


def wall_s(option: str, text: str) -> float:
    """Read a wall-clock duration [s]."""
    from heavylift.nodes.scene.text.units import DURATION

    return quantity(option, text, DURATION)


def deadline_s(text: str) -> float:
    """Read --deadline, the time [s] within which a process must show progress; raises SceneError if it is too short."""
    seconds = wall_s("--deadline", text)
    if seconds < LEAST_s:
        raise SceneError(f"--deadline '{text}': a process needs at least {LEAST_s:g} s")
    return seconds


def end_by(strict: bool, fail_on: str, *states: str) -> None:
    """End the command with exit code 1 if a verdict has one of the states that --strict or --fail-on rejects."""
    worst = {"red": 1, "undecided": 2, "amber": 3}
    if min(worst.get(state, 4) for state in (*states, "")) <= max(2 * strict, worst.get(fail_on, 0)):
        raise typer.Exit(1)
