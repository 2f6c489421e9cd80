"""A signal that comes while samples go on record waits until they stand there: none is lost between hub and tape."""

import signal
from types import SimpleNamespace

import pytest
from heavylift.coordinator.participants import Wiring
from heavylift.coordinator.record import RunRecorder
from heavylift.coordinator.run import Conversation, RunObserver
from heavylift.coordinator.stopping import Interrupted, Stopping
from heavylift.kernel import RecordingError, Stopped
from heavylift.nodes.devs import Tag


class Struck(RunRecorder):
    """Keeps batches; while it takes the second, Ctrl-C is pressed."""

    def __init__(self):
        super().__init__()
        self.kept = []

    def samples(self, node, batch):
        if batch == b"gap":
            raise RecordingError("samples are missing")
        if len(self.kept) == 1:
            signal.raise_signal(signal.SIGINT)
        self.kept.append(batch)
        return len(self.kept)


def conversation(arrived, recorder):
    hub = SimpleNamespace(
        placement=SimpleNamespace(nodes={}),
        samples=lambda: arrived.pop() if arrived else [],
        dismiss=lambda message: None,
    )
    talk = Conversation(hub, Wiring([], [], None), Tag(10), recorder, RunObserver())
    talk._begun = True
    return talk


def test_after_an_interrupt_every_received_batch_of_samples_is_recorded_before_the_run_stops():
    recorder = Struck()
    talk = conversation([[("kernel", b"first"), ("kernel", b"second"), ("kernel", b"third")]], recorder)
    stopping = Stopping()
    try:
        with pytest.raises(Interrupted):
            talk._take_samples()
    finally:
        stopping.end()
    assert recorder.kept == [b"first", b"second", b"third"]
    assert talk.now.t == 3


def test_a_run_can_be_aborted_even_if_a_signal_handler_has_lost_a_batch_of_samples():
    """Python's own handler raises wherever the run is; what follows on a batch that was lost there is left out."""
    talk = conversation([[("kernel", b"gap")]], Struck())
    with pytest.raises(Stopped, match=r"stopped by the user at 0\.000 s"):
        talk.abort(KeyboardInterrupt())
