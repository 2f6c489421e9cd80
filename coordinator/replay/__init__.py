"""A recording played again: for observers, for one model; the whole of it for proof is `coordinator.run.verify`.

recorded    what a recording holds, as the models and the events that the run was made of
publish     the committed events and samples over Zenoh, at any rate, with keys; the same for the page that shows runs
deviation   where a new run parts from a recorded one; one model for real against the recorded rest
"""

from heavylift.kernel.on_demand import face

from .deviation import Deviation, ReplayResult, single
from .publish import Player, PublishedItem, Publisher, Replay
from .recorded import RecordedRun

__all__ = [
    "Deviation", "Player", "PublishedItem", "Publisher", "RecordedRun", "Replay", "ReplayResult", "single",
]  # fmt: skip

face(__name__)
