"""The page of a run that still goes on: what happens is packed 30 times a second and kept for whoever looks.

The run only hands over what it has anyhow; a thread of the page's own packs it, and every browser reads the same list
of messages at its own pace, so neither a slow browser nor none at all can hold up the run.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from typing import Any, Self, cast

import msgspec
import numpy as np
from heavylift.recordings.format.samples import SampleLayout, thinned
from heavylift.recordings.format.text import duration
from heavylift.recordings.format.viewer_messages import Box, RopeLine
from heavylift.recordings.write.sink import texts
from heavylift.recordings.write.spectator import Spectator
from numpy.typing import NDArray

from .content import PageColumns, event_shown, facts_shown, is_inner, load_of, packed, shown, stage_name
from .server import PageServer

FRAME = 1 / 30  # [s] at least between two messages
ROWS = 64  # most samples in a message: a run can be a thousand times faster than its picture
EVENTS = 5000  # most events in the list
PATIENCE = 10.0  # [s] for a first browser to come when the run is over before one has
FAREWELL = 2.0  # [s] for browsers to get the end


class LivePage(Spectator):
    """`begin`, then `event`, `ropes`, `samples` as they come, then `end`; a context manager around the whole run."""

    def __init__(self) -> None:
        self._server = PageServer()
        self.url = self._server.url
        """Where a browser finds it, with the word that lets it in."""
        self._lock = threading.Lock()
        self._shown: PageColumns | None = None
        self._facts: list[tuple[str, str]] = []
        self._rows: list[tuple[Sequence[int], NDArray[np.float64]]] = []
        self._more: dict[str, list[Any]] = {"events": [], "stages": [], "rig": []}
        self._events = 0
        self._t_ns = 0
        self._over = threading.Event()
        self._packer = threading.Thread(target=self._pack_on, name="live page", daemon=True)
        self._packer.start()

    def begin(
        self, run: Mapping[str, object], layout: SampleLayout, boxes: Sequence[Box], lines: Sequence[RopeLine]
    ) -> None:
        self._shown, self._facts = shown(layout), facts_shown(texts(run), [])
        head = {
            "title": run.get("scene", ""),
            "status": "starting",
            "facts": self._facts,
            **self._shown.head(),
            "boxes": boxes,
            "rig": [{"t": 0.0, "lines": lines}],
            "rated": run.get("rated", {}),
            "supports": [s for s in cast("list[dict[str, object]]", run.get("supports", [])) if not s.get("on")],
            "stages": [],
            "events": [],
            "peaks": [],
        }
        self._server.say("begin", msgspec.json.encode(head))

    def event(self, t_ns: int, source: str, port: str, type: str, payload: bytes) -> None:
        inner = is_inner(port)
        if self._events >= EVENTS or (inner and self._events >= EVENTS // 2):  # the list keeps room for what matters
            return
        self._events += 1
        with self._lock:
            self._more["events"].append((t_ns, source, port, type, payload))

    def ropes(self, t_ns: int, lines: Sequence[RopeLine]) -> None:
        with self._lock:
            self._more["rig"].append({"t": t_ns * 1e-9, "lines": list(lines)})

    def samples(self, times: Sequence[int], rows: NDArray[np.float64]) -> None:
        with self._lock:
            self._rows.append((times, rows))

    def end(self, status: str, told: Mapping[str, str], peaks: Sequence[Mapping[str, object]], where: str) -> None:
        self._over.set()
        self._packer.join()
        self._pack()
        if self._shown is not None:
            kept = [("recording", where), ("page to keep", f"heavylift view {where}")]
            said = f"{status}, {duration(self._t_ns * 1e-9)} simulated; recorded in {where}"
            last = {"status": said, "facts": [*self._facts, *told.items(), *kept], "peaks": peaks}
            self._server.say("end", msgspec.json.encode(last))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, _: object, error: object, *__: object) -> None:
        self._over.set()
        self._packer.join()
        begun = self._shown is not None and not isinstance(error, KeyboardInterrupt)
        self._server.close(PATIENCE if begun else 0.0, FAREWELL)

    def _pack_on(self) -> None:
        while not self._over.wait(FRAME):
            self._pack()

    def _pack(self) -> None:
        """One message of all that has come since the last one."""
        with self._lock:
            rows, self._rows = self._rows, []
            more, self._more = self._more, {"events": [], "stages": [], "rig": []}
        if self._shown is None or not (rows or any(more.values())):
            return
        message: dict[str, object] = {"rig": more["rig"]}
        message["events"], message["stages"] = self._told(more["events"])
        if rows:
            times = np.concatenate([np.asarray(t, np.int64) for t, _ in rows])
            values = np.concatenate([x for _, x in rows])[:, self._shown.columns]
            kept = thinned([load_of(self._shown.signals, values[:, 7 * len(self._shown.bodies) :])], ROWS)
            message["rows"] = {"t": packed(times[kept] * 1e-9, "<f8"), "x": packed(values[kept])}
            self._t_ns = int(times[-1])
        message["status"] = f"running, {duration(self._t_ns * 1e-9)} simulated"
        self._server.say("more", msgspec.json.encode(message))

    @staticmethod
    def _told(events: list[Any]) -> tuple[list[dict[str, object]], list[dict[str, object]]]:
        """Events and stages for the page."""
        listed, stages = [], []
        for t_ns, source, port, type_, payload in events:
            value = msgspec.msgpack.decode(payload)
            listed.append(event_shown(t_ns, source, port, type_, value))
            if name := stage_name(port, value):
                stages.append({"t": t_ns * 1e-9, "name": name})
        return listed, stages
