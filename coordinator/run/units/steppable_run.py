"""A run of a scene that another program advances step by step, by the protocol of any run.

A step executes everything before its end and evaluates the outputs there from the dense output of the mechanics, so
that communication points change no integration step.
"""

from collections.abc import Callable, Sequence
from typing import Any

import msgspec
import numpy as np
from heavylift.coordinator.participants.configuration import COMMAND, OPERATOR, WIND, driven_winds
from heavylift.coordinator.participants.kernel_node import KernelNode
from heavylift.coordinator.participants.rows import LargestRows
from heavylift.coordinator.participants.session import Session
from heavylift.coordinator.protocol.messages import RunEnd
from heavylift.kernel.analysis.linear import unit_of
from heavylift.kernel.errors import HeavyliftError, ModelError, SceneError
from heavylift.kernel.simulation.native.samples import published
from heavylift.nodes.devs import FOREVER, Event, Message, Tag
from heavylift.nodes.devs.ports import travelling
from heavylift.nodes.models.parts.messages import OperatorAnswer, OperatorCommand, SetPoint, SetSignal
from heavylift.nodes.models.user_models import OUTSIDE, aim_port
from heavylift.nodes.plan.plan import Plan
from heavylift.recordings import SampleLayout


class SteppableRun:
    """A run of a scene in this process that advances step by step.

    `now`: present time [ns]; `refused`: why the last command was refused; `given`: all steps and settings so far, from
    which `repeat` restores the state.
    """

    def __init__(self, plan: Plan, words: Callable[[str], bytes]) -> None:
        """`words` parses a command into the encoded action of an OperatorCommand."""
        self._words, self.now, self.refused, self._over, self._failed = words, 0, "", False, ""
        self.stop = FOREVER.t
        """Time beyond which no step may go [ns]."""
        self.given: list[tuple[str, int | float | str, str]] = []
        self.events, self.event = 0, ""
        self._heard = 0, ""  # the same, with the event at which a step has ended
        self._from = self._found = FOREVER.t  # events after the first end a step, which they set to the second [ns]
        led = [(own.name, x) for own in plan.models if own.model == OUTSIDE for x in own.leads]
        self.speeds = {x.move.actuator: 0.0 for _, x in led}
        """Set speeds of drives and winches, by name [m/s or rad/s]."""
        self._aims = {x.move.actuator: (aim_port(name, x.port), x.move.speed) for name, x in led}
        self._winds = driven_winds(plan)
        self.wind = next(iter(self._winds.values()), 0.0)
        """Speed of the wind [m/s]."""
        end = FOREVER if plan.end is None else None
        self._session = Session(plan, lambda config: KernelNode(config, LargestRows()), self._hear, end)
        self._kernel, self._core = self._session.kernel, self._session.core
        self._layout = layout = msgspec.msgpack.decode(self._kernel.layout(), type=SampleLayout)
        self._at = {f"{c.topic}/{name}": c.start + i for c in layout.channels for i, name in enumerate(c.names)}
        ropes = [name.removeprefix("rope/tension/") for name in self._at if name.startswith("rope/tension/")]
        self.peaks = dict.fromkeys(ropes, 0.0)
        self.settle()

    def _hear(self, event: Event) -> None:
        if isinstance(event.value, OperatorAnswer):
            self.refused = event.value.refused
        self._heard = self._heard[0] + 1, f"{event.source} {event.port}"
        if event.t > self._from:
            self._found = min(self._found, event.t)

    def _inject(self, port: str, *values: Message) -> None:
        safe = self._core.safe
        t = max(self.now, safe.t + (safe.k > 0))
        if self._core.over in (None, RunEnd.QUIET) and Tag(t) < self._core.end:
            for i, value in enumerate(values):
                self._core.inject(Event.of(t, 0, OPERATOR, port, i, travelling(value, f"{OPERATOR}.{port}")))

    def set_speed(self, actuator: str, speed: float) -> None:
        """Set the speed [m/s or rad/s] of a drive or winch, which is reached along the ramp of the drive."""
        port, most = self._aims[actuator]
        speed = min(max(speed, -most), most) if most else speed
        if speed != self.speeds[actuator]:
            self.given.append(("speed", speed, actuator))
            self.speeds[actuator] = speed
            self._inject(port, SetPoint(speed))

    def set_wind(self, speed: float) -> None:
        """Set the speed of the wind [m/s] from now on."""
        if speed != self.wind:
            self.given.append(("wind", speed, ""))
            self.wind = speed
            self._inject(WIND, *(SetSignal(name, speed) for name in self._winds))

    @property
    def seen(self) -> tuple[list[float], dict[str, float], int, str]:
        """The values after the last step: sample columns, peak tensions [N], number of events, and name of the last
        event."""
        return self._row.tolist(), {**self.peaks}, self.events, self.event

    def repeat(self, given: Sequence[tuple[str, Any, str]], seen: Sequence[Any]) -> None:
        """Bring this run to the state of another: repeat the steps and settings of the other, and take over its output
        values `seen`."""
        for what, value, name in given:
            if what == "go":
                self._advance(value)
                self.now = int(name)
                self.given.append((what, value, name))
            elif what == "order":
                self.order(name)
            elif what == "wind":
                self.set_wind(value)
            else:
                self.set_speed(name, value)
        row, self.peaks, self.events, self.event = seen
        self._row = np.array(row)

    def order(self, text: str) -> None:
        """Give an operator's command at the present time; if it is refused, `refused` holds the reason."""
        self.given.append(("order", 0.0, text))
        try:
            answer = OperatorCommand(text, self._words(text))
        except SceneError as error:
            self.refused = str(error).partition("\n")[0]
            return
        self._inject(COMMAND, answer)

    def go(self, to_ns: int, events: bool = False) -> bool:
        """Advance to a time [ns] or, if `events`, to the first event up to then; return whether an event ended the
        advance.

        The values do not include the effects of that event before `settle`. Raises HeavyliftError if the run fails, or
        if the time lies in the past or beyond the end.
        """
        if self._failed:
            raise ModelError(self._failed)
        if to_ns < self.now:
            raise ModelError(f"the exported scene is at {self.now / 1e9} s and cannot go back to {to_ns / 1e9} s")
        self._check_end(to_ns)
        self._from, self._found = self.now if events else FOREVER.t, FOREVER.t
        last, row = min(to_ns, self._core.end.t - 1), np.zeros(0)
        try:
            while events and self._found == FOREVER.t and (first := self._core.first.t) <= last:
                row = self._shown(first)
                self._advance(first + 1)  # nothing works ahead of an event
            met = self._found <= to_ns
            done = self._found + 1 if met else to_ns
            over = self._advance(done)
            self.now = self._found if met else min(to_ns, self._core.end.t)
            if self.given and self.given[-1][0] == "go":
                self.given.pop()  # where steps end changes nothing
            self.given.append(("go", done, str(self.now)))
            if over is not None and not self._over and self.now == self._core.end.t:
                self._kernel.finish(self._core.end)
                self._over = True
            if met:
                self._row = published(self._kernel.simulation.method, row[None])[0]
            else:
                self.settle()
        except HeavyliftError as error:
            self._failed = str(error)
            raise
        self._check_end(to_ns)  # perhaps all its actions are done
        return met

    def _advance(self, to_ns: int) -> RunEnd | None:
        return self._session.advance(Tag(to_ns))

    @property
    def end(self) -> int:
        """The time at which the scene ends [ns]."""
        return self._core.end.t

    def _check_end(self, to_ns: int) -> None:
        """Raise ModelError for a time beyond the end of the scene or of the experiment."""
        ends = {"scene": self._core.end.t, "experiment": self.stop}
        what = min(ends, key=lambda x: ends[x])
        if to_ns > ends[what]:
            raise ModelError(f"the step to {to_ns / 1e9} s is too long: the {what} ends at {ends[what] / 1e9:g} s")

    def _shown(self, t_ns: int) -> np.ndarray:
        simulation = self._kernel.simulation
        return simulation.shown(simulation.epoch if self._over else max(t_ns, simulation.epoch))

    def settle(self) -> None:
        """Update the values to include the effects of all events at the present time."""
        self.events, self.event = self._heard
        self._row = published(self._kernel.simulation.method, self._shown(self.now)[None])[0]
        _, _, most = self._kernel.said
        for rope, known in self.peaks.items():
            message = most[self._at[f"rope/peak/{rope}"]] if len(most) and f"rope/peak/{rope}" in self._at else 0.0
            self.peaks[rope] = max(known, float(message), self[f"rope/tension/{rope}"])

    def __getitem__(self, name: str) -> float:
        """Return the value of a sample column, such as "rope/tension/crane.H1"."""
        return float(self._row[self._at[name]])

    @property
    def columns(self) -> dict[str, str]:
        """Units of all sample columns, by name."""
        p, layout = self._kernel.simulation.program, self._layout
        channels = ((c, i, name) for c in layout.channels for i, name in enumerate(c.names))
        return {f"{c.topic}/{name}": unit_of(p, c.topic, i, c.unit) for c, i, name in channels}
