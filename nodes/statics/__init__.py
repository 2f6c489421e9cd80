"""Statics of a scene: the equilibrium path along its action list.

follow(plan) -> Followed    all points of the path, with the actions that led there; notes, and why it ended
StaticState                 a point of the path: what stands where, and what carries how much
following(plan, path)       the same as the rules of a lift see it: cranes, trolleys, hooks, loads of loaders
"""

from .follow import Followed, follow
from .lift import Following, State, Step, following, goal_states
from .state import Acted, StaticState

__all__ = ["Acted", "Followed", "Following", "State", "StaticState", "Step", "follow", "following", "goal_states"]
