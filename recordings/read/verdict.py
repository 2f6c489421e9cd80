"""The verdict of a run as it stands in its recording: one line, what was found, the smallest clearances, the limits.

It is made by who knows the scene (`coordinator.verdict`) and kept as the fact `verdict` of the result.
"""

from __future__ import annotations

from typing import Literal

import msgspec

from .reader import Recording

Vector = tuple[float, float, float]


class Found(msgspec.Struct, frozen=True, kw_only=True):
    """What was found of a subject: a sentence, and the numbers behind it (t [s], value and limit [unit])."""

    severity: Literal["red", "warning", "note"]
    kind: str
    subject: str
    sentence: str
    where: str = ""
    stage: str = ""
    t: float | None = None
    value: float | None = None
    limit: float | None = None
    unit: str = ""


class Clearance(msgspec.Struct, frozen=True, kw_only=True):
    """Two things, how near they came at least [m], when [s]; both nearest points in the world [m], and in words which
    parts they are of; `limit` [m], 0 where they must only not go through each other."""

    a: str
    b: str
    distance: float
    t: float
    limit: float
    p_WA: Vector
    p_WB: Vector
    place: str


class LimitTable(msgspec.Struct, frozen=True, kw_only=True):
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


class Judged(msgspec.Struct, frozen=True, kw_only=True):
    """All of a verdict; findings are in order of severity and time."""

    red: bool
    line: str
    findings: tuple[Found, ...] = ()
    not_looked_at: tuple[str, ...] = ()
    clearances: tuple[Clearance, ...] = ()
    limits: LimitTable | None = None


def recorded_verdict(rec: Recording) -> Judged | None:
    """The verdict in a recording; None if it has none."""
    if not rec.result.get("verdict"):
        return None
    with rec.reading():
        return msgspec.convert(rec.fact("verdict"), Judged)
