"""The table of limits of a run as the report shows it; made by who knows the scene, see `coordinator.record.limits`."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["LimitTable"]


@dataclass(frozen=True)
class LimitTable:
    """Rows of cells under `head`, whether anything is beyond its limit, and what is to be said.

    `findings`: (severity, subject, sentence, when [s] or None), red ones first.  `told`: what was foreseen,
    assumed or not judged.  `dynamic`: the amplification that a standard foresees for this lift, and its source.
    """

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    red: bool
    findings: tuple[tuple[str, str, str, float | None], ...] = ()
    told: tuple[str, ...] = ()
    dynamic: tuple[float, str] | None = None
