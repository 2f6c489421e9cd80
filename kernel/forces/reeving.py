"""A massless elastic rope over sheaves with friction, stick and slip at each of them.

Each part j between two nodes has its own unstretched length N_j and strain s_j = l_j/N_j - 1.  At a sheave that sticks
no rope passes; at one that slips the strains keep the ratio rho = exp(mu wrap)/efficiency against the motion
(Euler-Eytelwein).  Parts joined by slipping sheaves form a group: s_j = r_j s, with s from sum l_j/(1 + r_j s) =
unstretched length of the group (Newton's method, exact to round-off).  T_j = EA s_j + c sum N_j s_j' / sum N_j over its
group, which for a rope without friction is `Rope`'s EA e/L0 + damping e' with c = damping L0.
Discrete states, frozen in a step: a sheave slips when the ratio passes rho (1 + BITE) and sticks when the flow of rope
over it falls through zero; a part whose damping would make it push is limp; slack rope slides freely, its parts are one
group of equal strain.  Heat of a sheave is (T_out - T_in) times the flow, with the strain energy that is carried over.
"""

from __future__ import annotations

from itertools import pairwise
from math import pi
from typing import Any

import numpy as np

from ..laws import attachment
from ..symbol import maximum, minimum, select
from .describe import Reeving, Sheave, Signal
from .groups import FREE, Groups, slip_ratio
from .law import Answer, ForceLaw, Poses, Shown, wrench
from .sheaves import Node, Part, parts

__all__ = ["ReevingLaw"]

MOST_WRAP = 1.5 * pi  # a larger one means that the axis points the wrong way
TAUT = 2  # place of the state in P, behind EA and c
NODE = 12  # numbers of a node: centre, axis, dividing direction, radius, friction, 1/efficiency
PARALLEL = 0.99  # cosine between the axes of neighbouring sheaves
ALONG = 0.9  # sine of a fleet angle at which a rope no longer lies in its sheave
MEETS = 1e-2  # part of a radius or length, near which a rope loses its direction in steps that become too small
UNIT = 1e-6  # how far an axis may be off by rounding

UNSTRAINED = 1e-7  # strain of a part that has just come taut


