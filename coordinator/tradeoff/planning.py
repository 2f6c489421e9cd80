"""Which setting is run next: the one predicted to be cheapest, as long as it fits into what is left of the budget.

A chain is one rung and method, its settings from loose to tight.  A method of order p costs (tolerance ratio)^(1/p)
times more at the next tolerance, fixed steps cost their ratio; before a chain has run, the cheapest run so far stands
for it.  A chain ends when its error no longer changes, since then it is the rung's and not the integration's.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from .settings import Rung, Setting, settings

ORDER = {"dopri5": 5.0, "dop853": 8.0, "radau5": 5.0}
SETTLED = 0.02  # relative change of the worst error that says that integration no longer shows
TRIES = 2  # tolerances at which a method may fail: a third would fail for the same reason
EXACT = 1e-4  # of the limit: nobody needs it tighter


@dataclass
class Chain:
    """Settings of one rung and method that are still to be run, seconds of the last run, worst errors so far."""

    left: list[Setting]
    last: Setting | None = None
    seconds: float = 0.0
    prepared: float = 0.0
    worst: list[float] = field(default_factory=list)
    failed: int = 0


class Planner:
    """Hands out settings within a budget of seconds; told what each has cost and how good it was."""

    def __init__(self, rungs: list[Rung], methods: list[str], limit: float) -> None:
        self._chains = [Chain(settings(rung, method)) for rung in rungs for method in methods]
        self._limit = limit
        self.settled = 0
        """Settings that were not run since their chain's error had stopped to change, or was exact enough."""
        self._typical = 0.0  # seconds of the cheapest run so far, with its preparation

    @property
    def left(self) -> int:
        """Settings that have not been run."""
        return sum(len(chain.left) for chain in self._chains)

    def next(self, seconds: float) -> tuple[Setting, float] | None:
        """The cheapest setting and its predicted seconds, if any fits into `seconds`."""
        waiting = [chain for chain in self._chains if chain.left]
        chain = min(waiting, key=self._predicted, default=None)
        if chain is None or (cost := self._predicted(chain)) > seconds:
            return None
        return chain.left[0], cost

    def tell(self, setting: Setting, prepared: float, seconds: float, worst: float | None, cut: bool = False) -> None:
        """What the run has cost, and its worst error (None: it failed); where one was cut, tighter ones are not run."""
        chain = next(c for c in self._chains if c.left and c.left[0] == setting)
        chain.left.pop(0)
        chain.last, chain.seconds, chain.prepared = setting, seconds, prepared
        whole = prepared + seconds
        self._typical = min(self._typical or whole, whole)
        if worst is None:
            chain.failed += 1
            if cut or (setting.step is None and chain.failed >= TRIES):
                chain.left.clear()
            return
        chain.worst.append(worst)
        before = chain.worst[-2] if len(chain.worst) > 1 else 0.0
        if worst < EXACT * self._limit or abs(worst - before) <= SETTLED * before:
            self.settled += len(chain.left)
            chain.left.clear()

    def _predicted(self, chain: Chain) -> float:
        if chain.last is None:
            return self._typical
        following = chain.left[0]
        if following.step is not None and chain.last.step is not None:
            growth = chain.last.step / following.step
        else:
            assert following.tolerance is not None
            assert chain.last.tolerance is not None
            growth = (chain.last.tolerance / following.tolerance) ** (1.0 / ORDER[following.method])
        return chain.prepared + growth * chain.seconds
