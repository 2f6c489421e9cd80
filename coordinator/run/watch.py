"""What a run reports while it runs: the command line draws it, a script finds the sentences in its log."""

import logging

from heavylift.nodes.devs import Event

LOG = logging.getLogger("heavylift.run")


class RunObserver:
    """Observer of a run: receives committed events, simulation time and sentences; this one logs the sentences at level
    INFO."""

    def event(self, event: Event) -> None:
        """A committed event."""

    def progress(self, t_ns: int) -> None:
        """All samples up to this simulation time have arrived."""

    def waiting(self) -> None:
        """All possible grants are given; called repeatedly while no answer arrives."""

    def say(self, sentence: str) -> None:
        """A sentence for the user."""
        LOG.info(sentence)


class Relay(RunObserver):
    """Passes to `_watch` what it does not override."""

    _watch: RunObserver

    def event(self, event: Event) -> None:
        self._watch.event(event)

    def progress(self, t_ns: int) -> None:
        self._watch.progress(t_ns)

    def waiting(self) -> None:
        self._watch.waiting()

    def say(self, sentence: str) -> None:
        self._watch.say(sentence)
