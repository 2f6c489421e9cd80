"""A coordinator that also accepts events, and a later end of the run, from outside the nodes, such as an operator's
commands.

An event from outside may come at any tag from `safe` on, the latest of
  until_i   of every node: its window while it runs, else what it has reached
  next_i    of every node whose offer is committed and not yet granted
  floor     below which all events have left
and it goes into its receivers' bags there, in the total order. Nothing that was decided can change by it: a node that
ran did so below until_i; the receiver's reaction comes at or after the tag, and so after every window that was granted;
only an input before next_i refutes a committed offer. So the same events, known from the beginning, give the same run.
With `ready(horizon)` nothing is decided at or after the horizon, so that `safe` never lies above it.
"""

from heavylift.kernel.errors import ProtocolError
from heavylift.nodes.devs import Event, Tag

from .core import Coordinator


class OpenCoordinator(Coordinator):
    """A coordinator that also accepts events from outside, whose sources are not nodes, such as an operator's
    commands."""

    def extend(self, end: Tag) -> None:
        """Move the time bound of the run to a later time, unless a model has already ended it."""
        if not self._finished:
            self.end = max(self.end, end)

    @property
    def safe(self) -> Tag:
        """The earliest logical time at which an event from outside can still be injected."""
        nodes = self._nodes.values()
        committed = (node.next for node in nodes if node.committed and not node.running)
        return max(self.floor, *(node.until for node in nodes), *committed)

    @property
    def safe_ns(self) -> int:
        """The earliest whole nanosecond [ns] at which an event from outside can still be injected."""
        safe = self.safe
        return safe.t + (safe.k > 0)

    def inject(self, event: Event) -> None:
        """Inject an event from outside at or after `safe`; raises ProtocolError if it is earlier or has no
        receivers."""
        if (event.source, event.port) not in self._receivers or event.source in self._home:
            raise ProtocolError(f"no node receives outside events on {event.source}.{event.port}; couple this port")
        if event.tag < self.safe:
            raise ProtocolError(
                f"{event.source}.{event.port} at {event.tag}: everything up to {self.safe} "
                "has already been computed; choose a later time"
            )
        self._hold(event)
