"""What can be asked of a compiled scene at one instant, besides where it goes next.

inverse     forces for given accelerations (the paper's Fig. 6 (a)-(e) read forwards)
reactions   all six components that every joint carries, and which of them rigid bodies do not determine
poses, linearise, equilibrium, modes   statics with one-sided laws; small motions about it
mobility    degrees of freedom by the rank of the constraint Jacobian
momentum    mass, centre, linear and angular momentum of a scene
"""

from .equilibrium import Equilibrium, equilibrium
from .inverse import inverse_dynamics
from .mobility import Mobility, mobility
from .modes import Mode, Modes, modes
from .momentum import Momentum, momentum
from .reactions import Reaction, Reactions, reactions

__all__ = [
    "Equilibrium", "Mobility", "Mode", "Modes", "Momentum", "Reaction", "Reactions", "equilibrium", "inverse_dynamics",
    "mobility", "modes", "momentum", "reactions",
]  # fmt: skip
