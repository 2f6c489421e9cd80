"""A massless elastic rope over sheaves with friction, stick and slip at each of them.

Each part j between two nodes has its own unstretched length N_j and strain s_j = l_j/N_j - 1.  At a sheave that sticks
no rope passes; at one that slips the strains keep the ratio rho = exp(mu wrap)/efficiency against the motion
(Euler-Eytelwein).  Parts joined by slipping sheaves form a group: s_j = r_j s, with s from sum l_j/(1 + r_j s) =
unstretched length of the group (Newton's method, exact to round-off).  T_j = EA s_j + c sum N_j s_j' / sum N_j over its
group, which for a rope without friction is `Rope`'s EA e/L0 + damping e' with c = damping L0.
Discrete states, frozen in a step: a sheave slips when the ratio passes rho (1 + BITE) and sticks when the flow of rope
over it falls through zero; a part whose damping would make it push is limp; slack rope slides freely, its parts are one
group of equal strain.  A sheave with a radius is left when its wrap falls to zero, and found when the straight part
comes back to it (`sheaves`); left, it joins its parts without friction.  Heat of a sheave is (T_out - T_in) times the
flow, with the strain energy that is carried over.
"""

from __future__ import annotations

from collections.abc import Hashable
from itertools import pairwise
from math import pi

import numpy as np
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, maximum, minimum, select
from heavylift.kernel.description.forces import Reeving, Sheave, Signal

from .force_law import Answer, Ended, ForceLaw, Poses, Shown, attachment, wrench
from .rope_groups import FREE, Groups, slip_ratio
from .sheaves import Node, Part, Way

__all__ = ["ReevingLaw"]

MOST_WRAP = 1.5 * pi  # a larger one means that the axis points the wrong way
BESIDE = pi / 4.0  # a negative wrap of a sheave that the rope does not touch yet; more means the same as MOST_WRAP
TAUT = 2  # place of the state in P, behind EA and c
NODE = 12  # numbers of a node: centre, axis, dividing direction, radius, friction, 1/efficiency
PARALLEL = 0.99  # cosine between the axes of neighbouring sheaves
ALONG = 0.9  # sine of a fleet angle at which a rope no longer lies in its sheave
MEETS = 1e-2  # part of a radius or length, near which a rope loses its direction in steps that become too small
UNIT = 1e-6  # how far an axis may be off by rounding

UNSTRAINED = 1e-7  # strain of a part that has just come taut


