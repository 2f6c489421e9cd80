"""The first stage of an evaluation: what drives and winches follow, and where all bodies are and how they move.

Prescribed joints follow commanded masters only, so that places are known before anything is measured; servos and
winches may follow measured ones as well.  A reference is a profile plus f(s) = k1 s + kc cos s + ks sin s of masters.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from heavylift.kernel.algebra.elementary import atan2, cos, sin
from heavylift.kernel.algebra.spatial import cross
from heavylift.kernel.compiler.symbol import named, sqrt
from heavylift.kernel.description.mechanics import Measured
from heavylift.kernel.multibody.continuous_angles import Label, on_turn

from .program import Program

__all__ = ["Placing", "Reference", "attitude"]

GROUND = np.concatenate([np.eye(3).ravel(), np.zeros(12)])
Reference = tuple[Any, Any, Any]  # value, rate, acceleration


class Placing:
    """References, ends and masters at time t [s], state y, parameters P; `inside`: a time within the step."""

    def __init__(self, program: Program, t: Any, y: Any, P: Any, inside: Any) -> None:
        self.program, self.system, self.graph, self._P = program, program.system, program.graph, P
        self._t = [t, inside]
        nq, nv = program.nq, program.nv
        self.q, self.v = list(y[:nq]), list(y[nq : nq + nv])
        behind = nq + nv + len(program.accounts)
        self.accounts, self.counted = list(y[nq + nv : behind]), list(y[behind:])
        self.turned: dict[Label, Any] = {}  # angles over all their turns
        self.turning: dict[Label, Any] = {}  # their rates
        self._ends: dict[int, Any] = {-1: GROUND}
        self._masters: list[tuple[Any, Any, Any, Any, Any]] = []
        self._references: dict[str, Reference] = {}
        self._follow_and_place()

    def numbers(self, kind: str, name: str) -> Any:
        """Its part of the parameters P."""
        return self._P[self.program.parameters.at[kind, name]]

    @property
    def ends(self) -> dict[int, Any]:
        """(21,) R, o, r, V of every body that a law acts on, by its number."""
        return self._ends

    @property
    def gravity(self) -> Any:
        return self.numbers("gravity", "")[0]

    def _follow_and_place(self) -> None:
        """Prescribed joints first (they follow commanded masters only), then places, measured masters, servos."""
        self._masters = [self._commanded(m.name) for m in self.system.masters]
        for d in self.system.drives:
            if d.kind == "prescribed":
                x = self._references[d.name] = self._reference(d.name)
                i, k = self.program.driven(d)
                self.q[i], self.v[k] = x[0], x[1]
        for i, (tree, shared) in enumerate(self.program.instances):
            if shared.ends:
                out = shared.place(q=self.q[tree.q], v=self.v[tree.v], P=self.numbers("tree", str(i)))
                self._ends.update({tree.first + b: getattr(out, f"b{b}") for b in shared.ends})
        self._attitudes()
        self._masters += [self._measured(m) for m in self.system.measured]
        for d in self.system.drives:
            if d.kind != "prescribed":
                self._references[d.name] = self._reference(d.name)

    def _commanded(self, name: str) -> tuple[Any, Any, Any, Any, Any]:
        """s, ds/dt, d2s/dt2, sin s, cos s of a master."""
        x = self.program.profile(t=self._t, p=self.numbers("reference", name))
        s = named(f"s({name})", x.x[0])
        return s, named(f"ds({name})", x.v[0]), named(f"dds({name})", x.a[0]), sin(s), cos(s)

    def _attitudes(self) -> None:
        """The angles of bodies that are measured or watched."""
        for i, label in enumerate(self.program.angles):
            kind, body, axis = label
            if kind == "body":
                sine, cosine, rate = attitude(self._ends[self.graph.number(body)], axis)
                self.turned[label] = on_turn(atan2(sine, cosine), self.counted[i])
                self.turning[label] = rate / (sine * sine + cosine * cosine)

    def _measured(self, m: Measured) -> tuple[Any, Any, Any, Any, Any]:
        if m.kind == "joint":
            _, x, u = self._joint(m.name, m.of, m.coordinate)
            return named(f"s({m.name})", x), named(f"ds({m.name})", u), 0.0, sin(x), cos(x)
        label: Label = "body", m.of, m.axis
        sine, cosine, _ = attitude(self._ends[self.graph.number(m.of)], m.axis)
        n = 1.0 / sqrt(sine * sine + cosine * cosine)
        s, ds = named(f"s({m.name})", self.turned[label]), named(f"ds({m.name})", self.turning[label])
        return s, ds, 0.0, sine * n, cosine * n

    def _reference(self, name: str) -> Reference:
        """A profile plus f(s) of every master known so far: f = k1 s + kc cos s + ks sin s."""
        x = self.program.profile(t=self._t, p=self.numbers("reference", name))
        ref, dref, ddref = x.x[0], x.v[0], x.a[0]
        follow = self.numbers("follow", name)
        for i, (s, ds, dds, sine, cosine) in enumerate(self._masters):
            k1, kc, ks = follow[3 * i : 3 * i + 3]
            slope = k1 - kc * sine + ks * cosine
            ref = ref + k1 * s + kc * cosine + ks * sine
            dref = dref + slope * ds
            ddref = ddref + slope * dds - (kc * cosine + ks * sine) * ds * ds
        return named(f"s({name})", ref), named(f"ds({name})", dref), named(f"dds({name})", ddref)

    def _joint(self, law: str, joint: str, coordinate: str) -> tuple[int, Any, Any]:
        """Number of the degree of freedom, coordinate and velocity of what a law acts along."""
        i, k = self.graph.coordinate(law, joint, coordinate)
        return k, self.q[i], self.v[k]


def attitude(body: Any, axis: int) -> tuple[Any, Any, Any]:
    """sin, cos (not normalised) of the angle by which body axis w leans towards +y (axis 0, about -x) or +x (axis 1,
    about +y), and sin' cos - sin cos'."""
    w = np.reshape(body[:9], (3, 3))[:, 2]
    dw = cross(body[15:18], w)
    i = 1 if axis == 0 else 0
    return w[i], w[2], dw[i] * w[2] - w[i] * dw[2]
