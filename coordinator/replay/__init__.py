"""A recording played again: for observers, for proof, for one model.

cast        the models of a recorded run, built again
recorded    what a recording holds, as the models and the events that the run was made of
picture     the same for the page that shows runs
publish     the committed events and samples over Zenoh, at any rate, with keys
verify      the whole scene simulated again: every event and sample must come again
single      one model for real against the recorded rest: where it first deviates
deviation   where a new run parts from a recorded one
"""

from .deviation import Deviation, Outcome
from .publish import Player, Publisher, Replay, Said
from .recorded import RecordedRun
from .single import single
from .verify import verify

__all__ = [
    "Deviation", "Outcome", "Player", "Publisher", "RecordedRun", "Replay", "Said", "single", "verify",
]  # fmt: skip
