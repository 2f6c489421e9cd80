"""Constraint rows, guards and friction heat of contacts in one evaluation of the equations.

A slot holds one place where two bodies touch. Closed: its normal row prevents penetration; sticking: its tangents are
constrained as well; sliding: friction is part of the wrench that the normal row exerts, which then differs from what
the row senses. These states are parameters of the run, frozen during a step. Guards: a candidate touches (gap and its
rate below zero), the normal force vanishes, friction reaches its limit, sliding ends, or the place leaves its face.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
from heavylift.kernel.compiler.function import Function, Outputs
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, maximum, minimum, select, sqrt
from heavylift.kernel.constraints.row_structure import ConstraintRow, Numbers
from heavylift.kernel.description.contacts import Contact
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.forces.force_law import BODY
from heavylift.kernel.forces.joint_laws import SLIP_BLEND
from heavylift.kernel.multibody.graph import Graph

from . import frames
from .candidates import passes, reach
from .pairs import HELD, ContactPair, pair_of, shape_numbers

SLOT = HELD + 12
DEPTH = 1e-10  # [m] and [m/s] below which a touch is round-off
SUNK = 1e-8  # [m] where a touch without speed counts
RESTING = 1e-6  # [m/s] speed that counts as none at an event: what a nanosecond may change
FOREVER = 1e15  # [s] a step that nothing bounds
LEAVE = 1e-9  # [m] beyond the edge of a face where a place is left


class SlotAt:
    """Indices into the parameters of a contact slot (one touching point), which begin with the contact frame.

    CANDIDATE: index of the touching point, -1 in a free slot. BACK: backward speed along the slip direction U [m/s] at
    which a slip ends; larger for a slip that has just begun, which must not end at once. SLIPS: whether the contact
    slides; at its friction limit, a contact may still be held in place by other contacts.
    """

    ON, STICK = range(HELD, HELD + 2)
    SOFT, U = slice(HELD + 2, HELD + 4), slice(HELD + 4, HELD + 6)
    CANDIDATE, BACK, SLIPS = range(HELD + 6, HELD + 9)
    PRIOR = slice(HELD + 9, HELD + 12)


@dataclass(frozen=True)
class Site:
    """A contact between two shapes in a compiled scene, with its bodies and traced functions."""

    contact: Contact
    pair: ContactPair
    first: int  # count of the first shape's numbers
    bodies: tuple[int, int]
    per_slot: int  # rows per touching point
    watch: Function
    slot: Function
    reach: Function | None  # limits a step if the shapes could pass through each other

    @property
    def slots(self) -> list[str]:
        """Return the names of the contact's slots, one for each point that can touch at the same time."""
        return [f"{self.contact.name}/{k}" for k in range(self.pair.slots)]


def contact_numbers(c: Contact, weight: float) -> dict[tuple[str, str], list[float]]:
    """Return the parameters of a contact: friction, load [N] below which it counts as unloaded, shapes, points."""
    pair = pair_of(c)
    empty = [*[0.0] * HELD, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, -1.0, DEPTH, 0.0, 0.0, 0.0, 0.0]
    out = {
        # relative to the weight of the scene: below it a normal force is round-off
        ("contact", c.name): [c.mu, 1e-9 * max(1.0, weight)],
        ("shapes", c.name): [*shape_numbers(c.a), *shape_numbers(c.b)],
        ("held", c.name): [0.0] * pair.candidates,
    }
    return out | {("slot", f"{c.name}/{k}"): list(empty) for k in range(pair.slots)}


