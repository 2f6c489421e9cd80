"""Notifications of a run in progress; the command line displays them, a script finds the sentences in its log."""

import logging

from heavylift.nodes.devs import Event

LOG = logging.getLogger("heavylift.run")


class RunObserver:
    """Observer of a run: receives committed events, simulation time and sentences; the base class logs sentences as
    INFO."""

    def event(self, event: Event) -> None:
        """Receive an event that the coordinator has committed."""

    def progress(self, t_ns: int) -> None:
        """Receive the simulation time [ns] up to which all samples have arrived."""

    def waiting(self) -> None:
        """Called repeatedly while the coordinator waits for the answers of nodes."""

    def say(self, sentence: str) -> None:
        """Receive a sentence to show to the user."""
        LOG.info(sentence)


class Relay(RunObserver):
    """Observer that forwards events, times and sentences to another observer; subclasses handle some themselves."""

    _watch: RunObserver

    def event(self, event: Event) -> None:
        self._watch.event(event)

    def progress(self, t_ns: int) -> None:
        self._watch.progress(t_ns)

    def waiting(self) -> None:
        self._watch.waiting()

    def say(self, sentence: str) -> None:
        self._watch.say(sentence)
