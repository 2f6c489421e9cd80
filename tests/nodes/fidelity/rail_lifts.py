"""Data of a lift for the independent reference: cranes on rails, rigging on their hooks, the block."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from heavylift.kernel.description import Body, Drive, Line, Point, Reeving, Support, Vector
from heavylift.nodes.plan import Bend, Mechanism, Plan


@dataclass(frozen=True)
class Axis:
    start: float
    kp: float
    kv: float


@dataclass(frozen=True)
class Trolley:
    name: str
    body: Body
    axis: Axis


@dataclass(frozen=True)
class Held:
    rope: str
    trolley: str


@dataclass(frozen=True)
class Crane:
    name: str
    main: Body
    gantry: Axis
    upper: Trolley
    lower: Trolley
    hooks: tuple[Held, ...]
    girder: Bend


@dataclass(frozen=True)
class Loader:
    name: str
    pose: tuple[float, ...]
    upper: Body
    lower: Body
    hinge: Vector
    damping: float


@dataclass(frozen=True)
class HookRope:
    name: str
    crane: str
    carries: str
    lines: tuple[Line, ...]
    L0: float
    EA: float
    damping: float
    line: float


@dataclass(frozen=True)
class Sling:
    name: str
    loader: str
    beam: Point
    lug: str
    L0: float
    EA: float
    damping: float


@dataclass(frozen=True)
class Lug:
    name: str
    p: Vector


@dataclass(frozen=True)
class Pad:
    support: Support
    closed: bool


@dataclass(frozen=True)
class Block:
    name: str
    body: Body
    pose: tuple[float, ...]
    lugs: tuple[Lug, ...]
    pads: tuple[Pad, ...]


@dataclass(frozen=True)
class Rig:
    hook_ropes: tuple[HookRope, ...]
    slings: tuple[Sling, ...]


@dataclass(frozen=True)
class Lift:
    cranes: tuple[Crane, ...]
    loaders: tuple[Loader, ...]
    rig: Rig
    block: Any  # Block | None


_last: list[tuple[Plan, Lift]] = []  # of the plan that was asked for last, which is asked for again and again


def lift_of(plan: Plan) -> Lift:
    """The lift of a plan."""
    if not _last or _last[0][0] is not plan:
        _last[:] = [(plan, _read(plan))]
    return _last[0][1]


def _read(plan: Plan) -> Lift:
    parts = [m for m in plan.machines if m.girders or m.latches or m.cargo]
    cranes, loaders = [m for m in parts if m.girders], [m for m in parts if m.latches]
    eyes = {f"{m.name}.upper" for m in loaders}
    known = all(m.system.joints[0].name == f"{m.name}.gantry" for m in cranes)
    if not known or any(h.eye.body not in eyes for m in cranes for h in m.hooks):
        return Lift((), (), Rig((), ()), None)  # no rule is about such hooks
    blocks = [_block(m) for m in parts if m.cargo]
    slings = tuple(sling for m in loaders for sling in _slings(m))
    ropes = tuple(rope for m in cranes for rope in _ropes(m))
    order = {m.name: i for i, m in enumerate(loaders)}
    return Lift(
        cranes=tuple(_crane(m) for m in cranes),
        loaders=tuple(_loader(m) for m in loaders),
        rig=Rig(tuple(sorted(ropes, key=lambda rope: order[rope.carries])), slings),
        block=blocks[0] if len(blocks) == 1 and not plan.lists else None,
    )


def _crane(m: Mechanism) -> Crane:
    starts = {a.name: a.start for a in m.actuators}

    def axis(drive: Drive) -> Axis:
        return Axis(starts[drive.name], drive.kp, drive.kv)

    lower, main, upper = m.system.bodies  # in the order of their names, as drives are
    gantry, *slides = map(axis, m.system.drives)
    hooks = tuple(Held(h.rope, h.on.rpartition(".")[2]) for h in sorted(m.hooks, key=lambda h: h.rope))
    trolleys = Trolley("upper", upper, slides[1]), Trolley("lower", lower, slides[0])
    return Crane(m.name, main, gantry, *trolleys, hooks, m.girders[0])


def _ropes(m: Mechanism) -> list[HookRope]:
    known = {rope.name: rope for rope in m.system.ropes}
    return [
        HookRope(
            h.rope, m.name, h.eye.body.rpartition(".")[0], known[h.rope].lines, known[h.rope].L0, known[h.rope].EA,
            known[h.rope].damping, h.line,
        )
        for h in m.hooks
    ]  # fmt: skip


def _loader(m: Mechanism) -> Loader:
    (upper, lower), (free, hinge) = m.system.bodies, m.system.joints
    return Loader(m.name, free.q0, upper, lower, hinge.p_PJ, m.system.springs[0].d)


def _slings(m: Mechanism) -> list[Sling]:
    straight = {rope.name: (rope.L0, rope.EA, rope.damping) for rope in m.system.ropes}
    bent = {f.name: (f.signal.value, f.EA, f.damping) for f in m.system.forces if isinstance(f, Reeving)}
    return [Sling(t.rope, m.name, t.upper, t.lug, *(straight | bent)[t.rope]) for t in m.ties]


def _block(m: Mechanism) -> Block:
    (body,), (joint,), (cargo,) = m.system.bodies, m.system.joints, m.cargo
    whole = Body(body.name, cargo.mass, cargo.com, body.inertia)
    pads = tuple(Pad(s, s.name in m.closed) for s in m.system.supports)
    lugs = tuple(Lug(name, p) for name, p in cargo.lugs.items())
    return Block(m.name, whole, joint.q0, lugs, pads)
