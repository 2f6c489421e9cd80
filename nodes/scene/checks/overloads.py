"""What a scene is refused for: what is moved to or carried beyond its limits at rest, each subject once.

Of places only the goals count; a winch or drive that stops by itself at its end is a finding, not a refusal.  So is
what is overloaded once a sling has parted, for that is why such a list is run, and what an interlock guards.
"""

from __future__ import annotations

from collections.abc import Sequence

from heavylift.nodes.limits.judging import judge, uses_on_path
from heavylift.nodes.limits.sentences import WORDS
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.actions import parts
from heavylift.nodes.plan.limit import Use
from heavylift.nodes.statics import Followed, goal_states

from .findings import Findings

__all__ = ["overloads"]

PLACES = ("rails", "girder", "rope length", "hook height")  # quantities that drives are moved to


def overloads(built: plan.Plan, statics: Followed, uses: Sequence[Use]) -> list[tuple[str, str]]:
    """(where, sentence) of each; `uses`: the worst of each limit on the path at rest."""
    parting = (n for n, action in enumerate(built.actions, 1) if parts(action))
    if first := next(parting, 0):
        uses = uses_on_path(built, [x for x in statics.states if x.action < first])
    guarded = {rope for interlock in built.interlocks if interlock.stops for rope in interlock.hooks}
    uses = [use for use in uses if not guarded.intersection(use.limit.elements)]
    goals = uses_on_path(built, goal_states(built, statics)) if built.lift else []
    return _refused(built, goals) or _refused(built, [use for use in uses if use.limit.quantity not in PLACES])


def _refused(built: plan.Plan, uses: Sequence[Use]) -> list[tuple[str, str]]:
    found = Findings()
    for use in (use for use in uses if WORDS[use.limit.quantity].refused):
        for finding in judge(built, [use], dynamic=False):
            if finding.severity == "red":
                where, stage = (finding.where, finding.stage) if use.action else ("", "")
                violation = (finding.subject, finding.where, finding.sentence)
                found.take(use.limit.quantity, iter([violation]), stage, where)
    return found.list()
