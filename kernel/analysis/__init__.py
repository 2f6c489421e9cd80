"""What can be asked of a compiled scene at one instant, besides where it goes next.

inverse     forces for given accelerations (the paper's Fig. 6 (a)-(e) read forwards)
reactions   all six components that every joint carries
momentum    mass, centre, linear and angular momentum of a scene
"""

from .inverse import inverse_dynamics
from .momentum import Momentum, momentum
from .reactions import Reaction, reactions

__all__ = ["Momentum", "Reaction", "inverse_dynamics", "momentum", "reactions"]