class ContactPointRows:
    """The contacts of a system in one evaluation of the equations: constraint rows, guards, heat."""

    def __init__(self, system: System, graph: Graph) -> None:
        kinds: dict[str, tuple[Function, Function, Function | None]] = {}
        self.sites = [_site(c, graph, kinds) for c in system.contacts]
        self.bodies = [b for s in self.sites for b in s.bodies]
        self.held = [s.bodies for s in self.sites for _ in range(s.pair.slots * s.per_slot)]
        self.names = [s.contact.name for s in self.sites for _ in range(s.pair.slots * s.per_slot)]
        self.guards = [("touch", s.contact.name) for s in self.sites for _ in range(s.pair.candidates)]
        what = ("press", "grip", "leave")
        self.guards += [(kind, s.contact.name) for s in self.sites for _ in range(s.pair.slots) for kind in what]
        self.structure = [(s.slot.name, s.bodies, s.per_slot) for s in self.sites]

    def slots(self, numbers: Numbers, ends: Mapping[int, Array]) -> list[SimpleNamespace]:
        """Return the state of all contact slots (places for touching points) in their order."""
        out = []
        for s in self.sites:
            a, b = (ends[i] for i in s.bodies)
            mu, grain = numbers("contact", s.contact.name)
            for k in range(s.pair.slots):
                x = s.slot(h=numbers("slot", f"{s.contact.name}/{k}"), mu=[mu], A=a, B=b)
                x.site, x.mu, x.grain = s, mu, grain
                out.append(x)
        return out

    def rows(self, slots: list[SimpleNamespace]) -> list[ConstraintRow]:
        """Return the constraint rows of each contact slot: normal and, with friction, two tangents."""
        out = []
        for x in slots:
            a, b = x.site.bodies
            for i in range(x.site.per_slot):
                six = slice(6 * i, 6 * i + 6)
                # the normal of a sliding contact pushes along another direction than it senses
                push = [(a, x.pa), (b, -x.pb)] if i == 0 and x.site.per_slot > 1 else None
                sense, soft = [(a, x.wa[six]), (b, -x.wb[six])], x.soft[i - 1] if i else 1.0
                out.append(ConstraintRow(sense, x.gap[i], x.rate[i], x.bias[i], push=push, soft=soft, prior=x.prior[i]))
        return out

    def watched(self, numbers: Numbers, ends: Mapping[int, Array]) -> list[Scalar]:
        """Return the guards of all possible touching points: negative once the shapes touch there, 1 during contact."""
        out: list[Scalar] = []
        for s in self.sites:
            a, b = (ends[i] for i in s.bodies)
            p, held = numbers("shapes", s.contact.name), numbers("held", s.contact.name)
            out += list(s.watch(p=p, held=held, A=a, B=b).guard)
        return out

    @property
    def bounded(self) -> bool:
        """Whether steps must be limited because shapes in contact could pass through each other."""
        return any(s.reach for s in self.sites)

    def reach(self, numbers: Numbers, ends: Mapping[int, Array]) -> Scalar:
        """Return the longest step in which no shapes can pass through each other [s]."""
        longest: Scalar = FOREVER
        for s in self.sites:
            if s.reach:
                a, b = (ends[i] for i in s.bodies)
                longest = minimum(longest, s.reach(p=numbers("shapes", s.contact.name), A=a, B=b).reach[0])
        return longest

    def loads(self, slots: list[SimpleNamespace], multipliers: Any) -> tuple[list[Scalar], list[Scalar], list[Scalar]]:
        """Return the guards of the contact slots, heat per contact [W] and normal force per contact [N]."""
        own: dict[str, list[Scalar]] = {s.contact.name: [] for s in self.sites}
        heat: dict[str, Scalar] = dict.fromkeys(own, 0.0)
        force: dict[str, Scalar] = dict(heat)
        at = 0
        for x in slots:
            name, n = x.site.contact.name, multipliers[at]
            on, stick = x.on[0] > 0.0, x.stick[0] > 0.0
            grip: Scalar = 1.0
            if x.site.per_slot > 1:
                t = multipliers[at + 1 : at + 3]
                # distance to the limit; 1e-300 keeps the root differentiable without friction
                room = x.mu * n - sqrt(t @ t + 1e-300) + x.grain
                grip = select(on, select(stick, room, x.onward[0] + x.back[0]), 1.0)
                heat[name] = heat[name] + select(on, select(stick, 0.0, x.mu * n * x.sliding[0]), 0.0)
            own[name] += [select(on, n + x.grain, 1.0), grip, select(on, x.leave[0], 1.0)]
            force[name] = force[name] + select(on, n, 0.0)
            at += x.site.per_slot
        return [g for guards in own.values() for g in guards], list(heat.values()), list(force.values())


