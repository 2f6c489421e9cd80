"""A recording played again: for observers, for one model; the whole of it for proof is `coordinator.run.verify`.

cast        the models of a recorded run, built again
recorded    what a recording holds, as the models and the events that the run was made of
picture     the same for the page that shows runs
publish     the committed events and samples over Zenoh, at any rate, with keys
single      one model for real against the recorded rest: where it first deviates
deviation   where a new run parts from a recorded one
"""

from heavylift.kernel.on_demand import face

from .deviation import Deviation, Outcome
from .publish import Player, Publisher, Replay, Said
from .recorded import RecordedRun
from .single import single

__all__ = [
    "Deviation", "Outcome", "Player", "Publisher", "RecordedRun", "Replay", "Said", "single",
]  # fmt: skip

face(__name__)
