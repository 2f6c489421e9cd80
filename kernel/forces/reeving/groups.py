"""Groups of rope parts that slip together over sheaves, and the strains of the parts (see `reeving` for the equations).

Parts joined by slipping sheaves form a group: the ratios of their strains are those of the sheaves, and only the sum of
their unstretched lengths is given; the strain of the first part follows from it by Newton's method.

The edges of one rope may be on several bodies if nothing can turn them out of parallel: all joints between the bodies
slide, or turn about the direction of the edges.
"""

from collections.abc import Sequence
from math import e as E
from typing import Any

import numpy as np
from heavylift.kernel.algebra.dense import cross, norm
from heavylift.kernel.algebra.elementary import power
from heavylift.kernel.compiler.symbol import Array, Scalar, minimum, named, select
from heavylift.kernel.description.forces import Reeving, Sheave
from heavylift.kernel.description.mechanics import JOINTS, WORLD
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.force_law import Poses
from heavylift.kernel.multibody.graph import Graph, Link
from heavylift.kernel.multibody.motion import axes_of

from .sheaves import RopePath, Unrolled

BITE = 1e-9  # by how much more a sheave holds than it drags, so that one that begins to stick does not slip at once
NEWTON = 5  # iterations; the error shrinks as its square, from (strain)^2 on
FREE = 2.0  # mode of a sheave of a slack rope


class Groups:
    """Computes the strain of each part of a rope, and the flow of rope over each sheave.

    `modes`: whether the rope sticks or slips on each sheave.
    """

    def __init__(
        self,
        way: RopePath | Unrolled,
        kept: list[Scalar],
        dL: Scalar,
        rubs: list[bool],
        modes: Array,
        ratios: list[tuple[Scalar, Scalar]],
    ) -> None:
        self._rubs, self._modes, self._ratios = rubs, modes, ratios
        self._sums = 0  # for their names in print
        n = len(way.lengths)
        r, dr = [1.0], [0.0]
        for i, (ratio, rate) in enumerate(ratios):
            along = modes[i] > 0.0
            inverse = 1.0 / ratio
            free = modes[i] >= FREE
            # tension ratio against the motion: the part towards which the rope moves carries more
            g = select(free, 1.0, select(along, ratio, inverse)) if rubs[i] else 1.0
            dg = select(free, 0.0, select(along, rate, -rate * inverse * inverse)) if rubs[i] else 0.0
            r.append(named(f"ratio{i + 2}", self._joined(i, r[i] * g, 1.0)))
            dr.append(named(f"dratio{i + 2}", self._joined(i, dr[i] * g + r[i] * dg, 0.0)))
        l, dl = way.lengths, way.rates
        N = self._total(kept)
        # start of Newton's method: the strain of the group if all ratios were close to one
        whole = self._total(l)
        s = [(a / b - 1.0) * a / c for a, b, c in zip(whole, N, self._total(_times(r, l)), strict=True)]
        # quadratic convergence from errors of the order of strain squared
        for k in range(NEWTON if any(rubs) else 0):  # exact already where all ratios are 1
            s = [named(f"s{k}_{i + 1}", x) for i, x in enumerate(s)]
            q = [1.0 / (1.0 + a * b) for a, b in zip(r, s, strict=True)]
            # sum of l / (1 + r s) must equal the unstretched length of the group
            miss = self._total(_times(l, q))
            slope = self._total(_times(r, l, q, q))
            s = [x + (m - n_) / a for x, m, n_, a in zip(s, miss, N, slope, strict=True)]
        s = [named(f"s_{i + 1}", x) for i, x in enumerate(s)]
        q = [1.0 / (1.0 + a * b) for a, b in zip(r, s, strict=True)]
        driven = self._total([dL] + [0.0] * (n - 1))
        free = self._total([a * b - l_ * c * x * b * b for a, b, l_, c, x in zip(dl, q, l, dr, s, strict=True)])
        slope = self._total(_times(r, l, q, q))
        # rate of the group's strain from rates of lengths, ratios and drum
        ds = [(a - b) / k for a, b, k in zip(free, driven, slope, strict=True)]
        self.strains = _times(r, s)
        self.rates = [a * b + c * d for a, b, c, d in zip(r, ds, dr, s, strict=True)]
        self.unstretched = _times(l, q)
        self._group = N
        passed = dL
        self.flows: list[Scalar] = []
        for i in range(n - 1):
            # rope that has passed each sheave: what comes in less what its part has taken up
            passed = passed - (dl[i] * q[i] - l[i] * self.rates[i] * q[i] * q[i])
            self.flows.append(self._joined(i, passed, 0.0))

    def _joined(self, i: int, yes: Scalar, no: Scalar) -> Any:
        """Return `yes` where the rope slips over sheave i, else `no`."""
        return select(abs(self._modes[i]) > 0.0, yes, no) if self._rubs[i] else yes

    def _total(self, values: list[Scalar]) -> list[Scalar]:
        """Return, for each part, the sum of values over its group."""
        sums = [values[0]]
        for i, x in enumerate(values[1:]):
            sums.append(x + self._joined(i, sums[i], 0.0))
        for i in reversed(range(len(values) - 1)):
            sums[i] = self._joined(i, sums[i + 1], sums[i])
        self._sums += 1
        return [named(f"sum{self._sums}_{i + 1}", x) for i, x in enumerate(sums)]

    def mean_rates(self) -> list[Scalar]:
        """Return, for each part of a rope, the mean strain rate of the parts between which it slips freely [1/s]."""
        together = self._total(_times(self.unstretched, self.rates))
        return [a / b for a, b in zip(together, self._group, strict=True)]

    def grips(self) -> list[Scalar]:
        """Return the guards of the sheaves with friction: the margin of each sheave against slip of the rope."""
        s = self.strains
        out = []
        for i, (ratio, _) in enumerate(self._ratios):
            if self._rubs[i]:
                # BITE keeps a sheave that has just gripped from slipping at once
                most = ratio * (1.0 + BITE)
                holds = minimum(most * s[i] - s[i + 1], most * s[i + 1] - s[i])
                out.append(self._joined(i, self._modes[i] * self.flows[i], holds))
        return out


