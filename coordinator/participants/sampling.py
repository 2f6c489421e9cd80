"""Signals that the kernel sends to subscribed models at whole multiples of a period, interpolated within its steps.

No integration step is shortened for them: the kernel works on until a step goes beyond the next sample, or an event is
located at or after it, and evaluates the signals within that step: their values before any input at that instant.
"""

from collections.abc import Callable, Mapping

import numpy as np
from heavylift.kernel.model.program import Program
from heavylift.kernel.simulation.native.samples import reader
from heavylift.nodes.devs import NEVER, Event
from heavylift.nodes.models import KERNEL, sample_port
from heavylift.nodes.models.parts.messages import Sample

from .parts import SignalSubscription


class Sampling:
    """Sends samples of signals to the models that subscribe to them; `done`: number of samples sent, by period [ns]."""

    def __init__(self, listening: Mapping[str, SignalSubscription], program: Program) -> None:
        self._listening = {
            model: (x.period, {sample_port(model, port): reader(program, signal) for port, signal in x.signals.items()})
            for model, x in listening.items()
            if x.signals
        }
        self.lookahead = {f"{KERNEL}.{port}": 0 for _, ports in self._listening.values() for port in ports}
        self.done = {period: 0 for period, _ in self._listening.values()}
        self._said: tuple[int, list[Event]] = (-1, [])

    @property
    def next_ns(self) -> int:
        """Time of the next sample [ns]."""
        return min((period * n for period, n in self.done.items()), default=NEVER)

    def outputs(self, row: Callable[[int], np.ndarray]) -> list[Event]:
        """Return the samples that are due next as events; `row` returns the kernel's sample row at a time [ns]."""
        t = self.next_ns
        if self._said[0] != t:
            numbers = row(t).tolist()
            ports = {
                port: read(numbers)
                for period, readers in self._listening.values()
                if period * self.done[period] == t
                for port, read in readers.items()
            }
            events = [Event.of(t, 0, KERNEL, port, 0, Sample(float(x))) for port, x in ports.items()]
            self._said = t, events
        return self._said[1]

    def renew(self) -> None:
        """Discard samples that were computed ahead but not sent, to be computed again."""
        self._said = -1, []

    def taken(self) -> None:
        """Mark the samples that were due as sent."""
        t = self.next_ns
        self.done = {period: n + (period * n == t) for period, n in self.done.items()}
