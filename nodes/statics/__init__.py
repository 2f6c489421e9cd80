"""Statics of a scene: the equilibrium path along its action list.

follow(plan) -> Followed    all states on the path, with the actions that led there; notes, and why it ended
StaticState                 a state on the path: poses, and loads on ropes and supports

static_path, static_run     the action list followed statically
models_at_rest              the DEVS models for that, the same as in a run
contact_limits              rigid contacts, at which the path ends
aiming                      end positions of moves to above lugs
swinging, listening         ramps that leave no swing, from the swing periods on the path
state, resting              a state on the path; scenes at rest at the start
findings                    findings about the path other than loads
"""

from heavylift.kernel.on_demand import face

from .aiming import goal_states
from .state import Acted, StaticState
from .static_path import Followed, follow

__all__ = ["Acted", "Followed", "StaticState", "follow", "goal_states"]

face(__name__)
