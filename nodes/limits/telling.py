"""Uses of limits in a planner's words: findings of what is beyond its limit, and the rows of the table."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isfinite

from heavylift.nodes.plan.limit import Finding, Limit, Use
from heavylift.nodes.plan.plan import Plan
from msgspec.structs import replace

from .sentences import NOISE, WORDS, bound, percent, shown

SAME = 1e-6  # of the worst value: what comes so close to it came to it first, or is told first
HEAD = ("limit", "worst of", "worst", "at", "may be", "use", "source")


def finding_of(plan: Plan, use: Use, *, dynamic: bool) -> Finding | None:
    """What is to be said of a use, if anything: red beyond its limit, a warning beyond what is told."""
    limit, value = use.limit, use.value
    if value is None:
        return None
    told = limit.warning is not None and value > limit.warning
    if not use.beyond and not told:
        return None
    words = WORDS[limit.quantity]
    actions = {number: action.where for number, action in enumerate(plan.actions, 1)}
    return Finding(
        severity="red" if use.beyond else "warning",
        kind=words.kind,
        subject=limit.subject,
        sentence=words.sentence(use, dynamic),
        where=actions.get(use.action, "") or limit.where,
        stage=use.stage,
        t=use.t if dynamic else None,
        value=value,
        limit=bound(use) if use.beyond else limit.warning,
        unit=limit.unit,
    )


def sorted_findings(findings: Iterable[Finding]) -> list[Finding]:
    """Red ones first, then in the order of the table."""
    return sorted(findings, key=lambda f: ("red", "warning", "note").index(f.severity))


def likewise(findings: Iterable[Finding]) -> list[Finding]:
    """Findings of one kind, limit and stage as one, which tells the first in full and names the others."""
    groups: dict[object, list[Finding]] = {}
    for f in findings:
        groups.setdefault((f.severity, f.kind, f.limit, f.unit, f.stage), []).append(f)
    return [_together(group) for group in groups.values()]


def _together(group: list[Finding]) -> Finding:
    first = group[0]
    others = list(dict.fromkeys(f.subject for f in group[1:] if f.subject != first.subject))
    return replace(first, sentence=f"{first.sentence}; likewise {', '.join(others)}") if others else first


def rows(uses: Sequence[Use], *, every: bool = False) -> list[tuple[str, ...]]:
    """Cells under `HEAD`: per quantity and limit the subject that uses it most; `every`: all subjects."""
    groups: dict[object, list[Use]] = {}
    for number, use in enumerate(uses):
        if use.value is not None:
            key = (number,) if every else (use.limit.quantity, use.limit.over, use.limit.known)
            groups.setdefault(key, []).append(use)
    return [_row(group) for group in groups.values()]


def _row(group: list[Use]) -> tuple[str, ...]:
    sizes = [_size(use) for use in group]
    most = max(sizes)
    least = most - SAME * abs(most) if isfinite(most) else most  # beyond a chart nothing may hang: infinite
    worst = next(use for use, size in zip(group, sizes, strict=True) if size >= least)
    limit = worst.limit
    many = len({use.limit.subject for use in group})
    subject = limit.subject if many == 1 else f"{limit.subject} (of {many})"
    at = ", ".join(part for part in (clock(worst.t), worst.stage) if part)
    source = "; ".join(part for part in (limit.source, limit.note) if part)
    used = "" if worst.use is None or limit.between is not None else percent(worst.use)
    return (limit.quantity, subject, shown(limit, worst.value), at, _allowed(worst), used, source)


def _size(use: Use) -> float:
    """How bad a use is among others of its kind."""
    value = use.value or 0.0
    if abs(value) < NOISE.get(use.limit.unit, 0.0):
        return 0.0
    return value if use.use is None else use.use


def unjudged(limits: Iterable[Limit], uses: Sequence[Use] = ()) -> list[str]:
    """What nobody judged, in sentences: limits that are not known, and what could not be read."""
    unknown: dict[str, list[Limit]] = {}
    for limit in limits:
        if not limit.known:
            unknown.setdefault(limit.quantity, []).append(limit)
    found = []
    for quantity, group in unknown.items():
        why = ", ".join(dict.fromkeys(limit.note for limit in group if limit.note)) or "no limit is known"
        found.append(f"{quantity} of {_few([limit.subject for limit in group])}: not judged; {why}")
    unread: dict[str, list[str]] = {}
    for use in uses:
        if use.value is None and use.limit.known:
            unread.setdefault(use.limit.quantity, []).append(use.limit.subject)
    return found + [f"{quantity} of {_few(names)}: nothing to judge" for quantity, names in unread.items()]


def _few(names: Sequence[str]) -> str:
    each = list(dict.fromkeys(names))
    return ", ".join(each[:3]) + (f" and {len(each) - 3} more" if len(each) > 3 else "")


def clock(t: float | None) -> str:
    """A time of a run, m:ss.s or h:mm:ss.s; nothing for the start, or where there is none."""
    minutes, seconds = divmod(round(t or 0.0, 1), 60.0)
    hours, minutes = divmod(int(minutes), 60)
    return (f"{hours}:{minutes:02}:{seconds:04.1f}" if hours else f"{minutes}:{seconds:04.1f}") if t else ""


def _allowed(use: Use) -> str:
    limit = use.limit
    if not limit.known:
        return "not known"
    if limit.between is not None:
        return f"{limit.between[0]:g} to {limit.between[1]:g} {limit.unit}"
    return ("at least " if limit.least else "") + shown(limit, bound(use))
