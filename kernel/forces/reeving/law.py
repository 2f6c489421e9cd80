"""A massless elastic rope over sheaves with friction, stick and slip at each of them.

Each part j between two nodes has its own unstretched length N_j and strain s_j = l_j/N_j - 1. At a sheave that sticks
no rope passes; at one that slips the strains keep the ratio rho = exp(mu wrap)/efficiency against the motion
(Euler-Eytelwein). Parts joined by slipping sheaves form a group: s_j = r_j s, where s solves sum l_j/(1 + r_j s) =
unstretched length of the group (Newton's method, exact to round-off). T_j = EA s_j + c sum N_j s_j' / sum N_j over its
group, which for a rope without friction is `Rope`'s EA e/L0 + damping e' with c = damping L0. Discrete states, frozen
in a step: a sheave slips when the ratio passes rho (1 + BITE) and sticks when the flow of rope over it falls through
zero; a part whose damping would make it push is limp; a slack rope slides freely, and its parts are one group of equal
strain. The rope leaves a sheave with a radius when its wrap falls to zero, and touches it again when the straight part
comes back (`sheaves`); in between, the sheave joins its parts without friction. Heat of a sheave is (T_out - T_in)
times the flow, including the strain energy that is carried over.
"""

from __future__ import annotations

from collections.abc import Hashable
from functools import partial
from itertools import pairwise

import numpy as np
from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, maximum, minimum, select, sqrt
from heavylift.kernel.description.forces import Reeving
from heavylift.kernel.forces.force_law import ForceLaw, LawBreakdown, LawOutput, Poses, SampledQuantity, wrench
from msgspec import structs

from .groups import FREE, Groups, slip_ratio
from .nodes import NODE, all_nodes, laid, leavable, lost, node_of, placed, turning, way_over
from .sheaves import RopePath, Unrolled

UNIT = 1e-6  # how far an axis may be off by rounding

ROUNDING = 1e-14  # of a strain
UNSTRAINED = 1e-7  # strain of a part that has just come taut


class ReevingAt:
    """Indices into the parameters of a rope over sheaves; `TAUT`: 1 taut, 0 slack, -1 unhooked."""

    EA, C, TAUT = range(3)
    HEAD = 3


