"""Replay of a recording for observers or for one model; `coordinator.run.verify` repeats the whole run.

recorded    the models and events of a recorded run
publish     committed events and samples over Zenoh or to the live page, at any rate, with keys
deviation   first deviation of a new run from a recorded one; one real model with recorded inputs
"""

from heavylift.kernel.on_demand import face

from .deviation import Deviation, ReplayResult, single
from .publish import Player, PublishedItem, Publisher, Replay
from .recorded import RecordedRun

__all__ = [
    "Deviation", "Player", "PublishedItem", "Publisher", "RecordedRun", "Replay", "ReplayResult", "single",
]  # fmt: skip

face(__name__)
