"""A signal that comes while samples go on record waits until they stand there: none is lost between hub and tape."""

import os
import signal
from types import SimpleNamespace

import pytest
from heavylift.coordinator.participants.configuration import Wiring
from heavylift.coordinator.record.tape import Tape
from heavylift.coordinator.run.conversation import Conversation
from heavylift.coordinator.run.watch import Watch
from heavylift.coordinator.stopping import Interrupted, Stopping
from heavylift.nodes.devs import Tag


class Struck(Tape):
    """Keeps batches; while it takes the second, Ctrl-C is pressed."""

    def __init__(self):
        super().__init__()
        self.kept = []

    def samples(self, node, batch):
        if len(self.kept) == 1:
            os.kill(os.getpid(), signal.SIGINT)
        self.kept.append(batch)
        return len(self.kept)


def test_every_batch_that_was_taken_is_kept_before_the_run_stops():
    arrived = [[("kernel", b"first"), ("kernel", b"second"), ("kernel", b"third")]]
    hub = SimpleNamespace(placement=SimpleNamespace(nodes={}), samples=lambda: arrived.pop() if arrived else [])
    tape = Struck()
    talk = Conversation(hub, Wiring([], [], None), Tag(10), tape, Watch())
    talk._begun = True
    stopping = Stopping()
    try:
        with pytest.raises(Interrupted):
            talk._take_samples()
    finally:
        stopping.end()
    assert tape.kept == [b"first", b"second", b"third"]
    assert talk.now.t == 3
