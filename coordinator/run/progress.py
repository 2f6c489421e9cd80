"""What a user sees of a run: a progress bar with stage and real-time factor, and at the end a summary per rope.

Without a terminal the bar becomes one plain line per stage.
"""

from __future__ import annotations

import json
import shutil
import sys
import time
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import Self

from heavylift.nodes.devs import Event
from heavylift.nodes.limits import judge_run, signals_of_peaks
from heavylift.nodes.limits.telling import likewise
from heavylift.nodes.scene.plan import Plan
from rich.console import Console
from rich.live import Live
from rich.table import Table
from rich.text import Text

from ..record.scene import Result, rated
from .watch import Watch

__all__ = ["Progress", "summary"]


class Progress(Watch):
    """Draws simulated time, real-time factor, stage and actions begun out of all."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
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

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._live is not None:
            self._live.stop()

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
        self._console.print(sentence, highlight=False, markup=False, soft_wrap=True)

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


def clock(seconds: float) -> str:
    """h:mm:ss of simulated time."""
    s = round(seconds)
    return f"{s // 3600}:{s // 60 % 60:02}:{s % 60:02}"


def summary(plan: Plan, result: Result, path: Path, as_json: bool = False) -> None:
    """Print how the run ended and what each rope saw; as JSON, in SI units."""
    if as_json:
        print(json.dumps({"recording": str(path), **asdict(result)}))
        return
    console = Console(highlight=False)
    if result.peaks:
        limits = rated(plan)
        table = Table(box=None, pad_edge=False, header_style="bold")
        table.add_column("rope")
        for title in ("peak kN", "at", "rated kN", "use %"):
            table.add_column(title, justify="right")
        for name, (tension, when) in result.peaks.items():
            limit = limits.get(name)
            rest = [f"{limit / 1e3:.0f}", f"{100 * tension / limit:.1f}"] if limit else ["-", "-"]
            beyond = "bold red" if limit and tension > limit else None
            table.add_row(name, f"{tension / 1e3:.1f}", clock(when), *rest, style=beyond)
        console.print(table)
        for found in likewise(judge_run(plan, signals_of_peaks(result.peaks))):
            style = "bold red" if found.severity == "red" else "yellow"
            at = f" at {clock(found.t)}" if found.t is not None else ""
            console.print(f"{found.severity}: {found.sentence}{at}", style=style, markup=False, soft_wrap=True)
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
    for note in result.notes:
        console.print(f"note: {note}", markup=False, soft_wrap=True)
    console.print(f"digest {result.digest}\nwrote {path}")
    if result.unfinished:
        console.print(f"at its end the run was {result.unfinished}", style="bold")
    console.print(f"\nnext: {command()} plot {path}")


def command() -> str:
    """The command as the user has called it, so that the next one can be copied."""
    called = sys.argv[0]
    return "heavylift" if shutil.which("heavylift") == str(Path(called).absolute()) else called
