"""A replay in the page that shows runs while they go on: what is recorded of the lift, handed over at its times.

The page gets what a run would give it: facts, columns and boxes first, then events as they are said, samples and
changes of ropes when the replay has reached them.
"""

import numpy as np
from heavylift.nodes.devs import Event
from heavylift.recordings import Spectator
from heavylift.recordings.read.verdict import recorded_peaks
from heavylift.recordings.render.view import sample_rows

from .recorded import RecordedRun


class ReplayPage:
    """Streams a replay to the page from `start` [ns] on; `end` closes it."""

    def __init__(self, run: RecordedRun, page: Spectator, start: int = 0) -> None:
        self._page, self._recording = page, run.recording
        rec = self._recording
        layout, t, self._rows = sample_rows(rec)
        self._times = np.rint(t * 1e9).astype(np.int64)
        self._next = int(np.searchsorted(self._times, start))
        rigs = rec.rigs()
        self._rigs = [rig for rig in rigs if rig.t_ns > start]
        self._rated = rec.fact("rated", {})
        before = [rig.lines for rig in rigs if rig.t_ns <= start]
        facts = {**rec.run, "rated": self._rated, "supports": rec.fact("supports", [])}
        page.begin(facts, layout, rec.boxes(), before[-1] if before else [])

    def event(self, e: Event) -> None:
        """Send an event."""
        self._page.event(e.t, e.source, e.port, e.type, e.payload)

    def reached(self, t_ns: int) -> None:
        """Send the samples up to this simulation time [ns], and the present rope lines."""
        end = int(np.searchsorted(self._times, t_ns, side="right"))
        if end > self._next:
            part = slice(self._next, end)
            self._page.samples(self._times[part].tolist(), self._rows[part])
            self._next = end
        while self._rigs and self._rigs[0].t_ns <= t_ns:
            rig = self._rigs.pop(0)
            self._page.ropes(rig.t_ns, rig.lines)

    def end(self) -> None:
        """End of the replay: send the peaks of the whole run."""
        peaks = recorded_peaks(self._recording)
        message = [{"name": name, **x._asdict(), "rated": self._rated.get(name)} for name, x in peaks.items()]
        self._page.end("replayed", {}, message, str(self._recording.path))
