"""A protocol that is wrong, for tests that must see it."""

from heavylift.nodes.devs import Event, Tag, succ
from random_models import END, Logs, parts


def wave(seed: int) -> Logs:
    """Mutant: all imminent nodes in one wave; what they say to other nodes arrives at the next microstep."""
    logs: Logs = {}
    simulators, couplings = parts(seed, logs)
    pending: list[tuple[Tag, str, Event]] = []
    for simulator in simulators.values():
        simulator.start()
    while True:
        tag = min([s.next_time for s in simulators.values()] + [when for when, _, _ in pending])
        if tag.t >= END:
            return logs
        now = [(name, event) for when, name, event in pending if when == tag]
        pending = [entry for entry in pending if entry[0] != tag]
        text: list[Event] = []
        for name, simulator in simulators.items():
            bag = sorted(event for to, event in now if to == name)
            due = simulator.next_time == tag
            text += simulator.outputs() if due else []
            if bag or due:
                simulator.advance(tag, bag)
        for event in text:
            pending += [
                (succ(tag), target, event)
                for target in {t: 0 for source, port, t, _ in couplings if (source, port) == (event.source, event.port)}
            ]
