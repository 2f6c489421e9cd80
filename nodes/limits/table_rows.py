"""Uses of limits in a planner's words: findings of what is beyond its limit."""

from __future__ import annotations

from collections.abc import Iterable

from heavylift.kernel.description.findings import Finding
from heavylift.nodes.plan.limit import Use
from heavylift.nodes.plan.plan import Plan
from msgspec.structs import replace

from .messages import WORDS, bound

SAME = 1e-6  # of the worst value: what comes so close to it came to it first, or is reported first


def finding_of(plan: Plan, use: Use, *, dynamic: bool) -> Finding | None:
    """The finding of a use at the worst of uncertain inputs: red beyond its limit, a warning beyond its warning level,
    else None."""
    limit, worst = use.limit, use.at_worst
    message = f", at the worst of {limit.inputs}" if worst is not use else ""
    use, value = worst, worst.value
    if value is None:
        return None
    if not use.beyond and not (limit.warning is not None and value > limit.warning):
        return None
    words = WORDS[limit.quantity]
    actions = {number: action.where for number, action in enumerate(plan.actions, 1)}
    return Finding(
        severity="red" if use.beyond else "warning",
        kind=words.kind,
        subject=limit.subject,
        sentence=words.sentence(use, dynamic) + message,
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
    """Findings of one kind, limit and stage merged into one that names the others."""
    groups: dict[object, list[Finding]] = {}
    for f in findings:
        groups.setdefault((f.severity, f.kind, f.limit, f.unit, f.stage), []).append(f)
    return [_together(group) for group in groups.values()]


def _together(group: list[Finding]) -> Finding:
    first = group[0]
    others = list(dict.fromkeys(f.subject for f in group[1:] if f.subject != first.subject))
    return replace(first, sentence=f"{first.sentence}; likewise {', '.join(others)}") if others else first