class ReevingLaw(ForceLaw):
    """P: EA, c, taut; per sheave its mode (-1, 0, +1: flow against, none, along the rope; FREE); per part but the first
    its N; per part whether it is limp; the nodes."""

    works = True

    def check(self, f: Reeving) -> None:
        self.demand(f, "EA", f.EA > 0.0, f"is {f.EA:g}; it must be positive")
        self.demand(f, "length", f.signal.value > 0.0, f"is {f.signal.value:g}; it must be positive")
        self.demand(f, "damping", f.damping >= 0.0, f"is {f.damping:g}; it cannot be negative")
        self.demand(f, "sheaves", bool(f.sheaves), "are missing; a rope without any is a Rope")
        for i, s in enumerate(f.sheaves, 1):
            self.demand(f, f"sheave {i}", min(s.radius, s.friction) >= 0.0, "has a negative radius or friction")
            self.demand(f, f"sheave {i}", 0.0 < s.efficiency <= 1.0, "has an efficiency outside (0, 1]")
            size = float(np.linalg.norm(s.axis))
            self.demand(f, f"sheave {i}", abs(size - 1.0) < UNIT, f"has an axis of length {size:g}; it must be 1")

    def signal(self, f: Reeving) -> Signal:
        return f.signal

    def shape(self, f: Reeving) -> Any:
        return [(s.radius > 0.0, s.friction > 0.0, s.efficiency < 1.0) for s in f.sheaves]

    def numbers(self, f: Reeving, poses: Poses) -> list[float]:
        n = len(f.sheaves)
        given = self._placed(f, poses)
        lengths = [0.0] * n  # of a rope that sticks; set when it comes taut
        limp = [0.0] * (n + 1)
        return [f.EA, f.damping * f.signal.value, 0.0, *[FREE] * n, *lengths, *limp, *(x for q in given for x in q)]

    def start_length(self, f: Reeving, poses: Poses) -> float:
        """Its length in the initial pose [m]; raises KernelError where it cannot run so."""
        given, bodies = self._placed(f, poses), [_body(*poses(p.body)) for p in f.points]
        nodes = [_node(x, np.array(q), body) for x, q, body in zip(_all(f), given, bodies, strict=True)]
        return float(sum(x.length for x in parts(nodes, _turning(f))))

    def off_its_sheaves(self, f: Reeving, poses: Poses) -> str:
        """Where a rope that ran well has come to have no direction, in words; "" if it runs."""
        bodies = [_body(*poses(p.body)) for p in f.points]
        given = [np.array(_node_numbers(x)) for x in _all(f)]
        nodes = [_node(x, q, body) for x, q, body in zip(_all(f), given, bodies, strict=True)]
        for i, (a, b) in enumerate(pairwise(nodes), 1):
            axis, D = b.axis if a.axis is None else a.axis, b.c - a.c
            if axis is None:
                continue
            across = float(np.linalg.norm(D - (D @ axis) * axis))
            if across < (1.0 + MEETS) * abs(float((a.radius or 0.0) - (b.radius or 0.0))):
                return f"part {i} comes within its sheave; keep its ends apart"
            if across < MEETS * float(np.linalg.norm(D)):
                return f"part {i} runs along the axis of its sheave; turn the axis across the rope"
        return ""

    def _placed(self, f: Reeving, poses: Poses) -> list[list[float]]:
        """The numbers of the nodes, arcs divided in the middle."""
        given = [_node_numbers(x) for x in _all(f)]
        bodies = [_body(*poses(p.body)) for p in f.points]
        nodes = [_node(x, np.array(q), body) for x, q, body in zip(_all(f), given, bodies, strict=True)]
        self._check_places(f, nodes)
        made = parts(nodes, _turning(f))
        for i, turning in enumerate(_turning(f)):
            if turning:
                here, wrap = _divide(nodes[i], made[i - 1], made[i])
                told = f"is wrapped by {np.degrees(wrap):.0f} degrees; turn its axis round"
                self.demand(f, f"sheave {i}", wrap <= MOST_WRAP, told)
                given[i][6:9] = (bodies[i][:9].reshape(3, 3).T @ here).tolist()
        return given

    def _check_places(self, f: Reeving, nodes: list[Node]) -> None:
        for i, (a, b) in enumerate(pairwise(nodes), 1):
            bias = float((a.radius or 0.0) - (b.radius or 0.0))
            D = b.c - a.c
            self.demand(f, f"part {i}", float(D @ D) > bias * bias, "has no length; keep its ends apart")
            for x in (a, b):
                if x.axis is not None:
                    told = "runs along the axis of its sheave; turn the axis across the rope"
                    self.demand(f, f"part {i}", abs(float(D @ x.axis)) < ALONG * float(np.linalg.norm(D)), told)
            if a.radius is not None and b.radius is not None:
                self.demand(
                    f, f"part {i}", abs(float(a.axis @ b.axis)) > PARALLEL, "joins sheaves whose axes are not parallel"
                )

    def answer(self, f: Reeving, p: Any, ends: list[Any], signal: Any, joint: Any, t: Any) -> Answer:
        n = len(f.sheaves)
        EA, c, on = p[0], p[1], p[TAUT] > 0.0
        modes, own, limp, first = p[3 : 3 + n], p[3 + n : 3 + 2 * n], p[3 + 2 * n : 4 + 3 * n], 4 + 3 * n
        kept = [signal[0] - sum(own, 0.0), *own]
        given = [p[first + NODE * i : first + NODE * (i + 1)] for i in range(n + 2)]
        told = zip(_all(f), given, ends, strict=True)
        nodes = [_node(x, q, body, f"a{i}") for i, (x, q, body) in enumerate(told, 1)]
        turning = _turning(f)
        made = parts(nodes, turning)
        ratios = [
            slip_ratio(s, nodes[i], made[i - 1], made[i], given[i], turning[i]) for i, s in enumerate(f.sheaves, 1)
        ]
        rope = Groups(made, kept, signal[1], _rubs(f), modes, ratios)
        s, ds, N = rope.strains, rope.rates, rope.unstretched
        trial = [EA * x + c * rate for x, rate in zip(s, rope.mean_rates(), strict=True)]
        pulls = [select(on, select(x > 0.0, 0.0, 1.0), 0.0) > 0.0 for x in limp]
        T = [select(pull, maximum(k, 0.0), 0.0) for pull, k in zip(pulls, trial, strict=True)]
        wrenches = [wrench(part.arms[0], k * part.u) for part, k in zip(made, T, strict=True)]
        back = [-wrench(part.arms[1], k * part.u) for part, k in zip(made, T, strict=True)]
        inner = [a + b for a, b in zip(wrenches[1:], back[:-1], strict=True)]
        carried = [k * (1.0 + x) - 0.5 * EA * x * x for k, x in zip(T, s, strict=True)]
        rubbed = [flow * (b - a) for flow, (a, b) in zip(rope.flows, pairwise(carried), strict=True)]
        damped = [(k - EA * x) * m * dx for k, x, m, dx in zip(T, s, N, ds, strict=True)]
        least = s[0]
        for x in s[1:]:
            least = minimum(least, x)
        excess = sum(x.length for x in made) - signal[0]
        grips = [select(on, g, 1.0) for g in rope.grips()]
        eased = [select(on, select(x > 0.0, -k, k), 1.0) for x, k in zip(limp, trial, strict=True)]
        return Answer(
            [wrenches[0], *inner, back[-1]],
            heat=select(on, sum(rubbed) + sum(damped), 0.0),
            work=select(on, -carried[0] * signal[1], 0.0),
            stored=select(on, sum(0.5 * EA * x * x * m for x, m in zip(s, N, strict=True)), 0.0),
            guards=[select(on, least, -excess), *grips, *eased],
            shown=[*T, *(x.length for x in made), *N],
        )

    def guards(self, f: Reeving) -> int:
        return 1 + sum(_rubs(f)) + len(f.sheaves) + 1

    def switch(self, f: Reeving, p: np.ndarray, guard: int, shown: np.ndarray) -> tuple[str, float]:
        n = len(f.sheaves)
        _, lengths, kept = np.split(shown, 3)
        modes, own, limp = p[3 : 3 + n], p[3 + n : 3 + 2 * n], p[3 + 2 * n : 4 + 3 * n]
        rubbing = [i for i, rubs in enumerate(_rubs(f)) if rubs]
        if guard == 0:
            p[TAUT] = 1.0 - p[TAUT]
            own[:] = (lengths * (kept.sum() / lengths.sum()))[1:]  # slack rope has slid until it was even
            modes[:], limp[:] = 0.0 if p[TAUT] else FREE, 0.0
            return "taut" if p[TAUT] else "slack", float(lengths.sum() - kept.sum())
        if guard > len(rubbing):
            part = guard - len(rubbing) - 1
            beside = [i for i in rubbing if i in (part - 1, part) and not modes[i]]
            strain = lengths / kept
            if p[TAUT] and not limp[part] and beside and strain[part] < 1.0 + UNSTRAINED:
                # it has just come taut while it runs: no friction holds what has no tension, so that it is drawn over
                own[:] = kept[1:]
                for i in beside:
                    modes[i] = float(np.sign(strain[i + 1] - strain[i])) or (1.0 if part == i else -1.0)
                return "slip", float(beside[0] + 1)
            limp[part] = 1.0 - limp[part] if p[TAUT] else 0.0
            return "limp" if limp[part] else "pulls", float(part + 1)
        i = rubbing[guard - 1]
        if not p[TAUT]:
            return "stick", float(i + 1)
        own[:] = kept[1:]
        strain = lengths / kept
        modes[i] = 0.0 if modes[i] else float(np.sign(strain[i + 1] - strain[i]))
        return "slip" if modes[i] else "stick", float(i + 1)

    def shows(self, f: Reeving) -> list[Shown]:
        names = [f"{f.name}.{i + 1}" for i in range(len(f.sheaves) + 1)]
        topics = (("reeving/tension", "N"), ("reeving/length", "m"), ("reeving/unstretched", "m"))
        return [(topic, name, unit) for topic, unit in topics for name in names]


