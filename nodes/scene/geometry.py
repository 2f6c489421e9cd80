"""Whether a scene fits: portals, trolleys, ropes, hooks, lugs, slings and the block on its stools.

Each check is one function that yields (where, sentence); the states come from following the action list.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import TypeAlias

from . import plan, schema
from .follow import Follower, Step, reach
from .machines import HOOKS, exit_height

Told: TypeAlias = Iterator[tuple[str, str]]
SAME_LEVEL = 5.0  # trolleys whose ropes leave closer together in height meet [m]


def geometry_checks(scene: schema.Scene, built: plan.Plan, steps: list[Step]) -> list[tuple[str, str]]:
    """All that does not fit, at the start and after each action."""
    found = [told for check in _ONCE for told in check(scene, built)]
    for before, after in pairwise([steps[0], *steps]):
        found += [told for each in _ALWAYS for told in each(scene, built, before, after)]
    seen: set[str] = set()
    return [seen.add(s[0] + s[1]) or s for s in found if s[0] + s[1] not in seen]  # type: ignore[func-returns-value]
