"""Analyses of a compiled scene at one instant.

equilibrium                            static equilibrium, with the states of one-sided laws there
path, corrector                        equilibria along commanded motions: steps, events; predictor and corrector
modes, poses                           small motions about a pose; the results as text and as data
linear                                 x' = A x + B u, y = C x + D u, by derivatives of the equations
momentum                               mass, centre, linear and angular momentum

Joint reactions, mobility and inverse dynamics can also be imported from here; `model.reactions` and `multibody` define
them.
"""

from heavylift.kernel.model.reactions.joint_reactions import Reaction, Reactions, reactions
from heavylift.kernel.model.reactions.mobility import Mobility, mobility
from heavylift.kernel.multibody.dynamics import inverse_dynamics
from heavylift.kernel.on_demand import face

from .equilibrium import Equilibrium, equilibrium
from .modes import Modes, NaturalMode, modes
from .momentum import Momentum, momentum

__all__ = [
    "Equilibrium", "Mobility", "Modes", "Momentum", "NaturalMode", "Reaction", "Reactions", "equilibrium",
    "inverse_dynamics", "mobility", "modes", "momentum", "reactions",
]  # fmt: skip

face(__name__)
