"""Delays messages at random in the processes of a disturbed run; imported by Python at start-up."""

import os

SEED = os.environ.get("DISTURBED_DELIVERY")
LATEST_s = 0.001

if SEED is not None:
    import time
    from random import Random

    from heavylift.coordinator.transport import link

    _send = link._Sender.send

    def late(self: link._Sender, payload: bytes) -> None:
        """Wait, differently in each process and for each message."""
        if not hasattr(late, "random"):
            late.random = Random(f"{SEED} {self.node} {os.getpid()}")  # type: ignore[attr-defined]
        time.sleep(LATEST_s * late.random.random() ** 2)  # type: ignore[attr-defined]
        _send(self, payload)

    link._Sender.send = late  # type: ignore[method-assign]
