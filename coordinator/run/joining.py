"""Brings the nodes of a run to its hub: processes over a private socket, or objects of this process over a session."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from heavylift.coordinator.hosts.door import Door
from heavylift.coordinator.participants.participant import NODE_MODULE, PRELOAD, Participant
from heavylift.coordinator.supervision.failover import DEADLINE_s, Succession
from heavylift.coordinator.supervision.processes import Processes
from heavylift.coordinator.transport.hub import Hub
from heavylift.coordinator.transport.local_hub import LocalHub
from heavylift.coordinator.transport.placement import Placement

__all__ = ["joined"]


@contextmanager
def joined(
    placement: Placement,
    in_process: bool,
    processes: Processes | None = None,
    door: Door | None = None,
    deadline: float = DEADLINE_s,
) -> Iterator[Hub | LocalHub]:
    """The hub of the nodes of a placement, started in its order; at the end all processes are gone.

    Processes of other hosts are not started here; they come in at the `door`.  A process that owes an answer for
    `deadline` [s] is probed.
    """
    if in_process:
        with LocalHub(placement.nodes) as local:
            for name in placement.nodes:
                link = local.link(name)
                link.serve(Participant(name, link.send, link.sample).handle)
            yield local
        return
    crew = processes or Processes(PRELOAD)
    with crew, Succession(placement, crew, door, deadline) as hub:  # the keeper is the last to leave
        crew.start(hub, {p: (NODE_MODULE,) for p in placement.processes if p not in placement.remote})
        yield hub
