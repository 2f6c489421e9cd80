"""Initialises a simulation from the state of existing ones: islands that merge, or one that is cut in two.

All stand at one instant.  Coordinates, velocities and accounts, discrete states, moves, locks and thresholds go over
by name; step control begins with the shortest of their steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from heavylift.kernel.simulation.call_order import STOPPED
from heavylift.kernel.simulation.native.sample_row import labels

if TYPE_CHECKING:
    from heavylift.kernel.simulation.simulation import Simulation

__all__ = ["inherit"]

STATE = ("q", "v", "accounts", "turned")
KINDS = ("rope", "rigid", "support", "stop", "brake", "force", "held", "slot", "threshold")  # with discrete states


def inherit(new: Simulation, old: Sequence[Simulation]) -> None:
    """Bring a new simulation, not yet started, to the instant of the old ones; to be settled then."""
    s, at, native = new.program.system, new.program.parameters.at, new.native
    native.calm = frozenset(r.name for r in s.ropes if any(r.name in x.native.calm for x in old))
    native.use(frozenset(k.name for k in s.locks if any(k.name in x.program.locked for x in old)))
    known = dict[tuple[str, str, int], float]()
    for x in old:
        own = [label for label in labels(x.program) if label[0] in STATE]
        known |= dict(zip(own, x.state.tolist(), strict=True))
        for key, place in x.program.parameters.at.items():
            if key[0] in KINDS and key in at:
                new.P[at[key]] = x.P[place]
        new.switches.watched |= {k: v for k, v in x.switches.watched.items() if ("threshold", k) in at}
        new.events.rattling.counts |= x.events.rattling.counts
        new.references.take(x.references)
    new.state[:] = [known[label] for label in labels(new.program) if label[0] in STATE]
    native.set(h=min(x["h"] for x in old), error=max(x["error"] for x in old), scale=max(x["scale"] for x in old))
    native.epoch, new.recorder.number, new.order.phase = old[0].epoch, old[0].recorder.number, STOPPED
    new.integrator.new_stretch(new.epoch)
    new.held.measure()
