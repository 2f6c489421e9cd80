"""Brings the nodes of a run to its hub: processes over a private socket, or objects of this process over a session."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from heavylift.coordinator.hosts.door import Door
from heavylift.coordinator.participants import NODE_MODULE, PRELOAD
from heavylift.coordinator.participants.participant import Participant
from heavylift.coordinator.supervision.failover import DEADLINE_s, Succession
from heavylift.coordinator.supervision.processes import Processes
from heavylift.coordinator.transport.hub import Hub
from heavylift.coordinator.transport.local_hub import LocalHub
from heavylift.coordinator.transport.placement import Placement

if TYPE_CHECKING:
    from heavylift.coordinator.participants.recalled import Past


@contextmanager
def joined(
    placement: Placement,
    in_process: bool,
    processes: Processes | None = None,
    door: Door | None = None,
    deadline: float = DEADLINE_s,
    past: Past | None = None,
) -> Iterator[Hub | LocalHub]:
    """The hub of the nodes of a placement, started in its order; at the end all processes are gone.

    Processes of other hosts are not started here, they come in at the `door`; nor are external ones.  A process that
    owes an answer for `deadline` [s] is probed.  `past`: of a kernel in this process, what is known of its run already.
    """
    if in_process:
        with LocalHub(placement.models) as local:
            for node, models in local.placement.nodes.items():
                link = local.link(node)
                participant = Participant(models, link.send, link.sample, past)
                link.serve(participant.handle)
                local.causes[node] = participant.cause
            yield local
        return
    crew = processes or Processes(PRELOAD)
    with crew, Succession(placement, crew, door, deadline) as hub:  # the keeper is the last to leave
        crew.start(hub, {p: (NODE_MODULE,) for p in placement.processes if p not in placement.awaited})
        yield hub