class ReevingLaw(ForceLaw[Reeving]):
    """P: EA, c, taut; per sheave its mode (-1, 0, +1: flow against, none, along the rope; FREE); per part but the first
    its N; per part whether it is limp; per sheave whether the rope lies on it; the nodes."""

    works = True
    positive = ("EA",)
    not_negative = ("damping",)

    def check(self, f: Reeving) -> None:
        self.demand(f, "length", f.signal.value > 0.0, f"is {f.signal.value:g}; it must be positive")
        self.demand(f, "sheaves", bool(f.sheaves), "are missing; a rope without any is a Rope")
        for i, s in enumerate(f.sheaves, 1):
            self.demand(f, f"sheave {i}", min(s.radius, s.friction) >= 0.0, "has a negative radius or friction")
            self.demand(f, f"sheave {i}", 0.0 < s.efficiency <= 1.0, "has an efficiency outside (0, 1]")
            size = float(np.linalg.norm(s.axis))
            self.demand(f, f"sheave {i}", abs(size - 1.0) < UNIT, f"has an axis of length {size:g}; it must be 1")

    def signal(self, f: Reeving) -> Signal:
        return f.signal

    def shape(self, f: Reeving) -> Hashable:
        return tuple((s.radius > 0.0, s.friction > 0.0, s.efficiency < 1.0) for s in f.sheaves)

    def numbers(self, f: Reeving, poses: Poses) -> list[float]:
        n = len(f.sheaves)
        given, lies = self._placed(f, poses)
        lengths = [0.0] * n  # of a rope that sticks; set when it comes taut
        limp = [0.0] * (n + 1)
        on = [float(x is not False) for x in lies[1:-1]]
        head = [f.EA, f.damping * f.signal.value, 0.0]
        return [*head, *[FREE] * n, *lengths, *limp, *on, *(x for q in given for x in q)]

    def start_length(self, f: Reeving, poses: Poses) -> float:
        """Its length in the initial pose [m]; raises KernelError where it cannot run so."""
        (given, lies), bodies = self._placed(f, poses), [_body(*poses(p.body)) for p in f.points]
        nodes = [_node(x, np.array(q), body) for x, q, body in zip(_all(f), given, bodies, strict=True)]
        return float(sum(Way(nodes, _turning(f), lies).lengths))

    def off_its_sheaves(self, f: Reeving, poses: Poses, shown: np.ndarray) -> str:
        """Where a rope that ran well has come to have no direction, in words; "" if it runs."""
        bodies = [_body(*poses(p.body)) for p in f.points]
        given = [np.array(_node_numbers(x)) for x in _all(f)]
        nodes = [_node(x, q, body) for x, q, body in zip(_all(f), given, bodies, strict=True)]
        left = {i + 1 for i, wrap in zip(_round(f), shown[3 * len(f.points) - 3 :], strict=True) if wrap == 0.0}
        met = [i for i in range(len(nodes)) if i not in left]
        for i, j in pairwise(met):
            a, b = nodes[i], nodes[j]
            axis, D = b.axis if a.axis is None else a.axis, b.c - a.c
            if axis is None:
                continue
            across = float(np.linalg.norm(D - (D @ axis) * axis))
            if across < (1.0 + MEETS) * abs(float((a.radius or 0.0) - (b.radius or 0.0))):
                return f"part {j} comes within its sheave; keep its ends apart"
            if across < MEETS * float(np.linalg.norm(D)):
                return f"part {j} runs along the axis of its sheave; turn the axis across the rope"
        return ""

    def _placed(self, f: Reeving, poses: Poses) -> tuple[list[list[float]], list[bool | None]]:
        """The numbers of the nodes, arcs divided in the middle, and whether the rope lies on each (None: it stays)."""
        given = [_node_numbers(x) for x in _all(f)]
        bodies = [_body(*poses(p.body)) for p in f.points]
        nodes = [_node(x, np.array(q), body) for x, q, body in zip(_all(f), given, bodies, strict=True)]
        self._check_places(f, nodes)
        lies: list[bool | None] = [None, *(True if s.radius > 0.0 else None for s in f.sheaves), None]
        turning = _turning(f)
        while True:
            made = Way(nodes, turning, lies).parts
            arcs = {i: _divide(nodes[i], made[i - 1], made[i]) for i, turns in enumerate(turning) if turns}
            beside = {2.0 * pi - wrap: i for i, (_, wrap) in arcs.items() if lies[i] and wrap > 2.0 * pi - BESIDE}
            if not beside:
                break
            lies[beside[max(beside)]] = False  # the farthest one first
        for i, (here, wrap) in arcs.items():
            message = f"is wrapped by {np.degrees(wrap):.0f} degrees; turn its axis round"
            self.demand(f, f"sheave {i}", wrap <= MOST_WRAP or lies[i] is False, message)
            given[i][6:9] = (bodies[i][:9].reshape(3, 3).T @ here).tolist()
        return given, lies

    def _check_places(self, f: Reeving, nodes: list[Node]) -> None:
        for i, (a, b) in enumerate(pairwise(nodes), 1):
            bias = float((a.radius or 0.0) - (b.radius or 0.0))
            D = b.c - a.c
            self.demand(f, f"part {i}", float(D @ D) > bias * bias, "has no length; keep its ends apart")
            for x in (a, b):
                if x.axis is not None:
                    message = "runs along the axis of its sheave; turn the axis across the rope"
                    self.demand(f, f"part {i}", abs(float(D @ x.axis)) < ALONG * float(np.linalg.norm(D)), message)
            if a.radius is not None and b.radius is not None:
                self.demand(
                    f, f"part {i}", abs(float(a.axis @ b.axis)) > PARALLEL, "joins sheaves whose axes are not parallel"
                )

    def answer(
        self,
        f: Reeving,
        p: Array,
        ends: list[Array],
        signal: Scalars,
        joint: Scalars,
        t: Scalar,
        counted: Array | None = None,
    ) -> Answer:
        n = len(f.sheaves)
        EA, c, on = p[0], p[1], p[TAUT] > 0.0
        modes, own, limp, lies = p[3 : 3 + n], p[3 + n : 3 + 2 * n], p[3 + 2 * n : 4 + 3 * n], p[4 + 3 * n : 4 + 4 * n]
        first = 4 + 4 * n
        kept = [signal[0] - sum(own, 0.0), *own]
        given = [p[first + NODE * i : first + NODE * (i + 1)] for i in range(n + 2)]
        placed = zip(_all(f), given, ends, strict=True)
        nodes = [_node(x, q, body, f"a{i}") for i, (x, q, body) in enumerate(placed, 1)]
        leaves = [s.radius > 0.0 for s in f.sheaves]
        there = [lies[i] > 0.0 if x else None for i, x in enumerate(leaves)]
        way = Way(nodes, _turning(f), [None, *there, None], counted)
        made = way.parts
        ratios = [slip_ratio(s, given[i], way.wraps.get(i)) for i, s in enumerate(f.sheaves, 1)]
        rope = Groups(way, kept, signal[1], _rubs(f), modes, ratios)
        s, ds, N = rope.strains, rope.rates, rope.unstretched
        trial = [EA * x + c * rate for x, rate in zip(s, rope.mean_rates(), strict=True)]
        pulls = [select(on, select(x > 0.0, 0.0, 1.0), 0.0) > 0.0 for x in limp]
        T = [select(pull, maximum(k, 0.0), 0.0) for pull, k in zip(pulls, trial, strict=True)]
        wrenches = [wrench(part.arms[0], k * part.u) for part, k in zip(made, T, strict=True)]
        back = [-wrench(part.arms[1], k * part.u) for part, k in zip(made, T, strict=True)]
        inner = [a + b for a, b in zip(wrenches[1:], back[:-1], strict=True)]
        inner = [x if on_ is None else _only(on_, x) for x, on_ in zip(inner, there, strict=True)]
        carried = [k * (1.0 + x) - 0.5 * EA * x * x for k, x in zip(T, s, strict=True)]
        rubbed = [flow * (b - a) for flow, (a, b) in zip(rope.flows, pairwise(carried), strict=True)]
        damped = [(k - EA * x) * m * dx for k, x, m, dx in zip(T, s, N, ds, strict=True)]
        least = s[0]
        for x in s[1:]:
            least = minimum(least, x)
        excess = sum(way.lengths) - signal[0]
        rubbing = [there[i] for i, rubs in enumerate(_rubs(f)) if rubs]
        held = [select(on, g, 1.0) for g in rope.grips()]
        grips = [g if on_ is None else select(on_, g, 1.0) for g, on_ in zip(held, rubbing, strict=True)]
        eased = [select(on, select(x > 0.0, -k, k), 1.0) for x, k in zip(limp, trial, strict=True)]
        return Answer(
            [wrenches[0], *inner, back[-1]],
            heat=select(on, sum(rubbed) + sum(damped), 0.0),
            work=select(on, -carried[0] * signal[1], 0.0),
            stored=select(on, sum(0.5 * EA * x * x * m for x, m in zip(s, N, strict=True)), 0.0),
            guards=[select(on, least, -excess), *grips, *eased, *(g for pair in way.watches() for g in pair)],
            shown=[
                *T,
                *way.lengths,
                *N,
                *(select(there[i], way.wraps[i + 1][0], 0.0) for i, x in enumerate(leaves) if x),
            ],
            turned=way.turned,
            turning=way.turning,
        )

    def angles(self, f: Reeving) -> int:
        return 2 * sum(_turning(f))

    def turns(self, f: Reeving, poses: Poses) -> None:
        return None  # arcs are divided where the rope lies at the start

    def guards(self, f: Reeving) -> tuple[str, ...]:
        grips = [f"grip {i + 1}" for i, rubs in enumerate(_rubs(f)) if rubs]
        parts = [f"part {i + 1}" for i in range(len(f.sheaves) + 1)]
        return "taut", *grips, *parts, *(f"{what} {i + 1}" for i in _round(f) for what in ("wrap", "other side"))

    def switch(self, f: Reeving, p: np.ndarray, guard: str, shown: np.ndarray) -> tuple[str, float]:
        n = len(f.sheaves)
        _, lengths, kept, _ = np.split(shown, [n + 1, 2 * n + 2, 3 * n + 3])
        modes, own, limp, lies = np.split(p[3 : 4 + 4 * n], [n, 2 * n, 3 * n + 1])
        if guard == "taut":
            p[TAUT] = 1.0 - p[TAUT]
            own[:] = (lengths * (kept.sum() / lengths.sum()))[1:]  # slack rope has slid until it was even
            modes[:], limp[:] = 0.0 if p[TAUT] else FREE, 0.0
            modes[lies == 0.0] = FREE
            return "taut" if p[TAUT] else "slack", float(lengths.sum() - kept.sum())
        what, _, number = guard.rpartition(" ")
        i, strain = int(number) - 1, lengths / kept
        if what == "other side":
            why = f"meets sheave {number} from its other side, where it cannot turn; keep its ends apart"
            raise Ended(f"reeving '{f.name}'", why)
        if what == "wrap":
            lies[i] = 1.0 - lies[i]
            own[:], limp[i : i + 2] = kept[1:], 0.0
            modes[i] = 0.0 if lies[i] and p[TAUT] else FREE
            return "found" if lies[i] else "left", float(number)
        if what == "part":
            beside = [k for k, rubs in enumerate(_rubs(f)) if rubs and k in (i - 1, i) and not modes[k]]
            if p[TAUT] and not limp[i] and beside and strain[i] < 1.0 + UNSTRAINED:
                # it has just come taut while it runs: no friction holds what has no tension, so that it is drawn over
                own[:] = kept[1:]
                for k in beside:
                    modes[k] = float(np.sign(strain[k + 1] - strain[k])) or (1.0 if i == k else -1.0)
                return "slip", float(beside[0] + 1)
            limp[i] = 1.0 - limp[i] if p[TAUT] else 0.0
            return "limp" if limp[i] else "pulls", float(number)
        if not p[TAUT]:
            return "stick", float(number)
        own[:] = kept[1:]
        modes[i] = 0.0 if modes[i] else float(np.sign(strain[i + 1] - strain[i]))
        return "slip" if modes[i] else "stick", float(number)

    def shows(self, f: Reeving) -> list[Shown]:
        names = [f"{f.name}.{i + 1}" for i in range(len(f.sheaves) + 1)]
        topics = (("reeving/tension", "N"), ("reeving/length", "m"), ("reeving/unstretched", "m"))
        wraps = [Shown("reeving/wrap", f"{f.name}.{i + 1}", "rad") for i in _round(f)]
        return [Shown(topic, name, unit) for topic, unit in topics for name in names] + wraps


