"""What a scene is refused for: what is moved to or carried beyond its limits at rest, each subject once.

Of places only the goals count; a winch or drive that stops by itself at its end is a finding, not a refusal.  So is
what is overloaded once a sling has parted, for that is why such a list is run, and what an interlock guards.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

import msgspec
from heavylift.nodes.limits.judging import uses_on_path
from heavylift.nodes.limits.messages import REFUSED, sentence
from heavylift.nodes.limits.slings import FERRULE
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.actions import parts
from heavylift.nodes.plan.limit import Use
from heavylift.nodes.statics import Followed, goal_states

from .findings import Findings

SAME = {"rope tension": "rope factor"}  # of hoist ropes, which are reported once
PLACES = ("rails", "girder", "rope length", "hook height")  # quantities that drives are moved to


def overloads(built: plan.Plan, statics: Followed) -> list[tuple[str, str]]:
    """(where, sentence) of each."""
    checked = (x for x in built.limits if x.known and x.quantity in REFUSED)
    refused = [x for x in checked if x.source != "assumed" and FERRULE not in x.source]  # that somebody has written
    if not refused or not statics.states:
        return []
    places = msgspec.structs.replace(built, limits=tuple(refused))
    if found := _refused(built, uses_on_path(places, goal_states(built, statics))):
        return found
    guarded = {rope for interlock in built.interlocks if interlock.stops for rope in interlock.hooks}
    loads = (x for x in refused if x.quantity not in PLACES and not guarded.intersection(x.elements))
    parting = next((n for n, action in enumerate(built.actions, 1) if parts(action)), inf)
    states = [x for x in statics.states if x.action < parting]
    return _refused(built, uses_on_path(msgspec.structs.replace(built, limits=tuple(loads)), states))


def _refused(built: plan.Plan, uses: Sequence[Use]) -> list[tuple[str, str]]:
    found = Findings()
    for use in (use for use in uses if use.beyond):
        limit, action = use.limit, built.actions[use.action - 1] if use.action else None
        where, stage = (action.where, use.stage) if action else ("", "")
        violation = (limit.subject, where or limit.where, sentence(use, ran=False))
        found.take(SAME.get(limit.quantity, limit.quantity), iter([violation]), stage, where)
    return found.list()
