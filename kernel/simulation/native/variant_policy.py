"""When to leave out of the code what a scene does not require: once that has cost as much as new code would.

Ski-rental rule: as long as a set of laws is dispensable, count the operations that they cost, and compile the code
without them once the wasted work equals the cost of compiling.  Whatever comes, this never costs more than twice what
foresight would have (Karlin et al., Algorithmica 3, 1988).  Operations are counted, not seconds, so that all runs of a
scene decide alike; code that has been bought is used whenever it fits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

__all__ = ["EVALUATIONS", "PRICE", "SPELL", "Thrift"]

PRICE = 4e5  # operations that run in the time in which one is compiled
EVALUATIONS = 6  # of the equations in an attempted step
SPELL = 4000  # attempted steps between two looks at a scene in which nothing happens, and in one native call: 25 ms

Laws = frozenset[str]


class Thrift:
    """What laws could have been left out how long, and which code has been bought; `always`: whatever it costs."""

    def __init__(self, always: bool = False) -> None:
        self._price = 0.0 if always else PRICE
        self.spent: dict[Laws, float] = {}  # attempted steps in which these were dispensable
        self.bought: list[Laws] = []
        self.since = 0.0  # attempted steps at the last look
        self.seen: Laws = frozenset()  # dispensable then

    def kept(self) -> dict[str, Any]:
        """All that later choices depend on, in lists."""
        return {
            "spent": [[sorted(laws), n] for laws, n in self.spent.items()],
            "bought": [sorted(laws) for laws in self.bought],
            "since": self.since,
            "seen": sorted(self.seen),
        }

    def go_on(self, kept: dict[str, Any]) -> None:
        """Choose on from what another one has kept."""
        self.spent = {frozenset(laws): n for laws, n in kept["spent"]}
        self.bought = [frozenset(laws) for laws in kept["bought"]]
        self.since, self.seen = kept["since"], frozenset(kept["seen"])

    def choose(self, attempts: float, laws: Laws, count: Callable[[Laws], tuple[int, int]]) -> Laws:
        """What to leave out now; `attempts`: steps so far; `laws`: dispensable now; `count`: operations of the
        equations without some laws, and how many of them are new code."""
        if self.seen:
            self.spent[self.seen] = self.spent.get(self.seen, 0.0) + attempts - self.since
        self.since, self.seen = attempts, laws
        best = max((b for b in self.bought if b <= laws), key=len, default=frozenset())
        if laws == best or not laws:
            return best
        spent = self.spent.get(laws, 0.0)
        if self._price and spent < SPELL:
            return best
        left, new = count(laws)
        saved = count(best)[0] - left
        if saved > 0 and EVALUATIONS * saved * spent >= self._price * new:
            self.bought.append(laws)
            return laws
        return best