def _site(c: Contact, graph: Graph, kinds: dict[str, tuple[Function, Function, Function | None]]) -> Site:
    """Create the functions of a contact; `kinds`: functions by pair of shapes, shared by contacts of the same pair."""
    pair, bodies = pair_of(c), (graph.number(c.a.body), graph.number(c.b.body))
    kind = f"{type(c.a).__name__}_{type(c.b).__name__}".lower()
    n = len(shape_numbers(c.a))
    if kind not in kinds:
        kinds[kind] = _functions(c, pair, kind, n)
    return Site(c, pair, n, bodies, 3 if c.mu > 0.0 else 1, *kinds[kind])


def _functions(c: Contact, pair: ContactPair, kind: str, n: int) -> tuple[Function, Function, Function | None]:
    """Create the functions of the candidates' guards, a slot, and a step's bound; n: values of the first shape."""

    def watch(p: Array, held: Array, A: Array, B: Array) -> Outputs:
        witnesses = pair.watch(p[:n], p[n:], A, B)
        return {"guard": [select(h > 0.0, 1.0, _touch(*w)) for h, w in zip(held, witnesses, strict=True)]}

    def slot(h: Array, mu: Array, A: Array, B: Array) -> Outputs:
        return _slot(pair, h, mu[0], A, B)

    def longest(p: Array, A: Array, B: Array) -> Outputs:
        return {"reach": [reach(c, p[:n], p[n:], A, B)]}

    size = n + len(shape_numbers(c.b))
    sizes = {"p": size, "held": pair.candidates, "A": BODY, "B": BODY}
    slots = Function(f"slot_{kind}", slot, {"h": SLOT, "mu": 1, "A": BODY, "B": BODY})
    bound = Function(f"reach_{kind}", longest, {"p": size, "A": BODY, "B": BODY}) if passes(c) else None
    return Function(f"watch_{kind}", watch, sizes), slots, bound


def _touch(gap: Scalar, rate: Scalar) -> Any:
    """Return the guard of a candidate: negative at once if the shapes touch and approach, later if they penetrate."""
    # two cases: gap and approach, or a deeper gap at rest; a place just left must not fire again by round-off
    return minimum(maximum(gap + DEPTH, rate + RESTING), maximum(gap + SUNK, rate + DEPTH))


def _slot(pair: ContactPair, h: Array, mu: Scalar, A: Array, B: Array) -> Outputs:
    """Return the rows that a slot senses (wa, wb) and the wrench that its normal row exerts (pa, pb); zero if open.
    `sliding`: speed against friction; `onward`: speed along the direction in which sliding began."""
    f = pair.frame(h[:HELD], A, B)
    r = frames.rows(f, A, B)
    on, stick = h[SlotAt.ON] > 0.0, h[SlotAt.STICK] > 0.0
    v, u0 = r["rate"][1:], h[SlotAt.U]
    # friction does not turn round within a step that passes the stop: what slides back is seen in a mirror
    # below SLIP_BLEND the initial direction decides, so that friction does not flip with the sign of round-off
    u = v + (SLIP_BLEND - 2.0 * minimum(u0 @ v, 0.0)) * u0
    u = u * (1.0 / sqrt(u @ u + 1e-300))
    friction = select(stick, 0.0, mu)
    held = select(on, select(stick, 1.0, 0.0), 0.0)
    part = np.array([select(on, 1.0, 0.0), held, held])
    out: dict[str, Scalars] = {"gap": [select(on, f.gap, 0.0), 0.0, 0.0]}
    out |= {name: part * r[name] for name in ("rate", "bias")}
    out |= {name: part[:, None] * r[name] for name in ("wa", "wb")}
    for name in ("a", "b"):
        w = r[f"w{name}"]
        # x_t = -mu x_n u is folded into the wrench of the normal row
        out[f"p{name}"] = part[0] * (w[0] - friction * (u[0] * w[1] + u[1] * w[2]))
    # distance to the border of the face or the end of the edge
    room = h[HELD - 2 : HELD] - abs(f.along)
    return out | {
        "on": [h[SlotAt.ON]],
        "stick": [h[SlotAt.STICK]],
        "soft": list(h[SlotAt.SOFT]),
        "prior": list(h[SlotAt.PRIOR]),
        "sliding": [u @ v],
        "onward": [u0 @ v],
        "back": [h[SlotAt.BACK]],
        "leave": [minimum(room[0], room[1]) + LEAVE],
    }