def _times(*columns: Sequence[Scalar]) -> list[Scalar]:
    out = list(columns[0])
    for column in columns[1:]:
        out = [a * b for a, b in zip(out, column, strict=True)]
    return out


def slip_ratio(s: Sheave, q: Array, wrap: tuple[Scalar, Scalar] | None) -> tuple[Scalar, Scalar]:
    """Return tension ratio and its rate at a sheave on which the rope slips; `wrap`: wrap angle [rad] and its rate."""
    ratio, rate = (q[11], 0.0) if s.efficiency < 1.0 else (1.0, 0.0)
    if wrap and s.friction > 0.0:
        angle, turning = wrap
        if not s.radius:  # a point turns the rope either way
            angle, turning = abs(angle), select(angle > 0.0, turning, -turning)
        # Euler-Eytelwein: exp(mu times wrap)
        ratio = ratio * power(E, q[10] * angle)
        rate = ratio * q[10] * turning
    return ratio, rate


ALONG = 1e-9  # sine between the direction of edges and an axis that turns a body of theirs


def check_parallel(f: Reeving, graph: Graph, poses: Poses) -> None:
    """Raise KernelError for a rope over edges of several bodies that can rotate out of parallel."""
    bodies = list(dict.fromkeys(s.at.body for s in f.edges))
    if len(bodies) < 2:
        return
    n = poses(bodies[0])[0] @ np.array(f.edges[0].axis)
    paths = [_path(graph, body) for body in bodies]
    shared = set.intersection(*map(set, paths))
    for body, path in zip(bodies, paths, strict=True):
        own = [i for i in path if i not in shared]
        bends = [graph.links[i] for i in (*own, *([max(shared)] if shared else [])) if graph.links[i].modes]
        # a flexible body tilts edges in any case, however small
        loose = [link for link in map(graph.links.__getitem__, own) if _turns(link, poses, n)]
        if bends or loose:
            what = f"what bends of '{bends[0].body.name}'" if bends else f"the joint '{loose[0].joint.name}'"
            message = f"its edges are on several bodies, and {what} can turn the one on '{body}' out of parallel"
            raise KernelError(f"reeving '{f.name}': {message}; use edges of a single body")


def _path(graph: Graph, body: str) -> list[int]:
    """Return the numbers of the links from a body to the ground."""
    i = -1 if body == WORLD else graph.number(body)
    found = []
    while i >= 0:
        found.append(i)
        i = graph.links[i].parent
    return found


def _turns(link: Link, poses: Poses, n: Array) -> bool:
    """Return whether a joint turns its child about an axis other than n."""
    joint = link.joint
    kind = JOINTS[joint.kind]
    if kind.quaternion is not None:
        return True
    frame = poses(joint.parent)[0] @ np.array(joint.R_PJ)
    axes = [(frame @ axes_of(joint)[m.axis]).tolist() for m in kind.motions if m.turns]
    return any(norm(cross(n.tolist(), a)) > ALONG for a in axes)