def _rubs(f: Reeving) -> list[bool]:
    return [s.friction > 0.0 or s.efficiency < 1.0 for s in f.sheaves]


def _turning(f: Reeving) -> list[bool]:
    """Per node whether its wrap is needed."""
    return [False, *(s.friction > 0.0 or s.radius > 0.0 for s in f.sheaves), False]


def _all(f: Reeving) -> list[Sheave]:
    return [Sheave(f.a), *f.sheaves, Sheave(f.b)]


def _node_numbers(s: Sheave) -> list[float]:
    return [*s.at.p, *s.axis, 1.0, 0.0, 0.0, s.radius, s.friction, 1.0 / s.efficiency]


def _node(s: Sheave, q: Any, body: Any, label: str = "a") -> Node:
    """The node of a sheave, or of an end of the rope."""
    x, c, v = attachment(body, q[:3], label)
    R = np.reshape(body[:9], (3, 3))
    needed = s.radius > 0.0 or s.friction > 0.0
    axis, divide = (R @ q[3:6], R @ q[6:9]) if needed else (None, None)
    return Node(x, c, v, body[15:18], axis, divide, q[9] if s.radius > 0.0 else None)


def _divide(node: Node, before: Part, after: Part) -> tuple[Any, float]:
    """The middle of an arc, in world axes, and the wrap [rad] at the start."""
    first, last = (np.cross(x.plane, node.axis) for x in (before, after))
    wrap = float(np.arctan2(node.axis @ np.cross(first, last), first @ last)) % (2.0 * pi)
    half = 0.5 * wrap
    return np.cos(half) * first + np.sin(half) * np.cross(node.axis, first), wrap


def _body(R: Any, p: Any) -> Any:
    """A body at rest as laws see it, its tree's point in the world's origin."""
    return np.concatenate([np.ravel(R), np.zeros(3), p, np.zeros(6)])
