"""What can be asked of a compiled scene at one instant, besides where it goes next.

inverse     forces for given accelerations (the paper's Fig. 6 (a)-(e) read forwards)
reactions   all six components that every joint carries
poses, linearise, equilibrium, modes   statics with one-sided laws; small motions about it
momentum    mass, centre, linear and angular momentum of a scene
"""

from .equilibrium import Equilibrium, equilibrium
from .inverse import inverse_dynamics
from .modes import Mode, Modes, modes
from .momentum import Momentum, momentum
from .reactions import Reaction, reactions

__all__ = [
    "Equilibrium", "Mode", "Modes", "Momentum", "Reaction", "equilibrium", "inverse_dynamics", "modes", "momentum",
    "reactions",
]  # fmt: skip
