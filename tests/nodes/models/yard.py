"""The turnover plan of these tests, and a stand-in for the kernel.

The double takes kernel inputs down in a log and says the state events of a script, to the nodes that
subscribe.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from functools import cache
from typing import TypeVar

import msgspec
from heavylift.nodes import drive
from heavylift.nodes.devs import Atomic, Bag, Coupled, Message, Model, Simulator, Transition, seconds
from heavylift.nodes.models import CommanderModel, build, couplings, subscriptions
from heavylift.nodes.models.parts import KernelInput, StateEvent
from heavylift.nodes.plan import Action, Mechanism, Plan
from heavylift.nodes.scene import load

replace = msgspec.structs.replace
M = TypeVar("M", bound=Message)
LUGS = {
    "A": (-14.6, 0.0, (10.0, 14.0, 22.0, 26.0)),
    "B": (12.0, 5.6, (16.0, 20.0)),
    "B'": (12.0, -5.6, (16.0, 20.0)),
}
HOOKS = ("H1", "H2", "H3")
WORDS = {  # lugs of the scene by those of the tests, which say where they are
    f"{word}{i}": f"{group}{u:+d}"
    for word, (group, places) in {
        "A": ("A", (-26, -22, -14, -10, 10, 14, 22, 26)),
        "B": ("B", (-20, -16, 16, 20)),
        "C": ("B'", (-20, -16, 16, 20)),
    }.items()
    for i, u in enumerate(places, 1)
}


@cache
def scene() -> Plan:
    return load("turnover").plan


def turnover(*actions: Action, hooked: str = "AB", end: float | None = None) -> Plan:
    """The plan of the scene `turnover` at the start of the lift, with any action list."""
    east, west, *others = scene().machines
    machines = tuple(_rigged(machine, hooked) for machine in (west, east, *others))
    return replace(scene(), machines=machines, actions=actions, end=end, limits=(), interlocks=())


def _rigged(machine: Mechanism, hooked: str) -> Mechanism:
    """A machine with the words for lugs, its slings hooked to those of some groups only."""
    cargo = tuple(replace(c, lugs={WORDS[lug]: p for lug, p in c.lugs.items()}, marks={}) for c in machine.cargo)
    ties = tuple(replace(t, lug=WORDS[t.lug] if t.lug and WORDS[t.lug][0] in hooked else "") for t in machine.ties)
    on = {tie.rope for tie in ties if tie.lug}
    system = dataclasses.replace(
        machine.system,
        ropes=tuple(dataclasses.replace(r, hooked=r.winch or r.name in on) for r in machine.system.ropes),
        brakes=tuple(dataclasses.replace(brake, engaged=not on) for brake in machine.system.brakes),
    )
    cells = tuple(replace(cell, rated=2.6e6) if machine.ties else cell for cell in machine.cells)
    return replace(machine, cargo=cargo, ties=ties, cells=cells, system=system)


class KernelDouble(Atomic):
    """Logs (seconds, node, input); says the (seconds, event) of the script."""

    def __init__(self, plan: Plan, script: Sequence[tuple[float, StateEvent]]) -> None:
        super().__init__("kernel")
        self.script = sorted(((seconds(t), event) for t, event in script), key=lambda line: line[0])
        self.hears = subscriptions(plan)
        self.got: list[tuple[float, str, KernelInput]] = []
        for source, out, target, port in couplings(plan):
            if target == "kernel":
                self.add_in(port, KernelInput)
            if source == "kernel":
                self.add_out(out, StateEvent)

    def start(self) -> None:
        self.got, self.left = [], list(self.script)
        self.wait()

    def external(self, e: int, x: Bag) -> None:
        for port in x:
            self.got += [(self.now.t / 1e9, port.name.removeprefix("input_"), m) for m in x[port]]

    def output(self) -> None:
        for t, event in self.left:
            if t == self.now.t:
                for node in self.hears[event.name]:
                    self.ports[f"state_{node}"].send(event)  # type: ignore[attr-defined]

    def internal(self) -> None:
        self.left = [line for line in self.left if line[0] > self.now.t]
        self.wait()

    def wait(self) -> None:
        if self.left:
            self.hold_in(self.left[0][0] - self.now.t)
        else:
            self.passivate()


class Yard:
    """All models of a plan around the double of the kernel, in one simulator."""

    def __init__(self, plan: Plan, *script: tuple[float, StateEvent]) -> None:
        self.models = build(plan)
        root = Coupled("yard")
        for model in self.models.values():
            root.add(model)
        self.kernel = root.add(KernelDouble(plan, script))
        for source, out, target, into in couplings(plan):
            root.connect(root.children[source].ports[out], root.children[target].ports[into])
        self.log: list[Transition] = []
        self.simulator = Simulator(root, log=self.log.append)
        self.simulator.start()

    def run(self, t: float = 1e6) -> Yard:
        self.simulator.run(seconds(t))
        return self

    def inputs(self, kind: type[M]) -> list[tuple[float, M]]:
        """What the kernel got of one kind, with seconds."""
        return [(t, m) for t, _, m in self.kernel.got if isinstance(m, kind)]

    def said(self, path: str, kind: type[M]) -> list[tuple[float, M]]:
        """What one atomic said of one kind, with seconds."""
        mine = [x for x in self.log if x.path == f"yard.{path}"]
        return [(x.tag.t / 1e9, m) for x in mine for _, m in x.sent if isinstance(m, kind)]

    def got(self, path: str, kind: type[M]) -> list[M]:
        """What one atomic received of one kind."""
        mine = [x for x in self.log if x.path == f"yard.{path}"]
        return [m for x in mine for _, m in x.bag if isinstance(m, kind)]

    def waiting_for(self) -> str:
        """The commander's sentence."""
        commander = self.models["commander"]
        assert isinstance(commander, CommanderModel)
        return commander.waiting_for()


class Bench:
    """One model alone: `put` messages in at seconds; `said`: all it answers, as (seconds, port, message)."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.inputs: list[tuple[int, str, Message]] = []

    def put(self, t: float, port: str, *messages: Message) -> Bench:
        """Messages that arrive in one bag."""
        self.inputs += [(seconds(t), port, message) for message in messages]
        return self

    def said(self) -> list[tuple[float, str, Message]]:
        """Run it to the end."""
        return [(tag.t / 1e9, port, message) for tag, port, message in drive(self.model, self.inputs)]
