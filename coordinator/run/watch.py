"""What a run reports while it runs: the command line draws it, a script finds the sentences in its log."""

import logging

from heavylift.nodes.devs import Event

LOG = logging.getLogger("heavylift.run")


class RunObserver:
    """Hears of every committed event and of the simulation time; this one logs what is said, at level INFO."""

    def event(self, event: Event) -> None:
        """A committed event."""

    def progress(self, t_ns: int) -> None:
        """Samples up to this simulation time have come."""

    def waiting(self) -> None:
        """All that can be granted is granted; again and again while no answer comes."""

    def say(self, sentence: str) -> None:
        """Something that the user should know or do now."""
        LOG.info(sentence)


class Relay(RunObserver):
    """Passes on to `_watch` what it does not override."""

    _watch: RunObserver

    def event(self, event: Event) -> None:
        self._watch.event(event)

    def progress(self, t_ns: int) -> None:
        self._watch.progress(t_ns)

    def waiting(self) -> None:
        self._watch.waiting()

    def say(self, sentence: str) -> None:
        self._watch.say(sentence)
