"""Statics of a scene: the equilibrium path along its action list.

follow(plan) -> Followed    all points of the path, with the actions that led there; notes, and why it ended
StaticState                 a point of the path: what stands where, and what carries how much

static_path, static_run   the action list followed at rest, by the DEVS models themselves
contact_limits                    how far rigid contacts let the path hold
aiming                      where moves end that are to end above lugs
swinging, listening         ramps that leave no swing, chosen by what swings on that path
state, goals, resting       a point of the path; where moves are to lead; scenes as they rest at the start
findings                    what the path tells besides loads
"""

from heavylift.kernel.on_demand import face

from .goals import goal_states
from .state import Acted, StaticState
from .static_path import Followed, follow

__all__ = ["Acted", "Followed", "StaticState", "follow", "goal_states"]

face(__name__)
