"""Measures the bundled scenes and writes what was found: settings/SCENE.json and .png, and the page SETTINGS.md.

    python tests/bench/settings.py [--json] [--short] [--budget 300] [SCENE ...]        # or: all

Without the name of a scene only the page is written anew, from the tables that are there; what its tables hold is
printed.  `--short` measures the beginning of a pendulum and writes elsewhere.
"""

from __future__ import annotations

import json
import sys
import tempfile
from functools import partial
from pathlib import Path
from typing import NamedTuple

from heavylift.coordinator.tradeoff import communicating, measure, write
from heavylift.nodes.scene import load
from shared.rows import SHORT, options, row

PAGE = Path(__file__).parents[2] / "nodes/scenes/SETTINGS.md"
HERE = PAGE.parent / "settings"


class Case(NamedTuple):
    """What a scene is asked (else all that it can be), the seconds it takes, settings that it is run under, and why."""

    ask: str = ""
    budget: float = 60.0
    settings: tuple[str, ...] = ()
    why: str = ""


SCENES = {  # all of the gallery but `damper`, which a model leads, and
    # `ramp`: where its crate comes to lie differs between tolerances 1e-8 and 1e-9
    "lift": Case("", 300.0, ("end=100 s",), "with time for every rung to take off and swing"),
    "turnover": Case(
        "rope tension", 600.0, ("end=150 s",), "its beginning: slack, load, the first seconds of the hoist"
    ),
    "tandem": Case("rope tension, swing", 300.0),
    **dict.fromkeys(("pendulum", "arm", "linkage", "girder", "gust", "snatch", "tackle", "trolley"), Case()),
}
HEAD = """# Which setting for which question

Measured by `heavylift tradeoff`, written by `python tests/bench/settings.py`. Each line is the fastest setting that
keeps one quantity within the limit beside it, against the richest rung at a tight tolerance whose own convergence
stands below; the commands can be typed as they are. Speeds are simulated seconds per CPU second of the kernel, and so
are the axes of the figures: compare them with each other. The start of a run, some seconds whatever the setting, is
not in them, and of a short scene it is most of what you wait for: `heavylift tradeoff SCENE` tells both apart.

How to read it
- A rung decides more than a step: where errors stand one above the other in the figure, a tighter tolerance buys
  nothing, and only more of the model does.
- Each quantity has an answer of its own. What is right about the peak can be wrong about the time of lift-off by half
  a stage, so ask what you need and no less.
- A sample above the true peak counts as an error of the tension: peaks are integrated to, samples are interpolated,
  and the interpolant of long steps of high order overshoots. Where you read curves, take 1e-4 or tighter.
- Crosses are settings that heavylift refuses (a step too long for the fastest mode, a method that cannot do the rung)
  or that were cut; the table of `heavylift tradeoff` has the sentence of each.
"""


def main() -> None:
    budget = {"type": float, "help": "seconds for each scene"}
    given = options(__doc__ or "", {"--budget": budget, "scenes": {"nargs": "*", "choices": [*SCENES, "all", []]}})
    if SHORT:
        with tempfile.TemporaryDirectory() as folder:
            case = Case(budget=90.0, settings=("end=1 s",))
            written({"pendulum": case}, ["pendulum"], given.budget, Path(folder), Path(folder) / "SETTINGS.md")
    else:
        written(SCENES, list(SCENES) if "all" in given.scenes else given.scenes, given.budget, HERE, PAGE)


def written(scenes: dict[str, Case], wanted: list[str], budget: float | None, folder: Path, page: Path) -> None:
    """Measure what is wanted; write the page and print its tables."""
    for name in wanted:
        case = scenes[name]
        scene = load(name, case.settings)
        measured = measure(scene, case.ask, budget=budget or case.budget, say=partial(print, file=sys.stderr))
        if scene.followed is not None:
            measured = communicating(scene, measured)
        for kind in ("json", "png"):
            write(measured, folder / f"{name}.{kind}")
    tables = {x: json.loads((folder / f"{x}.json").read_text()) for x in scenes if (folder / f"{x}.json").exists()}
    page.write_text("\n".join([HEAD, *(section(name, scenes[name], told) for name, told in tables.items())]))
    for name, told in tables.items():
        for a in told["answers"]:
            if a["setting"] is not None:
                row(f"{name}, {a['ask']} to {a['limit']:.2g}: {a['setting']}", a["real_time_factor"], "x real time")


def section(name: str, case: Case, told: dict) -> str:
    """A scene's part of the page."""
    given = f", {' '.join(case.settings)} ({case.why})" if case.settings else ""
    lines = [f"## {name}{given}", "", f"{told['verdict']}", "", f"![{name}](settings/{name}.png)", ""]
    lines += ["| asked | to | fastest setting | x real time | error |", "|---|---|---|---|---|"]
    for a in told["answers"]:
        if a["setting"] is None:
            lines.append(f"| {a['ask']} | {100 * a['limit']:g} % | none of those measured | | |")
        else:
            numbers = f"{a['real_time_factor']:.3g} | {100 * a['error']:.2g} %"
            lines.append(f"| {a['ask']} | {100 * a['limit']:g} % | {a['setting']} | {numbers} |")
    commands = list(dict.fromkeys(a["command"] for a in told["answers"] if a["setting"]))
    lines += ["", "```sh", *commands, "```", "", reference(told), ""]
    lines += [*communication(told), ""] if told["held_forces"] else []
    return "\n".join(lines)


def reference(told: dict) -> str:
    """How far the reference can be trusted, and what ran on what."""
    moves = "; ".join(
        f"with {name} it moves {', '.join(f'{q} by {100 * e:.2g} %' for q, e in moved.items())}"
        for name, moved in told["reference"]["moved_by"].items()
    )
    machine, rows = told["machine"], told["settings"]
    failed = sum(bool(row["reason"]) for row in rows)
    return (
        f"Reference: {told['reference']['setting']}; {moves}. {len(rows)} settings, {failed} of them refused, "
        f"unstable or cut; {told['settings_left_out']} did not fit into {told['budget_s']:g} s. "
        f"{machine['processor']}, {machine['cores']} cores, load {machine['load']:.1f}."
    )


def communication(told: dict) -> list[str]:
    """Held forces and processes."""
    lines = ["| forces held between two processes | h | damping measured | -w h/4 |", "|---|---|---|---|"]
    for x in told["held_forces"]:
        numbers = f"{100 * x['measured']:.2f} % | {100 * x['law']:.2f} %"
        lines.append(f"| {x['pair']}, w = {x['omega']:.3g} rad/s | {1e3 * x['h']:g} ms | {numbers} |")
    lines += ["", "| nodes in | wall | without start and end | kernel | grants | beside the kernel, each |"]
    lines.append("|---|---|---|---|---|---|")
    for x in told["distributed"]:
        played = f"{x['wall_s']:.2f} s | {x['wall_s'] - x['around_s']:.2f} s | {x['kernel_s']:.2f} s"
        lines.append(f"| {x['where']} | {played} | {x['grants']} | {1e3 * x['s_per_grant']:.2f} ms |")
    return lines


if __name__ == "__main__":
    main()
