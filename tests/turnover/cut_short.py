"""A coordinator that grants random shorter times than it could."""

from __future__ import annotations

from random import Random

from heavylift.coordinator.protocol import Grant, OpenCoordinator
from heavylift.nodes.devs import FOREVER, Tag, after, succ
from msgspec.structs import replace


class CutShort(OpenCoordinator):
    """Ends grants at random before their window does, yet late enough to do one tag."""

    random = Random(0)
    cuts = 0

    def ready(self, horizon: Tag = FOREVER) -> list[tuple[str, Grant]]:
        return [(name, self._cut(name, grant)) for name, grant in super().ready(horizon)]

    def _cut(self, name: str, grant: Grant) -> Grant:
        tag = self._nodes[name].first
        if tag >= FOREVER:
            return grant
        some = self.random.choice([0, 0, 1, 1_000, 1_000_000, 50_000_000, 300_000_000])
        until = min(grant.until, after(tag, some) if some else succ(tag))
        type(self).cuts += until < grant.until
        return replace(grant, until=until)
