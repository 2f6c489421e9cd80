"""Findings about a scene or a run."""

from __future__ import annotations

from typing import Literal

import msgspec

Severity = Literal["red", "warning", "note"]


class Finding(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What was found of a subject: a sentence for planners, and the numbers behind it."""

    severity: Severity
    kind: str  # "overload", "off-lead", "clearance", "two-blocked", "geometry", "stage", "cut", ...
    subject: str  # the element's name as the scene has it
    sentence: str
    where: str = ""  # file:line:column of what the planner would change
    stage: str = ""
    t: float | None = None  # [s] simulation time of the worst value
    value: float | None = None
    limit: float | None = None
    unit: str = ""
