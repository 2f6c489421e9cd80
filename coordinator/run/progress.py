"""What a user sees of a run: a progress bar with stage and real-time factor, and at the end a summary per rope.

Without a terminal the bar becomes one plain line per stage.
"""

from __future__ import annotations

import json
import shutil
import sys
import time
from dataclasses import asdict, replace
from pathlib import Path
from typing import Protocol, Self

import msgspec
from heavylift.coordinator.record.scene import Result, rated
from heavylift.coordinator.transport.printable import printable
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.devs import Event
from heavylift.nodes.limits.telling import likewise
from heavylift.nodes.plan.finding import Finding
from heavylift.nodes.plan.plan import Plan
from heavylift.recordings.format.text import clock
from heavylift.recordings.read.verdict import Judged
from rich.console import Console
from rich.live import Live
from rich.table import Table
from rich.text import Text

from .watch import Watch


class Progress(Watch):
    """Draws simulated time, real-time factor, stage and actions begun out of all."""

    def __init__(self, plan: Plan, as_json: bool = False) -> None:
        self._plan, self._json = plan, as_json
        self._actions = max(1, len(plan.actions))
        self._console = Console(stderr=True)
        self._live = (
            Live(console=self._console, refresh_per_second=8, transient=True) if self._console.is_terminal else None
        )
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
            error.verdict = None  # is told

    def event(self, event: Event) -> None:
        """A stage begins, or a joint is locked."""
        if event.type == "Stage":
            stage = event.value
            self._stage, self._action = stage.name or self._stage, stage.action + 1  # type: ignore[attr-defined]
            if self._live is None and stage.name:  # type: ignore[attr-defined]
                self._console.print(f"{event.t * 1e-9:9.1f} s  {stage.name}", highlight=False)  # type: ignore[attr-defined]
            self.progress(event.t)
        elif event.type == "StateEvent" and self._live is None and event.value.what == "locked":  # type: ignore[attr-defined]
            lost = f"{event.value.name} locked, {event.value.value:.4g} J became heat"  # type: ignore[attr-defined]
            self._console.print(f"{event.t * 1e-9:9.1f} s  {lost}", highlight=False)

    def progress(self, t_ns: int) -> None:
        """Simulated time moves on."""
        self._t_ns = max(t_ns, self._t_ns)
        if self._live is not None:
            self._live.update(self._line())

    def say(self, sentence: str) -> None:
        """A line of its own, above the bar."""
        self._console.print(printable(sentence), highlight=False, markup=False, soft_wrap=True)

    def _line(self) -> Text:
        seconds = self._t_ns * 1e-9
        wall = time.perf_counter() - self._began
        share = seconds / self._plan.end if self._plan.end else self._action / self._actions
        width = 24
        full = round(width * min(1.0, share))
        bar = "━" * full + "╌" * (width - full)
        return Text(
            f"{bar}  {clock(seconds)} simulated  {seconds / wall if wall > 0 else 0:6.0f} x real time  {self._stage}"
        )


class Certified(Protocol):
    """How sure the figures of a run are."""

    @property
    def told(self) -> list[str]:
        """In lines for people."""

    def data(self) -> dict[str, object]:
        """As plain data."""


def summary(plan: Plan, result: Result, as_json: bool = False, certificate: Certified | None = None) -> None:
    """Print how the run ended and what each rope saw; as JSON, in SI units."""
    if as_json:
        verdict = msgspec.to_builtins(result.verdict)
        told = asdict(replace(result, verdict=None)) | {"recording": str(result.recording), "verdict": verdict}
        limits = rated(plan)
        told |= {"rated": limits, "use": {x: T / limits[x] for x, (T, _) in result.peaks.items() if limits.get(x)}}
        told |= {"certified": certificate.data()} if certificate else {}
        print(json.dumps(told))
        return
    console = Console(highlight=False)
    if result.peaks:
        limits = rated(plan)
        red = {f.subject for f in result.verdict.findings if f.severity == "red"} if result.verdict else set()
        table = Table(box=None, pad_edge=False, header_style="bold")
        table.add_column("rope")
        for title in ("peak kN", "at", "rated kN", "use %"):
            table.add_column(title, justify="right")
        for name, (tension, when) in result.peaks.items():
            limit = limits.get(name)
            rest = [f"{limit / 1e3:.0f}", f"{100 * tension / limit:.1f}"] if limit else ["-", "-"]
            beyond = "bold red" if name in red else None
            table.add_row(name, f"{tension / 1e3:.1f}", clock(when), *rest, style=beyond)
        console.print(table)
    if certificate is not None:
        console.print("\n" + "\n".join(certificate.told), markup=False, soft_wrap=True)
    factor = result.sim_s / result.wall_s if result.wall_s else 0.0
    console.print(
        f"\n{clock(result.sim_s)} simulated in {result.wall_s:.1f} s, {factor:.0f} x real time, {result.grants} grants"
    )
    console.print(f"seconds: {result.budget}")
    if result.energy_turned_over:
        moved = f"{result.energy_turned_over / 1e6:.4g} MJ turned over"
        console.print(f"energy balance closes to {result.energy_error:.1e} of the {moved}")
    if result.lateness is not None:
        console.print(f"by the clock: {result.lateness}")
    path = result.recording
    console.print(f"digest {result.digest}\nwrote {path}", markup=False, soft_wrap=True)
    console.print(f"\nnext: {command()} plot {path}", markup=False, soft_wrap=True)
    if result.verdict is not None:
        tell_verdict(console, result.verdict)


def tell_verdict(console: Console, verdict: Judged) -> None:
    """Print what was found, the smallest clearance, and the verdict as the last line."""
    styles = {"red": "bold red", "warning": "yellow", "note": None}
    grouped = likewise(msgspec.convert(msgspec.to_builtins(f), Finding) for f in verdict.findings)
    if grouped:
        console.print()
    for f in grouped:
        at = f", at {clock(f.t)}" if f.t is not None else ""
        stage = f" ({f.stage})" if f.stage else ""
        told = f"{f.severity}: {f.sentence}{at}{stage}" + (f" [{f.where}]" if f.where else "")
        console.print(told, style=styles[f.severity], markup=False, soft_wrap=True)
    if verdict.clearances and not verdict.red:
        c = verdict.clearances[0]
        console.print(f"smallest clearance: {c.distance:.2f} m, {c.a} and {c.b}, at {clock(c.t)}", markup=False)
    style = "bold red" if verdict.red else "bold green"
    console.print(f"verdict: {verdict.line}", style=style, markup=False, soft_wrap=True)


def command() -> str:
    """The command as the user has called it, so that the next one can be copied."""
    called = sys.argv[0]
    return "heavylift" if shutil.which("heavylift") == str(Path(called).absolute()) else called
