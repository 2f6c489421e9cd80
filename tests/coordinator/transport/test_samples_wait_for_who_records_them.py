"""A node that samples faster than it is recorded is held up, so that what waits does not fill the memory."""

from __future__ import annotations

from threading import Thread
from typing import Any

import pytest
from heavylift.coordinator.transport import BATCHES, Hub, hub as hub_module


def test_a_node_that_sends_samples_waits_until_the_coordinator_has_handled_earlier_batches(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(hub_module, "FULL_s", 1e6)
    with Hub(["node"]) as hub:
        arrived: list[Any] = []

        def sends() -> None:
            for batch in range(2 * BATCHES):
                arrived.append(batch)
                hub._arrived(batch)  # type: ignore[arg-type]

        sender = Thread(target=sends, daemon=True)
        sender.start()
        sender.join(0.2)
        taken: list[Any] = []
        while len(taken) < 2 * BATCHES:
            assert len(hub._batches) <= BATCHES + 1
            while hub._batches:
                taken.append(hub._batches.popleft())
        sender.join(20.0)
        assert not sender.is_alive()
        assert taken == arrived == [*range(2 * BATCHES)]


def test_a_node_waits_no_longer_than_a_short_limit_for_the_coordinator_to_take_its_samples(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Nobody who has left, or who is busy with another node, is waited for."""
    monkeypatch.setattr(hub_module, "FULL_s", 0.0)
    with Hub(["node"]) as hub:
        for batch in range(2 * BATCHES):
            hub._arrived(batch)  # type: ignore[arg-type]
        assert len(hub._batches) == 2 * BATCHES
        hub._batches.clear()
