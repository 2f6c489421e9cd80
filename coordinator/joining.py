"""Brings the nodes of a run to its hub: processes over a private socket, or objects of this process over a session."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from .hub import Hub, LocalHub
from .participant import NODE_MODULE, PRELOAD, Participant
from .processes import Processes

__all__ = ["joined"]


@contextmanager
def joined(names: Sequence[str], in_process: bool, processes: Processes | None = None) -> Iterator[Hub | LocalHub]:
    """The hub of these nodes, started in this order; at the end all processes are gone."""
    if in_process:
        with LocalHub(names) as local:
            for name in names:
                link = local.link(name)
                link.serve(Participant(name, link.send, link.sample).handle)
            yield local
        return
    with Hub(names) as hub, processes or Processes(PRELOAD) as crew:
        crew.start(hub, {name: (NODE_MODULE, name) for name in names})
        yield hub
