"""Parts of a scene that nothing ties together, each with steps of its own.

components       which bodies are tied together, with all that acts on them
choice           whether a scene is solved as one or as islands
islands          simulations that are solved apart
running_ahead    islands run ahead of each other, and go back to what one of them is reported; in threads
island           one of them, how it goes back, and how it goes on where others stood
dense_output     values between samples, from a second run
sample_merge     samples, log and notes of the scene from those of its islands
"""

from typing import TYPE_CHECKING

from heavylift.kernel.on_demand import face, on_demand

if TYPE_CHECKING:
    from .choice import simulate
    from .islands import Islands

__all__ = ["Islands", "simulate"]
__getattr__ = on_demand(__name__, {"Islands": ".islands", "simulate": ".choice"})

face(__name__)
