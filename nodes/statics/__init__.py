"""Statics of a scene: the equilibrium path along its action list.

follow(plan) -> Followed    all points of the path, with the actions that led there; notes, and why it ended
StaticState                 a point of the path: what stands where, and what carries how much
following(plan, path)       the same as the rules of a lift see it: cranes, trolleys, hooks, loads of loaders

action_preview, rehearsal   the action list followed at rest, by the DEVS models themselves
touching                    how far rigid contacts let the path hold
aiming                      where moves end that are to end above lugs
swinging, listening         ramps that leave no swing, chosen by what swings on that path
state, static_state         a point of the path; the same as the rules of a lift see it
findings                    what the path tells besides loads
"""

from heavylift.kernel.on_demand import face

from .action_preview import Followed, follow
from .state import Acted, StaticState
from .static_state import Following, State, Step, following, goal_states

__all__ = ["Acted", "Followed", "Following", "State", "StaticState", "Step", "follow", "following", "goal_states"]

face(__name__)
