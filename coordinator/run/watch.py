"""What a run tells while it runs; the command line draws it, tests and scripts need not."""

from heavylift.nodes.devs import Event

__all__ = ["Watch"]


class Watch:
    """Hears of every committed event and of the simulation time; this one keeps silent."""

    def event(self, event: Event) -> None:
        """A committed event."""

    def progress(self, t_ns: int) -> None:
        """Samples up to this simulation time have come."""

    def say(self, sentence: str) -> None:
        """Something that the user should know or do now."""
