"""When a run stops making progress: too many steps for a second of the scene, or too many events too close together.

Both are counted, not timed, so that all runs of a scene end alike.  A step of a microsecond takes a second of work for
a tenth of a second of the scene or less: nobody waits for that, and no law of a yard asks for it.
"""

from __future__ import annotations

STEPS = 1_000_000  # attempted for one second of the scene
CROWD = 2000  # events in a row, each so close to the last that no rope or support could tell them apart, or in a spell
SPELL_NS = 10_000_000  # of the scene


class StepBudget:
    """`since`: attempts and time [s] at which the present second began; `crowd`: events in a row, time of the last;
    `spell`: events in it, when it began [ns]."""

    def __init__(self, resolved_ns: int) -> None:
        self._resolved_ns = resolved_ns
        self.since = 0.0, 0.0
        self.crowd = 0, 0
        self.spell = 0, 0

    def ends(self, attempts: float, t: float) -> bool:
        """Whether a second of the scene has taken too many steps; t: of the run [s]."""
        before, start = self.since
        if t - start >= 1.0:
            self.since = attempts, t
            return False
        return attempts - before >= STEPS

    def crowded(self, t_ns: int) -> bool:
        """Whether the event at t_ns is one of too many."""
        count, since = self.spell
        self.spell = (count + 1, since) if t_ns - since <= SPELL_NS else (1, t_ns)
        n, last = self.crowd
        self.crowd = (n + 1 if t_ns - last <= self._resolved_ns else 0), t_ns
        return self.crowd[0] > CROWD or self.spell[0] > CROWD
