"""Who is due when: one heap of distinct times, a slot of atomics for each, and those due at the next microstep.

Only waits of zero lead to a microstep above 0, and always to the next one, so those need no heap.  Who is rescheduled
stays in the old slot and is recognised there by its own time; when most entries are stale, all slots are made anew.
"""

from collections.abc import Collection
from heapq import heappop, heappush, heapreplace

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs.models import Atomic, Present
from heavylift.nodes.devs.tags import FOREVER, NEVER, Instant, Tag, after, beyond

from .rules import fail

STALE = 4  # stale entries for each atomic at which the slots are made anew


class Schedule:
    """`imminent`: indices of those due at the tag that `next` returned, in path order; they stand nowhere else."""

    def __init__(
        self, atomics: list[Atomic], last: Instant, present: Present, known: Collection[Atomic] = frozenset()
    ) -> None:
        """After the tag `last`; who is not `known` from before begins."""
        self.atomics = atomics
        self.times: list[int] = []  # heap of the times [ns] with a slot
        self.slots: dict[int, list[int]] = {}
        self.soon: list[int] = []
        self.imminent: list[int] = []
        self._stale = 0
        for m in atomics:
            if m in known:
                self._enter(m, last[0])
            else:
                self._begin(m, last, present)

    def next(self, last: Instant) -> Instant:
        """The earliest tag at which somebody is due after the tag `last`."""
        if self.soon:
            self.imminent, self.soon = self.soon, []
            self.imminent.sort()
            return last[0], last[1] + 1
        atomics, times, slots, now = self.atomics, self.times, self.slots, last[0]
        while times:
            t = times[0]
            if t > now:
                slot = slots.pop(t)
                if len(slot) > 1:
                    slot = [i for i in sorted({*slot}) if atomics[i]._t == t]
                elif atomics[slot[0]]._t != t:
                    slot = []
                if slot:
                    self.imminent = slot
                    return t, 0
            heappop(times)
        self.imminent = []
        return FOREVER

    def wait(self) -> None:
        """The imminent ones go back to their slot: something happens before."""
        if self.imminent:
            self.slots[self.times[0]] = self.imminent

    def move(self, m: Atomic, t: int, now: int) -> None:
        """Give an atomic another time [ns]; if it is `now`, the caller puts it among those due `soon`."""
        before, slots, times = m._t, self.slots, self.times
        if t == before:
            return
        m._t = t
        if t in slots:
            slots[t].append(m._index)
        elif t >= NEVER:
            if t - now < NEVER:  # not for ever, only too long
                raise ModelError(f"{m.path} at {m.now}: {beyond(t - now)}")
            m._t = NEVER
        elif t > now:
            slots[t] = [m._index]
            if times and times[0] <= now:  # a time that has passed stands in the heap until a new one replaces it
                heapreplace(times, t)
            else:
                heappush(times, t)
        if before != now and before != NEVER:
            self._stale += 1
            if self._stale > STALE * len(self.atomics):
                self._renew(now)

    def _enter(self, m: Atomic, now: int) -> None:
        """Put an atomic where its own time says; `now` [ns]: who is due now is due at the next microstep."""
        if m._t <= now:
            self.soon.append(m._index)
        else:
            t, m._t = m._t, NEVER
            self.move(m, t, now)

    def _begin(self, m: Atomic, last: Instant, present: Present) -> None:
        """Initial state of an atomic that comes in after the tag `last`, and its first time."""
        m._t, m._last, m._wait, m._port, m._more = NEVER, max(last[0], 0), None, None, None
        m._set = last[0] if last[0] >= 0 else -NEVER
        present.busy = True
        try:
            m.start()
        except BaseException as error:
            fail(m, present.now, "start", error)
        present.busy = False
        if m._wait is not None:
            if NEVER - m._last <= m._wait < NEVER:
                fail(m, present.now, "start", ModelError(beyond(m._wait)))
            m._t, m._wait = after(Tag(m._last), m._wait).t, None
        self._enter(m, last[0])

    def _renew(self, now: int) -> None:
        """All slots anew, without those who left them."""
        self._stale = 0
        self.slots.clear()
        self.times.clear()
        for m in self.atomics:
            if m._t > now:
                self._enter(m, now)
