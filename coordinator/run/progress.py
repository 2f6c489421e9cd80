"""Display of a run: a progress bar with stage and real-time factor, and at the end a summary per rope.

Without a terminal the bar becomes one plain line per stage, and Rich is not imported.
"""

import json
import os
import shutil
import sys
import time
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, Self, TextIO

import msgspec
from heavylift.coordinator.record.scene import RunResult
from heavylift.kernel.description.findings import clock
from heavylift.kernel.errors import HeavyliftError, printable
from heavylift.nodes.devs import Event
from heavylift.nodes.limits.checks import governing, likewise, open_checks, scope
from heavylift.nodes.limits.named import rated
from heavylift.nodes.plan.fidelity import Answer
from heavylift.nodes.plan.plan import Plan
from heavylift.recordings.read.verdict import RecordedVerdict
from heavylift.recordings.sheets.sheet import Table, columns, table_text

from .watch import RunObserver

if TYPE_CHECKING:
    from rich.live import Live
    from rich.text import Text


ROPES = columns("rope", "peak at lower end [kN] .1", "at [h:min:s] .0", "rated [kN] .0", "utilisation [%] .1")


class Progress(RunObserver):
    """Progress bar of a run: simulated time, real-time factor, stage, share of actions done."""

    def __init__(self, plan: Plan, as_json: bool = False) -> None:
        self._plan, self._json = plan, as_json
        self._actions = max(1, len(plan.actions))
        self._live = _bar() if _terminal(sys.stderr) else None
        self._began = time.perf_counter()
        self._stage, self._action, self._t_ns = "starting", 0, 0

    def __enter__(self) -> Self:
        if self._live is not None:
            self._live.start()
        return self

    def __exit__(self, _: object, error: BaseException | None, *__: object) -> None:
        if self._live is not None:
            self._live.stop()
        if self._json and isinstance(error, HeavyliftError) and error.verdict is not None:
            print(json.dumps({"error": str(error), "verdict": msgspec.to_builtins(error.verdict)}))
            error.verdict = None  # is reported

    def event(self, event: Event) -> None:
        """Show in the progress bar that a stage begins or that a joint was locked."""
        if event.type == "Stage":
            stage = event.value
            self._stage, self._action = stage.name or self._stage, stage.action + 1  # type: ignore[attr-defined]
            if self._live is None and stage.name:  # type: ignore[attr-defined]
                print(f"{event.t * 1e-9:9.1f} s  {stage.name}", file=sys.stderr)  # type: ignore[attr-defined]
            self.progress(event.t)
        elif event.type == "StateEvent" and self._live is None and event.value.what == "locked":  # type: ignore[attr-defined]
            lost = f"{event.value.name} locked, {event.value.value:.4g} J became heat"  # type: ignore[attr-defined]
            print(f"{event.t * 1e-9:9.1f} s  {lost}", file=sys.stderr)

    def progress(self, t_ns: int) -> None:
        """Show in the progress bar the simulation time reached [ns]."""
        self._t_ns = max(t_ns, self._t_ns)
        if self._live is not None:
            self._live.update(self._line())

    def say(self, sentence: str) -> None:
        """Print a sentence on a separate line above the progress bar."""
        if self._live is None:
            print(printable(sentence), file=sys.stderr)
        else:
            self._live.console.print(printable(sentence), soft_wrap=True)

    def _line(self) -> "Text":
        from rich.text import Text

        seconds = self._t_ns * 1e-9
        wall = time.perf_counter() - self._began
        share = seconds / self._plan.end if self._plan.end else self._action / self._actions
        width = 24
        full = round(width * min(1.0, share))
        bar = "━" * full + "╌" * (width - full)
        return Text(
            f"{bar}  {clock(seconds)} simulated  {seconds / wall if wall > 0 else 0:6.0f} x real time  {self._stage}"
        )


def _terminal(stream: TextIO | None) -> bool:
    """Whether the stream is a terminal or colours are forced, as Rich decides."""
    return stream is not None and (stream.isatty() or bool(os.environ.get("FORCE_COLOR")))


def _bar() -> "Live":
    from heavylift.coordinator.live.terminal import Terminal, changing_line

    return changing_line(Terminal(err=True), 8)


