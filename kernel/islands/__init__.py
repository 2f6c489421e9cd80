"""Islands: independent parts of a scene, each integrated with its own steps.

components       sets of coupled bodies, with the elements that act on them
choice           whether a scene is solved as one system or as islands
islands          simulations that are solved separately
running_ahead    islands run ahead of each other, and roll back for a command; in threads
island           one island, its rollback, and its start from the state of others
dense_output     values between samples, from a second run
sample_merge     samples, log and notes of the scene from those of its islands
"""

from typing import TYPE_CHECKING

from heavylift.kernel.on_demand import face, on_demand

if TYPE_CHECKING:
    from .choice import simulate
    from .islands import Islands

__all__ = ["Islands", "simulate"]
__getattr__ = on_demand(__name__)

face(__name__)
