"""Statics of a scene: the equilibrium path along its action list.

follow(plan) -> Followed    all points of the path, with the actions that led there; notes, and why it ended
StaticState                 a point of the path: poses, and loads of ropes and supports

static_path, static_run     the action list followed statically, by the DEVS models themselves
contact_limits              where rigid contacts end the path
aiming                      goals of moves that end above lugs
swinging, listening         ramps that leave no swing, by the swing periods on that path
state, resting              a point of the path; goals of moves; scenes at rest at the start
findings                    findings of the path other than loads
"""

from heavylift.kernel.on_demand import face

from .aiming import goal_states
from .state import Acted, StaticState
from .static_path import Followed, follow

__all__ = ["Acted", "Followed", "StaticState", "follow", "goal_states"]

face(__name__)
