"""What a user sees of a run: a progress bar with stage and real-time factor, and at the end a summary per rope.

Without a terminal the bar becomes one plain line per stage, and Rich is not imported.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import time
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, Self, TextIO

import msgspec
from heavylift.coordinator.record.facts import rated
from heavylift.coordinator.record.scene import RunResult
from heavylift.kernel.description.findings import Check, clock
from heavylift.kernel.errors import HeavyliftError, printable
from heavylift.nodes.devs import Event
from heavylift.nodes.limits.checks import ASSUMED, UNKNOWN, WARNED
from heavylift.nodes.limits.table_rows import likewise
from heavylift.nodes.plan.fidelity import Answer
from heavylift.nodes.plan.plan import Plan
from heavylift.recordings.read.verdict import Judged
from heavylift.recordings.sheets.sheet import Table, columns
from heavylift.recordings.sheets.terminal import table_text

from .watch import RunObserver

if TYPE_CHECKING:
    from rich.live import Live
    from rich.text import Text


ROPES = columns("rope", "peak [kN] .1", "at [h:min:s] .0", "rated [kN] .0", "use [%] .1")


class Progress(RunObserver):
    """Draws simulated time, real-time factor, stage and actions begun out of all."""

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
            error.verdict = None  # is told

    def event(self, event: Event) -> None:
        """A stage begins, or a joint is locked."""
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
        """Simulated time moves on."""
        self._t_ns = max(t_ns, self._t_ns)
        if self._live is not None:
            self._live.update(self._line())

    def say(self, sentence: str) -> None:
        """A line of its own, above the bar."""
        if self._live is None:
            print(printable(sentence), file=sys.stderr)
        else:
            self._live.console.print(printable(sentence), soft_wrap=True)

    def _line(self) -> Text:
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
    """Whether somebody looks, or asks for colours all the same, as Rich understands it."""
    return stream is not None and (stream.isatty() or bool(os.environ.get("FORCE_COLOR")))


def _bar() -> Live:
    from heavylift.coordinator.live.terminal import Terminal, changing_line

    return changing_line(Terminal(err=True), 8)


class Certified(Protocol):
    """How sure the figures of a run are."""

    @property
    def told(self) -> list[str]:
        """In lines for people."""

    def data(self) -> dict[str, object]:
        """As plain data."""


def summary(
    plan: Plan,
    result: RunResult,
    as_json: bool = False,
    certificate: Certified | None = None,
    answer: Answer | None = None,
) -> None:
    """Print how the run ended and what each rope saw; as JSON, in SI units."""
    if as_json:
        verdict = msgspec.to_builtins(result.verdict)
        told = asdict(replace(result, verdict=None)) | {"recording": str(result.recording), "verdict": verdict}
        limits = rated(plan)
        told |= {"rated": limits, "use": {x: T / limits[x] for x, (T, _) in result.peaks.items() if limits.get(x)}}
        told |= {"answer": msgspec.to_builtins(answer) | {"told": str(answer)}} if answer else {}
        told |= {"certified": certificate.data()} if certificate else {}
        print(json.dumps(told))
        return
    if result.peaks:
        limits = rated(plan)
        red = {f.subject for f in result.verdict.findings if f.severity == "red"} if result.verdict else set()
        rows = []
        ropes = {name: peak for name, peak in result.peaks.items() if "~" not in name}  # no pieces of ropes
        for name, (tension, when) in ropes.items():
            limit = limits.get(name)
            rest = (limit / 1e3, 100 * tension / limit) if limit else (None, None)
            rows.append((name, tension / 1e3, when, *rest))
        styles = ["bold", *("bold red" if name in red else None for name in ropes)]
        for line, style in zip(table_text(Table("Ropes", ROPES, tuple(rows))).splitlines(), styles, strict=True):
            _tell(line, style)
    if answer is not None:
        _tell(f"\n{answer}")
    if certificate is not None:
        _tell("\n" + "\n".join(certificate.told))
    factor = result.sim_s / result.wall_s if result.wall_s else 0.0
    _tell(
        f"\n{clock(result.sim_s)} simulated in {result.wall_s:.1f} s, {factor:.0f} x real time, {result.grants} grants"
    )
    _tell(f"seconds: {result.budget}")
    if result.energy_turned_over:
        moved = f"{result.energy_turned_over / 1e6:.4g} MJ turned over"
        _tell(f"energy balance closes to {result.energy_error:.1e} of the {moved}")
    if result.lateness is not None:
        _tell(f"by the clock: {result.lateness}")
    path = result.recording
    _tell(f"digest {result.digest}\nwrote {path}")
    _tell(f"\nnext: {command()} plot {path}")
    if result.verdict is not None:
        tell_verdict(result.verdict)


REMEDY = {
    UNKNOWN: ": nobody has measured how wrong these values may be; `--accuracy 1%` does",
    ASSUMED: ": limits that heavylift assumes; give your own, or confirm them with 'assumed: accept'",
}


def tell_verdict(verdict: Judged) -> None:
    """Print what was found, the smallest clearance, and the verdict as the last line."""
    styles = {"red": "bold red", "warning": "yellow", "note": None}
    grouped = likewise(verdict.findings)
    if grouped:
        _tell("")
    for f in grouped:
        _tell(f"{f.severity}: {f.told}", styles[f.severity])
    _open_checks(verdict)
    if verdict.clearances and not verdict.red:
        _tell(f"smallest clearance: {verdict.clearances[0].told}")
    styles = {"red": "bold red", "undecided": "bold yellow", "amber": "yellow"}
    _tell(f"verdict: {verdict.line}", styles.get(verdict.state, "bold green"))


def _open_checks(verdict: Judged) -> None:
    """What is undecided or amber, each kind once, with what would decide it."""
    kinds: dict[str, list[Check]] = {}
    for check in verdict.checks:
        if check.state in ("undecided", "amber") and check.why != WARNED:
            kinds.setdefault(check.word, []).append(check)
    for kind, checks in kinds.items():
        if kind in (UNKNOWN, ASSUMED):
            names = ", ".join(dict.fromkeys(check.quantity for check in checks))
            _tell(f"{kind}: {names}{REMEDY[kind]}", "yellow")
            continue
        alike: dict[str, list[Check]] = {}
        for check in checks:
            alike.setdefault(check.quantity, []).append(check)
        for first, *more in alike.values():
            _tell(f"{kind}: {first.sentence}{f'; likewise {len(more)} more' if more else ''}", "yellow")


def _tell(text: str, style: str | None = None) -> None:
    """Print lines, in a style where there is a terminal."""
    if not _terminal(sys.stdout):
        print(text)
        return
    from heavylift.coordinator.live.terminal import Terminal

    Terminal().print(text, style=style, soft_wrap=True)


def command() -> str:
    """The command as the user has called it, so that the next one can be copied."""
    called = sys.argv[0]
    return "heavylift" if shutil.which("heavylift") == str(Path(called).absolute()) else called
