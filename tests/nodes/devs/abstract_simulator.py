"""The abstract simulator of Parallel DEVS as printed (Chow, Zeigler 1994): one processor per model, nothing flattened.

A coordinator hands *-messages (say what leaves at this tag) and x-messages (transit, with this bag) to its children
and sorts their y-messages into bags; only tags, ports and the models' own functions are shared with the engine. It is
slow and plain, and the oracle for nested = flat.
"""

from __future__ import annotations

from collections.abc import Callable

from heavylift.nodes.devs import (
    FOREVER,
    NEVER,
    Atomic,
    Coupled,
    InPort,
    Message,
    Model,
    OutPort,
    Present,
    Tag,
    Transition,
    after,
)

Bags = dict[str, list[Message]]  # by port
Tell = Callable[[Transition], None]


class Processor:
    """tl, tn and three messages."""

    tn = FOREVER

    def begin(self) -> None:
        raise NotImplementedError

    def star(self, tag: Tag) -> Bags:
        raise NotImplementedError

    def x(self, tag: Tag, bag: Bags) -> None:
        raise NotImplementedError


class LeafProcessor(Processor):
    """Simulator of an atomic model."""

    def __init__(self, m: Atomic, tell: Tell) -> None:
        self.m, self.tell, self.tl = m, tell, Tag(0)
        self.said: list[tuple[str, Message]] = []
        m._present = self.present = Present()

    def begin(self) -> None:
        self.m.start()
        wait, self.m._wait = self.m._wait, None
        self.tn = FOREVER if wait in (None, NEVER) else Tag(wait or 0)

    def star(self, tag: Tag) -> Bags:
        present = self.present
        present.now, present.speaker, present.sources, present.values = tag, self.m, [], []
        self.m.output()
        present.speaker = None
        self.said = [(port.name, value) for port, value in zip(present.sources, present.values, strict=True)]
        y: Bags = {}
        for name, value in self.said:
            y.setdefault(name, []).append(value)
        return y

    def x(self, tag: Tag, bag: Bags) -> None:
        m, due = self.m, tag == self.tn
        self.present.now = tag
        ports = {name: m.ports[name] for name in sorted(bag)}
        mine = {port: list(bag[name]) for name, port in ports.items() if isinstance(port, InPort)}
        if not mine:
            kind = "internal"
            m.internal()
        elif due:
            kind = "confluent"
            m.confluent(mine)  # type: ignore[arg-type]
        else:
            kind = "external"
            m.external(tag.t - self.tl.t, mine)  # type: ignore[arg-type]
        wait, m._wait = m._wait, None
        if wait is not None:
            self.tn = FOREVER if wait == NEVER else after(tag, wait)
        self.tl = tag
        message = tuple((name, value) for name in ports for value in bag[name])
        self.tell(Transition(tag, m.path, kind, message, tuple(self.said) if due else ()))


class CoordinatorProcessor(Processor):
    """Coordinator of a coupled model."""

    def __init__(self, model: Coupled, tell: Tell) -> None:
        self.model = model
        self.children = {name: processor(model.children[name], tell) for name in sorted(model.children)}
        self.y: dict[str, Bags] = {}  # what each imminent child says at this tag

    def begin(self) -> None:
        for child in self.children.values():
            child.begin()
        self._advance()

    def star(self, tag: Tag) -> Bags:
        self.y = {name: child.star(tag) for name, child in self.children.items() if child.tn == tag}
        outs = {name: port for name, port in self.model.ports.items() if isinstance(port, OutPort)}
        return self._bags(outs, {})

    def x(self, tag: Tag, bag: Bags) -> None:
        for name, child in self.children.items():
            ins = {n: p for n, p in self.model.children[name].ports.items() if isinstance(p, InPort)}
            reaches = self._bags(ins, bag)
            if reaches or child.tn == tag:
                child.x(tag, reaches)
        self.y = {}
        self._advance()

    def _advance(self) -> None:
        self.tn = min((child.tn for child in self.children.values()), default=FOREVER)

    def _bags(self, targets: dict[str, InPort] | dict[str, OutPort], outside: Bags) -> Bags:  # type: ignore[type-arg]
        """The union over all couplings into each target, by source model and port, what comes from outside first."""
        bags: Bags = {}
        for name, port in targets.items():
            into = [source for source, target in self.model.couplings if target is port]
            distances = [("" if s.owner is self.model else s.owner.name, s.name) for s in into]
            for owner, source in sorted(distances):
                text = outside.get(source, []) if owner == "" else self.y.get(owner, {}).get(source, [])
                if text:
                    bags.setdefault(name, []).extend(text)
        return bags


def processor(model: Model, tell: Tell) -> Processor:
    """The processor of a model, by its kind."""
    if isinstance(model, Coupled):
        return CoordinatorProcessor(model, tell)
    assert isinstance(model, Atomic)
    return LeafProcessor(model, tell)


def nested(model: Model, until: int, tell: Tell) -> None:
    """The root coordinator: all tags at t < `until` [ns]."""
    root = processor(model, tell)
    root.begin()
    while root.tn.t < until:
        tag = root.tn
        root.star(tag)
        root.x(tag, {})