class Certified(Protocol):
    """Interface of a certificate, which holds error estimates of a run's figures."""

    @property
    def message(self) -> list[str]:
        """The error estimates of the run's figures as lines of text."""

    def data(self) -> dict[str, object]:
        """Return the error estimates of the run's figures as plain data for JSON."""


def summary(
    plan: Plan,
    result: RunResult,
    as_json: bool = False,
    certificate: Certified | None = None,
    answer: Answer | None = None,
    verbose: bool = False,
) -> None:
    """Print the results of a run: verdict, governing checks, findings, and the peak tension of each rope; as JSON in SI
    units.

    `verbose`: also digest, wall-clock times and energy balance.
    """
    limits = rated(plan)
    if as_json:
        verdict = msgspec.to_builtins(result.verdict)
        data = asdict(replace(result, verdict=None)) | {"recording": str(result.recording), "verdict": verdict}
        data |= {"rated": limits, "use": {x: T / limits[x] for x, (T, _) in result.peaks.items() if limits.get(x)}}
        data |= {"answer": msgspec.to_builtins(answer) | {"told": str(answer)}} if answer else {}
        data |= {"certified": certificate.data()} if certificate else {}
        print(json.dumps(data))
        return
    if result.verdict is not None:
        print_verdict(result.verdict)
    _print_ropes(result, limits)
    if answer is not None:
        _print(f"\nerrors: {answer}")
    if certificate is not None:
        _print("\n" + "\n".join(certificate.message))
    factor = result.sim_s / result.wall_s if result.wall_s else 0.0
    _print(f"\n{clock(result.sim_s)} simulated in {result.wall_s:.1f} s, {factor:.0f} x real time")
    if result.lateness is not None:
        _print(f"by the clock: {result.lateness}")
    if verbose:
        _print_details(result)
    _print(f"wrote {result.recording}\n\nnext: {command()} plot {result.recording}")


def _print_ropes(result: RunResult, limits: dict[str, float]) -> None:
    """Print the peak tension of each rope at its lower end; pieces of a rope with mass (NAME~1) are omitted."""
    peaks = {name: peak for name, peak in result.peaks.items() if "~" not in name}
    red = {f.subject for f in result.verdict.findings if f.state == "red"} if result.verdict else set()
    rows = []
    for name, (tension, when) in peaks.items():
        limit = limits.get(name)
        rows.append((name, tension / 1e3, when, *((limit / 1e3, 100 * tension / limit) if limit else (None, None))))
    styles = ["bold", *("bold red" if name in red else None for name in peaks)] if peaks else []
    _print("" if peaks else None)
    for line, style in zip(table_text(Table("Ropes", ROPES, tuple(rows))).splitlines(), styles, strict=True):
        _print(line, style)


def _print_details(result: RunResult) -> None:
    """Print details for programmers: wall time per part, grants, energy balance, digest."""
    _print(f"seconds: {result.budget}; {result.grants} grants")
    if result.energy_turned_over:
        moved = f"{result.energy_turned_over / 1e6:.4g} MJ turned over"
        _print(f"energy balance closes to {result.energy_error:.1e} of the {moved}")
    _print(f"digest {result.digest}")


def print_verdict(verdict: RecordedVerdict) -> None:
    """Print the verdict, the governing checks, the smallest clearance, and all findings, the most severe first."""
    styles = {"red": "bold red", "undecided": "bold yellow", "amber": "yellow"}
    _print(f"verdict: {verdict.line}", styles.get(verdict.state, "bold green"))
    for line in governing(verdict.checks):
        _print(line)
    if verdict.clearances and not verdict.red:
        _print(f"smallest clearance: {verdict.clearances[0].message}")
    for x in likewise(verdict.findings):
        _print(f"{x.word}: {x.message}", {"red": "bold red", "amber": "yellow"}.get(x.state))
    for line in open_checks(verdict.checks):
        _print(line, "yellow")
    for line in scope(verdict.checks):
        _print(line)


def _print(text: str | None, style: str | None = None) -> None:
    """Print lines, styled on a terminal; nothing for None."""
    if text is None:
        return
    if not _terminal(sys.stdout):
        print(text)
        return
    from heavylift.coordinator.live.terminal import Terminal

    Terminal().print(text, style=style, soft_wrap=True)


def command() -> str:
    """Return the program name with which the user called heavylift, for commands that are printed to be copied."""
    called = sys.argv[0]
    return "heavylift" if shutil.which("heavylift") == str(Path(called).absolute()) else called