def _rubs(f: Reeving) -> list[bool]:
    return [s.friction > 0.0 or s.efficiency < 1.0 for s in f.sheaves]


def _round(f: Reeving) -> list[int]:
    """Sheaves that the rope can leave."""
    return [i for i, s in enumerate(f.sheaves) if s.radius > 0.0]


def _only(on: Scalar, x: Array) -> Array:
    """x where `on`, else zeros."""
    return np.array([select(on, e, 0.0) for e in x])


def _turning(f: Reeving) -> list[bool]:
    """Per node whether its wrap is needed."""
    return [False, *(s.friction > 0.0 or s.radius > 0.0 for s in f.sheaves), False]


def _all(f: Reeving) -> list[Sheave]:
    return [Sheave(f.a), *f.sheaves, Sheave(f.b)]


def _node_numbers(s: Sheave) -> list[float]:
    return [*s.at.p, *s.axis, 1.0, 0.0, 0.0, s.radius, s.friction, 1.0 / s.efficiency]


def _node(s: Sheave, q: Array, body: Array, label: str = "a") -> Node:
    """The node of a sheave, or of an end of the rope."""
    x, c, v = attachment(body, q[:3], label)
    R = np.reshape(body[:9], (3, 3))
    needed = s.radius > 0.0 or s.friction > 0.0
    axis, divide = (R @ q[3:6], R @ q[6:9]) if needed else (None, None)
    return Node(x, c, v, body[15:18], axis, divide, q[9] if s.radius > 0.0 else None)


def _divide(node: Node, before: Part, after: Part) -> tuple[Array, float]:
    """The middle of an arc, in world axes, and the wrap [rad] at the start."""
    first, last = (np.cross(x.plane, node.axis) for x in (before, after))
    wrap = float(np.arctan2(node.axis @ np.cross(first, last), first @ last)) % (2.0 * pi)
    half = 0.5 * wrap
    return np.cos(half) * first + np.sin(half) * np.cross(node.axis, first), wrap


def _body(R: Array, p: Array) -> Array:
    """A body at rest as laws see it, its tree's point in the world's origin."""
    return np.concatenate([np.ravel(R), np.zeros(3), p, np.zeros(6)])
