"""A control of a system: a function of time and sampled values that is called at a fixed period.

Signals take their new value at once. Drives and winches reach their new speed one period later, at constant
acceleration, so that prescribed motions have no jumps of speed.
"""

from collections.abc import Callable, Mapping

import numpy as np
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.table import steered
from heavylift.kernel.simulation.commands import CommandTarget
from heavylift.kernel.simulation.native.samples import channels, published
from heavylift.kernel.simulation.simulation import Simulation
from heavylift.nodes.devs import seconds

from .arguments import PERIOD, time_s

Control = Callable[[float, dict[str, float]], Mapping[str, float]]  # orders by name from the time [s] and all samples


def steering(
    control: Control | None, period: float | None, end_ns: int
) -> list[tuple[int, Callable[[CommandTarget], object]]]:
    """Return the calls of the user's control function in a run, each with its time [ns]; raises KernelError."""
    if control is None and period is None:
        return []
    if control is None or period is None:
        raise KernelError("`control` is called every `period` [s]: give both, or neither")
    each, f = seconds(time_s("period", period, PERIOD)), control
    return [(t, lambda s: _steer(s, f, each)) for t in range(0, end_ns, each)]


def _steer(s: CommandTarget, control: Control, period_ns: int) -> None:
    assert isinstance(s, Simulation), "it is in one piece"
    row = published(s.method, np.array(s.method.row_layout.pack(s.row()))[None])[0]
    names = (f"{c.topic}/{name}" for c in channels(s.method) for name in c.names)
    now = s.epoch
    orders = control(now / 1e9, dict(zip(names, row.tolist(), strict=True)))
    if not isinstance(orders, Mapping):
        raise KernelError(
            f"control: the function returned {orders!r} at {now / 1e9:g} s; return a dict of values by name"
        )
    signals = steered(s.program.system)
    for name, value in orders.items():
        if name in signals:
            s.set_signal(name, float(value))
        elif change := abs(float(value) - s.references.speed(name, now)):
            s.set_profile(name, now, float(value), change / (period_ns * 1e-9), None)
