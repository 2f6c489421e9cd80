"""Which setting for which question: the verdict on each quantity alone, at several limits, from one table."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from .verdict import Row, judge

if TYPE_CHECKING:
    from heavylift.nodes.plan.question import Asked

    from .measuring import Measured

__all__ = ["LIMITS", "Answer", "answers"]

LIMITS = (0.05, 0.01, 0.001)


@dataclass(frozen=True)
class Answer:
    """The fastest setting that keeps one quantity within a limit, with that error alone; None if none does."""

    quantity: Asked
    limit: float
    row: Row | None


def answers(measured: Measured) -> Iterator[Answer]:
    """Of every quantity asked, loosest limit first."""
    for quantity in measured.ask:
        alone = [replace(r, errors={q: e for q, e in r.errors.items() if q == quantity}) for r in measured.rows]
        for limit in LIMITS:
            yield Answer(quantity, limit, judge(alone, limit).pick)
