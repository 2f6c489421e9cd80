"""The yard of the tests: the turnover plan by its binding geometry, and a double of the kernel.

The double takes kernel inputs down in a log and says the state events of a script, to the nodes that
subscribe.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import radians
from typing import Literal, TypeVar

from heavylift.kernel.description import Line, Point, Support
from heavylift.nodes import drive
from heavylift.nodes.devs import Atomic, Bag, Coupled, Message, Model, Simulator, Transition, seconds
from heavylift.nodes.models import CommanderModel, build, couplings, subscriptions
from heavylift.nodes.models.parts import KernelInput, StateEvent
from heavylift.nodes.plan import (
    Action,
    Axis,
    Block,
    Crane,
    Hook,
    HookRope,
    Inertia,
    Loader,
    Lug,
    Pad,
    Plan,
    Rig,
    Sling,
    Trolley,
)

M = TypeVar("M", bound=Message)
LUGS = {
    "A": (-14.6, 0.0, (10.0, 14.0, 22.0, 26.0)),
    "B": (12.0, 5.6, (16.0, 20.0)),
    "B'": (12.0, -5.6, (16.0, 20.0)),
}
HOOKS = ("H1", "H2", "H3")


def crane(name: str, x: float) -> Crane:
    def trolley(which: Literal["upper", "lower"], y: float, capacity: float) -> Trolley:
        axis = Axis(start=y, lower=8.0, upper=142.0, accel=0.05, kp=5e6, kv=5e6)
        body = Inertia(mass=200e3, com=(0.0, 0.0, 100.0), moments=(1e6, 1e6, 1e6))
        return Trolley(name=which, body=body, axis=axis, capacity=capacity)

    hooks = tuple(
        Hook(
            name=hook,
            rope=f"{name}.{hook}",
            trolley="lower" if hook == "H3" else "upper",
            accel=0.05,
            shortest=10.0,
            drum=100.0,
            highest=80.0,
            capacity=450e3,
            block_mass=25e3,
        )
        for hook in HOOKS
    )
    return Crane(
        name=name,
        main=Inertia(mass=4000e3, com=(0.0, 75.0, 80.0), moments=(1e10, 1e10, 1e10)),
        gantry=Axis(start=x, lower=0.0, upper=200.0, accel=0.05, kp=2e7, kv=2e7),
        upper=trolley("upper", 75.0 - 14.6, 900e3),
        lower=trolley("lower", 75.0 + 12.0, 450e3),
        hooks=hooks,
        capacity=675e3,
    )


def loader(name: str, x: float, y: float, z: float) -> Loader:
    return Loader(
        name=name,
        pose=(x, y, z, 0.0, 0.0, 0.0, 1.0),
        upper=Inertia(mass=35e3, moments=(4e4, 4e4, 4e4)),
        lower=Inertia(mass=10e3, com=(0.0, 0.0, -0.8), moments=(1e3, 1.4e4, 1.4e4)),
        hinge=(0.0, 0.0, -2.0),
        damping=1e4,
        stop_lower=-radians(30),
        stop_upper=radians(30),
        stop_k=1e7,
        stop_d=1e5,
        lock_moment=1e6,
        lock_k=1e7,
        lock_d=1e5,
        capacity_N=2.6e6,
    )


def turnover(*actions: Action, hooked: str = "AB", end: float | None = None) -> Plan:
    """The plan of the scene `turnover` at the start of the lift, with any action list."""
    cranes = (crane("west", 40.0), crane("east", 76.0))
    loaders, ropes, slings = [], [], []
    for c, (machine, outer) in enumerate(zip(cranes, (-1.0, 1.0), strict=True)):
        for h, hook in enumerate(HOOKS):
            name, group = f"loader-{3 * c + h + 1}", "B" if hook == "H3" else "A"
            v, _, us = LUGS[group]
            pair = (16.0, 20.0) if group == "B" else (us[:2] if (h == 0) == (outer > 0) else us[2:])
            x, length = 58.0 + outer * sum(pair) / 2, 84.0 if group == "A" else 42.4
            z = (102.0 if group == "A" else 88.0) - length
            loaders.append(loader(name, x, 75.0 + v, z))
            trolley = f"{machine.name}.{'lower' if group == 'B' else 'upper'}"
            dx = x - (40.0 if c == 0 else 76.0)
            lines = tuple(
                Line(Point(trolley, (dx + b, 0.0, z + length)), Point(f"{name}.upper", (b, 0.0, 0.0)), 0.5)
                for b in (-1.0, 1.0)
            )
            ropes.append(
                HookRope(
                    name=f"{machine.name}.{hook}",
                    crane=machine.name,
                    hook=hook,
                    carries=name,
                    eye=Point(f"{name}.upper"),
                    lines=lines,
                    L0=length,
                    EA=1.87e9,
                    damping=1e6,
                )
            )
            for i, u in enumerate(pair, 1):
                lug = f"{group}{int(outer * u):+d}" if group in hooked else ""
                beam = Point(f"{name}.lower", (outer * u - sum(pair) / 2 * outer, 0.0, -1.0))
                slings.append(
                    Sling(
                        name=f"{name}.sling-{i}",
                        loader=name,
                        beam=beam,
                        lug=lug,
                        L0=8.0 if group == "A" else 30.0,
                        EA=4.45e8,
                        damping=1e5,
                    )
                )
    lugs = tuple(
        Lug(name=f"{group}{sign * int(u):+d}", p=(sign * u, v, w))
        for group, (v, w, us) in LUGS.items()
        for sign in (-1, 1)
        for u in us
    )
    pads = tuple(
        Pad(
            support=Support(f"block.{face}-{i}", Point("block", (u, v, w)), 2.0, 4.4e8, 1e6),
            face=face,
            closed=face == "lower",
        )
        for face, w in (("lower", -5.0), ("upper", 5.0))
        for i, (u, v) in enumerate(((-24.0, -8.0), (-24.0, 8.0), (24.0, -8.0), (24.0, 8.0)), 1)
    )
    block = Block(
        body=Inertia(mass=900e3, moments=(6.63e7, 22.6e7, 27.75e7)),
        pose=(58.0, 75.0, 7.0, 0.0, 0.0, 0.0, 1.0),
        lugs=lugs,
        pads=pads,
    )
    rig = Rig(hook_ropes=tuple(ropes), slings=tuple(slings))
    return Plan(name="turnover", cranes=cranes, loaders=tuple(loaders), block=block, rig=rig, actions=actions, end=end)


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