class ReevingLaw(ForceLaw[Reeving]):
    """Force law of a rope over sheaves.

    Its parameters: EA, c, taut; for each sheave its mode (flow of rope backward -1, none 0, forward +1; FREE);
    unstretched length of each part but the first; limp parts; sheaves in contact; nodes.
    """

    works = True

    def check(self, f: Reeving) -> None:
        self.demand(f, "length", f.signal.value > 0.0, f"is {f.signal.value:g}; it must be positive")
        self.demand(f, "sheaves", bool(f.sheaves), "are missing; a rope without any is a Rope")
        for i, s in enumerate(f.sheaves, 1):
            self.demand(f, f"sheave {i}", min(s.radius, s.friction) >= 0.0, "has a negative radius or friction")
            self.demand(f, f"sheave {i}", 0.0 < s.efficiency <= 1.0, "has an efficiency outside (0, 1]")
            size = norm(list(s.axis))
            self.demand(f, f"sheave {i}", abs(size - 1.0) < UNIT, f"has an axis of length {size:g}; it must be 1")
        self._check_edges(f)

    def _check_edges(self, f: Reeving) -> None:
        if f.edges:
            whole = len(f.edges) == len(f.sheaves)
            self.demand(f, "edges", whole, "and sheaves are mixed; a rope runs over either")
        for s in f.edges:
            what = f"edge '{s.edge}'"
            self.demand(f, what, s.radius > 0.0, "has no radius; it must be positive")
            self.demand(f, what, s.efficiency == 1.0, "has an efficiency; edges have friction only")
            self.demand(f, what, s.span[0] < s.span[1], "has no length; keep its ends apart")

    def shape(self, f: Reeving) -> Hashable:
        kinds = tuple((s.radius > 0.0, s.friction > 0.0, s.efficiency < 1.0, bool(s.edge)) for s in f.sheaves)
        return (*kinds, "apart") if f.apart else kinds

    def numbers(self, f: Reeving, poses: Poses) -> list[float]:
        n = len(f.sheaves)
        given, lies = placed(f, poses, partial(self.demand, f))
        lengths = [0.0] * n  # of a rope that sticks; set when it comes taut
        limp = [0.0] * (n + 1)
        on = [float(x is None or (x and f.hooked)) for x in lies[1:-1]]
        head = [f.EA, f.damping * f.signal.value, 0.0 if f.hooked else -1.0]
        return [*head, *[FREE] * n, *lengths, *limp, *on, *(x for q in given for x in q)]

    def start_length(self, f: Reeving, poses: Poses) -> float:
        """Return the initial unstretched length of the rope [m]; raises KernelError if its sheaves allow no path."""
        return float(sum(laid(f, poses, partial(self.demand, f)).lengths))

    def off_its_sheaves(self, f: Reeving, poses: Poses, shown: np.ndarray) -> str:
        """Describe where a rope has left its sheave or runs around it the wrong way; "" if neither is the case."""
        first = 3 * len(f.sheaves) + 3
        return lost(f, poses, list(shown[first : first + len(leavable(f))]))

    def answer(
        self,
        f: Reeving,
        p: Array,
        ends: list[Array],
        signal: Scalars,
        joint: Scalars,
        t: Scalar,
        counted: Array | None = None,
    ) -> LawOutput:
        n = len(f.sheaves)
        EA, c, on = p[ReevingAt.EA], p[ReevingAt.C], p[ReevingAt.TAUT] > 0.0
        modes, own, limp, lies = p[3 : 3 + n], p[3 + n : 3 + 2 * n], p[3 + 2 * n : 4 + 3 * n], p[4 + 3 * n : 4 + 4 * n]
        first = 4 + 4 * n
        # the first part has what is left of the rope: drums change that one
        kept = [signal[0] - sum(own, 0.0), *own]
        given = [p[first + NODE * i : first + NODE * (i + 1)] for i in range(n + 2)]
        placed = zip(all_nodes(f), given, ends, strict=True)
        nodes = [node_of(x, q, body, f"a{i}") for i, (x, q, body) in enumerate(placed, 1)]
        leaves = [s.radius > 0.0 for s in f.sheaves]
        there = [lies[i] > 0.0 if x else None for i, x in enumerate(leaves)]
        distance = way_over(f, nodes, [None, *there, None], counted)
        made = distance.parts
        ratios = [slip_ratio(s, given[i], distance.wraps.get(i)) for i, s in enumerate(f.sheaves, 1)]
        rope = Groups(distance, kept, signal[1], _rubs(f), modes, ratios)
        s, ds, N = rope.strains, rope.rates, rope.unstretched
        # damping by the mean rate of the group: parts that slip freely share one tension
        trial = [EA * x + c * rate for x, rate in zip(s, rope.mean_rates(), strict=True)]
        # a part whose damping would push is limp
        pulls = [select(on, select(x > 0.0, 0.0, 1.0), 0.0) > 0.0 for x in limp]
        T = [select(pull, maximum(k, 0.0), 0.0) for pull, k in zip(pulls, trial, strict=True)]
        wrenches = [wrench(part.arms[0], k * part.u) for part, k in zip(made, T, strict=True)]
        back = [-wrench(part.arms[1], k * part.u) for part, k in zip(made, T, strict=True)]
        # at a sheave that the rope touches, the forces of both parts act on its body; else none
        inner = [a + b for a, b in zip(wrenches[1:], back[:-1], strict=True)]
        inner = [x if on_ is None else _only(on_, x) for x, on_ in zip(inner, there, strict=True)]
        # energy carried by rope that passes: work of the tension plus strain energy
        carried = [k * (1.0 + x) - 0.5 * EA * x * x for k, x in zip(T, s, strict=True)]
        rubbed = [flow * (b - a) for flow, (a, b) in zip(rope.flows, pairwise(carried), strict=True)]
        damped = [(k - EA * x) * m * dx for k, x, m, dx in zip(T, s, N, ds, strict=True)]
        least = s[0]
        for x in s[1:]:
            least = minimum(least, x)
        slid, message, inside = _along_edges(distance, there, T, given)
        off = p[ReevingAt.TAUT] < 0.0
        excess = sum(distance.lengths) - signal[0]
        rubbing = [there[i] for i, rubs in enumerate(_rubs(f)) if rubs]
        held = [select(on, g, 1.0) for g in rope.grips()]
        grips = [g if on_ is None else select(on_, g, 1.0) for g, on_ in zip(held, rubbing, strict=True)]
        eased = [select(on, select(x > 0.0, -k, k), 1.0) for x, k in zip(limp, trial, strict=True)]
        return LawOutput(
            [wrenches[0], *inner, back[-1]],
            heat=select(on, sum(rubbed) + sum(damped) + slid if f.edges else sum(rubbed) + sum(damped), 0.0),
            work=select(on, -carried[0] * signal[1], 0.0),
            stored=select(on, sum(0.5 * EA * x * x * m for x, m in zip(s, N, strict=True)), 0.0),
            # taut -> slack when the least strain vanishes; slack -> taut when the path exceeds the length
            guards=[
                select(on, least, select(off, 1.0, -excess)),
                *grips,
                *eased,
                *(select(off, 1.0, g) for g in (*(g for pair in distance.watches() for g in pair), *inside)),
            ],
            shown=[
                *T,
                *distance.lengths,
                *N,
                *(select(there[i], distance.wraps[i + 1][0], 0.0) for i, x in enumerate(leaves) if x),
                *message,
            ],
            turned=distance.turned,
            turning=distance.turning,
        )

    def angles(self, f: Reeving) -> int:
        return 2 * sum(turning(f))

    def turns(self, f: Reeving, poses: Poses) -> None:
        return None  # arcs are divided where the rope lies at the start

    def guards(self, f: Reeving) -> tuple[str, ...]:
        grips = [f"grip {i + 1}" for i, rubs in enumerate(_rubs(f)) if rubs]
        parts = [f"part {i + 1}" for i in range(len(f.sheaves) + 1)]
        ends = [f"end {i + 1}" for i in range(len(f.edges))]
        sides = [f"{what} {i + 1}" for i in leavable(f) for what in ("wrap", "other side")]
        return "taut", *grips, *parts, *sides, *ends

    def switch(self, f: Reeving, p: np.ndarray, guard: str, shown: np.ndarray) -> tuple[str, float]:
        n = len(f.sheaves)
        lengths, kept = shown[n + 1 : 3 * n + 3].reshape(2, n + 1)
        modes, own, limp, lies = np.split(p[ReevingAt.HEAD : 4 + 4 * n], [n, 2 * n, 3 * n + 1])
        even = (lengths * (kept.sum() / lengths.sum()))[1:]
        if guard == "taut":
            p[ReevingAt.TAUT] = 1.0 - p[ReevingAt.TAUT]
            own[:] = even  # slack rope has slid
            modes[:], limp[:] = 0.0 if p[ReevingAt.TAUT] else FREE, 0.0
            modes[lies == 0.0] = FREE
            return "taut" if p[ReevingAt.TAUT] else "slack", float(lengths.sum() - kept.sum())
        what, _, number = guard.rpartition(" ")
        i, strain = int(number) - 1, lengths / kept
        if what in ("other side", "end"):
            who = f"edge '{f.sheaves[i].edge}'" if f.edges else f"sheave {number}"
            why = f"meets {who} from its other side, where it cannot turn; keep its ends apart"
            why = f"runs off the end of {who}; make it longer, or keep the rope along it" if what == "end" else why
            raise LawBreakdown(f"reeving '{f.name}'", why)
        if what == "wrap":
            lies[i] = 1.0 - lies[i]
            own[:], limp[i : i + 2] = kept[1:], 0.0
            modes[i] = 0.0 if lies[i] and p[ReevingAt.TAUT] else FREE
            return "found" if lies[i] else "left", float(number)
        if what == "part":
            other = [k for k, rubs in enumerate(_rubs(f)) if rubs and k in (i - 1, i) and not modes[k]]
            if p[ReevingAt.TAUT] and not limp[i] and other and strain[i] < 1.0 + UNSTRAINED:
                # it has just come taut while it runs: no friction holds what has no tension, so that it is drawn over
                own[:] = kept[1:]
                for k in other:
                    apart = strain[k + 1] - strain[k]
                    modes[k] = float(np.sign(apart)) if abs(apart) > ROUNDING else 1.0 if i == k else -1.0
                return "slip", float(other[0] + 1)
            limp[i] = 1.0 - limp[i] if p[ReevingAt.TAUT] else 0.0
            return "limp" if limp[i] else "pulls", float(number)
        if not p[ReevingAt.TAUT]:
            return "stick", float(number)
        sticks, strained = modes[i] != 0.0, abs(lengths.sum() / kept.sum() - 1.0) > UNSTRAINED
        own[:] = kept[1:] if strained or not sticks else even  # rounding decides nothing where there is no tension
        modes[i] = 0.0 if sticks else float(np.sign(strain[i + 1] - strain[i]))
        return "slip" if modes[i] else "stick", float(number)

    def take_off(self, f: Reeving, p: np.ndarray) -> None:
        """Unhook a rope over sheaves by changing its parameters p: it then touches no sheave and no end point."""
        n = len(f.sheaves)
        modes, own, limp, lies = np.split(p[ReevingAt.HEAD : 4 + 4 * n], [n, 2 * n, 3 * n + 1])
        p[ReevingAt.TAUT], modes[:], own[:], limp[:] = -1.0, FREE, 0.0, 0.0
        lies[leavable(f)] = 0.0

    def put_on(self, f: Reeving, p: np.ndarray, L0: float, poses: Poses) -> float:
        """Hang a slack rope over its sheaves from end a to end b; return by how much it is too short [m]."""
        p[ReevingAt.HEAD :] = self.numbers(structs.replace(f, hooked=True), poses)[ReevingAt.HEAD :]
        p[ReevingAt.TAUT] = 0.0
        return self.start_length(f, poses) - L0

    def shows(self, f: Reeving) -> list[SampledQuantity]:
        names = [f"{f.name}.{i + 1}" for i in range(len(f.sheaves) + 1)]
        topics = (("reeving/tension", "N"), ("reeving/length", "m"), ("reeving/unstretched", "m"))
        wraps = [SampledQuantity("reeving/wrap", f"{f.name}.{i + 1}", "rad") for i in leavable(f)]
        on_edge = (("edge/force", "N"), ("edge/place", "m"))
        shown = [SampledQuantity(topic, f"{f.name}.{s.edge}", unit) for s in f.edges for topic, unit in on_edge]
        return [SampledQuantity(topic, name, unit) for topic, unit in topics for name in names] + wraps + shown


def _rubs(f: Reeving) -> list[bool]:
    return [s.friction > 0.0 or s.efficiency < 1.0 for s in f.sheaves]


def _only(on: Scalar, x: Array) -> Array:
    """Return x where `on`, else zeros."""
    return np.array([select(on, e, 0.0) for e in x])


def _along_edges(
    way: RopePath | Unrolled, there: list[Scalar | None], T: list[Scalar], given: list[Array]
) -> tuple[Scalar, list[Scalar], list[Scalar]]:
    """Return the heat of sliding along edges, force [N] and place [m] at each edge, guards of the edges' ends."""
    if isinstance(way, RopePath):
        return 0.0, [], []
    pulls = [k * part.u for k, part in zip(T, way.parts, strict=True)]
    message: list[Scalar] = []
    for on, (comes, goes), (before, behind) in zip(there, way.spans, pairwise(pulls), strict=True):
        message += [
            select(on, sqrt((behind - before) @ (behind - before)), 0.0),
            select(on, abs(0.5 * (comes + goes)), 0.0),
        ]
    slid = sum(k * x for k, x in zip(T, way.slides, strict=True))
    return slid, message, way.within([q[NODE - 2 :] for q in given[1:-1]])
