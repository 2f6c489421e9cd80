"""Who is due when: one heap of distinct times, a slot of atomics for each, and those due at the next microstep.

Only waits of zero lead to a microstep above 0, and always to the next one, so those need no heap.  Who is rescheduled
stays in the old slot and is recognised there by its own time; when most entries are stale, all slots are made anew.
"""

from heapq import heappop, heappush

from .models import Atomic
from .tags import FOREVER, NEVER, Tag

STALE = 4  # stale entries for each atomic at which the slots are made anew
new = tuple.__new__  # of a Tag, in half the time of Tag(t, k)


class Schedule:
    """`imminent`: indices of those due at the tag that `find` returned, in path order."""

    def __init__(self, atomics: list[Atomic]) -> None:
        self.atomics = atomics
        self.times: list[int] = []  # heap of the times [ns] with a slot
        self.slots: dict[int, list[int]] = {}
        self.soon: list[int] = []
        self.imminent: list[int] = []
        self._stale = 0

    def find(self, last: Tag) -> Tag:
        """The earliest tag at which somebody is due after the tag `last`."""
        atomics, times, slots = self.atomics, self.times, self.slots
        if self.soon:
            t, k = last
            self.imminent = sorted(self.soon)
            return new(Tag, (t, k + 1))
        while times:
            t = times[0]
            slot = slots[t]
            if len(slot) > 1:
                slot = [i for i in sorted({*slot}) if atomics[i]._t == t]
            elif atomics[slot[0]]._t != t:
                slot = []
            if slot:
                self.imminent = slot
                return new(Tag, (t, 0))
            del slots[heappop(times)]
        self.imminent = []
        return FOREVER

    def take(self, k: int) -> list[int]:
        """The imminent ones; their slot, or the next microstep, is empty then."""
        if k:
            self.soon = []
        elif self.imminent:
            del self.slots[heappop(self.times)]
        return self.imminent

    def enter(self, m: Atomic) -> None:
        """Put an atomic where its own time says."""
        if m._t == NEVER:
            return
        if m._k:
            self.soon.append(m._index)
        elif m._t in self.slots:
            self.slots[m._t].append(m._index)
        else:
            self.slots[m._t] = [m._index]
            heappush(self.times, m._t)

    def leave(self, now: int) -> None:
        """Somebody will not come to the slot it stands in; `now` [ns]: who is due later is still to come."""
        self._stale += 1
        if self._stale > STALE * len(self.atomics):
            self._stale = 0
            self.slots.clear()
            self.times.clear()
            for m in self.atomics:
                if m._t > now:
                    self.enter(m)
