"""The second stage of an evaluation: the laws, which push bodies and joints and say when they change their state.

Every law reports its force, the guards of its state, what it turns into heat, what it stores and, where it is driven,
its work; so the energy accounts of a scene stay closed.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
from heavylift.kernel.compiler.symbol import named, scope
from heavylift.kernel.constraints.rigid_ropes import RigidAt
from heavylift.kernel.description.forces import Reeving, Signal
from heavylift.kernel.description.mechanics import Brake, Stop
from heavylift.kernel.forces import laws
from heavylift.kernel.forces.rope_mass import not_weighed, pulls_down

from .poses import Placing
from .program import Program

__all__ = ["Applying"]


class Applying(Placing):
    """The forces of all laws but constraint rows; without `forces` none of them is asked."""

    def __init__(self, program: Program, t: Any, y: Any, P: Any, inside: Any, forces: bool = True) -> None:
        self.tensions: list[Any] = []
        self.elongations: list[Any] = []
        self.lengths: list[Any] = []
        self.length_rates: list[Any] = []
        self.normals: list[Any] = []
        self.shown: list[Any] = []
        self._reeved: dict[str, tuple[Any, Any]] = {}  # tension of the first part and unstretched length
        self.places: list[Any] = []
        self.velocities: list[Any] = []
        self.guards: list[Any] = []
        self.stored: list[Any] = []
        self._own: dict[str, Any] = {}  # potential energy of what rigid ropes weigh and their ends do not
        self._heat: list[Any] = []
        self._work: list[Any] = []
        self._drive_work: dict[str, Any] = {}
        super().__init__(program, t, y, P, inside)
        self._wrenches: list[Any] = [np.zeros(6) for _ in self.graph.links]
        self._tau: list[Any] = [0.0] * program.nv
        if forces:
            self._ropes()
            self._rigid_weights()
            self._supports()
            self._joints()
            self._forces()
            self._modes()

    @property
    def wrenches(self) -> list[Any]:
        """(6,) per link: what laws do to each body, about its tree's point."""
        return self._wrenches

    def _push(self, body: int, wrench: Any) -> None:
        if body >= 0:
            self._wrenches[body] = self._wrenches[body] + wrench

    def _ropes(self) -> None:
        for r in self.system.ropes:
            L0, dL0 = self.numbers("reference", r.name)[1], 0.0
            if r.winch:
                L0, dL0, _ = self._reference(r.name)
            bodies = [(self.graph.number(line.a.body), self.graph.number(line.b.body)) for line in r.lines]
            ends = {f"{e}{n}": self._ends[i] for n, ab in enumerate(bodies) for e, i in zip("ab", ab, strict=True)}
            with scope(r.name):
                law = self.program.ropes[len(r.lines), r.name in self.program.calm, bool(r.mass)]
                x = law(L=[L0, dL0], p=self.numbers("rope", r.name), **ends)
            self.tensions.append(x.tension[0])
            self.elongations.append(x.elongation[0])
            self.lengths.append(L0)
            self.length_rates.append(dL0)
            self.guards.append(x.guard[0])
            self._heat.append(x.heat[0])
            self.stored.append(x.stored[0])
            if r.winch:
                self._work.append(x.work[0])
            for n, (a, b) in enumerate(bodies):
                self._push(a, getattr(x, f"wa{n}"))
                self._push(b, getattr(x, f"wb{n}"))

    def _rigid_weights(self) -> None:
        """What rigid ropes weigh and their ends do not."""
        for r in self.system.rigid_ropes:
            self._own[r.name] = 0.0
            if r.mass:
                weight, p = self.numbers("weight", r.name)[0], self.numbers("rigid", r.name)
                for n, line in enumerate(r.lines):
                    q = p[RigidAt.LINES + 7 * n :]
                    for end, p_BX in ((line.a, q[:3]), (line.b, q[3:6])):
                        body = self.graph.number(end.body)
                        x, place, _ = laws.attachment(self._ends[body], p_BX)
                        self._push(body, pulls_down(q[6] * weight, x))
                        self._own[r.name] = self._own[r.name] + not_weighed(q[6] * weight) * place[2]

    def _supports(self) -> None:
        for u in self.system.supports:
            body = self.graph.number(u.point.body)
            with scope(u.name):
                x = self.program.support(p=self.numbers("support", u.name), body=self._ends[body])
            self._push(body, x.wrench)
            self.normals.append(x.normal[0])
            self.places += list(x.place)
            self.velocities += list(x.velocity)
            self.guards += list(x.guards)
            self._heat.append(x.heat[0])
            self.stored.append(x.stored[0])

    def _joints(self) -> None:
        """Springs, stops, brakes and drives: forces along one degree of freedom."""
        for c in self.system.springs:
            (k, x, u), (stiff, damp, rest) = self._joint(c.name, c.joint, c.coordinate), self.numbers("spring", c.name)
            self._tau[k] = self._tau[k] + stiff * (rest - x) - damp * u
            self._heat.append(damp * u * u)
            self.stored.append(0.5 * stiff * (rest - x) * (rest - x))
        for kind, given, law in self._unilateral():
            k, x, u = self._joint(given.name, given.joint, given.coordinate)
            f = law(self.numbers(kind, given.name), x, u)
            self._tau[k] = self._tau[k] + named(f"tau({given.name})", f.force)
            self.guards += f.guards
            self._heat.append(f.heat)
            self.stored.append(f.stored)
        for d in self.system.drives:
            if d.kind != "prescribed":
                k, x, u = self._joint(d.name, d.joint, d.coordinate)
                force = laws.drive(d.kind, self.numbers("drive", d.name), self._references[d.name], x, u)
                force = named(f"tau({d.name})", force)
                self._tau[k] = self._tau[k] + force
                self._drive_work[d.name] = force * u

    def _forces(self) -> None:
        """Every force of the force table."""
        for x in self.program.forces:
            blocks = {"p": self.numbers("force", x.name), **{f"e{i}": self._ends[b] for i, b in enumerate(x.ends)}}
            along, signal = x.force.along, x.law.signal(x.force)
            if signal:
                blocks["s"] = self._signal(x.name, signal)
            if along:
                k, *blocks["x"] = self._joint(x.name, *along)
            if x.law.timed:
                blocks["t"] = [self.numbers("clock", "")[0] + self._t[0]]
            labels = [("force", x.name, i) for i in range(x.angles)]
            if labels:
                first = self.program.angles.index(labels[0])
                blocks["c"] = self.counted[first : first + len(labels)]
            with scope(x.name):
                out = x.function(**blocks)
            self.turned |= dict(zip(labels, out.turned, strict=True))
            self.turning |= dict(zip(labels, out.turning, strict=True))
            for i, body in enumerate(x.ends):
                self._push(body, named(f"F({x.name},{i + 1})", getattr(out, f"w{i}")))
            if along:
                self._tau[k] = self._tau[k] + named(f"F({x.name})", out.effort[0])
            self.guards += list(out.guards)
            self.shown += list(out.shown)
            if isinstance(x.force, Reeving):
                self._reeved[x.name] = (out.shown[0], blocks["s"][0])
            self._heat.append(out.heat[0])
            self.stored.append(out.stored[0])
            if x.law.works:
                self._work.append(out.work[0])

    def _signal(self, name: str, signal: Signal) -> list[Any]:
        """Value and rate of a force's signal: commanded, from its history's active piece, or constant."""
        if signal.driven:
            return list(self._reference(name)[:2])
        start, value, slope = self.numbers("signal", name)
        return [value + slope * (self._t[0] - start), slope] if signal.times else [value, 0.0]

    def _unilateral(self) -> Iterator[tuple[str, Stop | Brake, Any]]:
        stop = partial(laws.stop, clamped=self.program.clamped)
        yield from (("stop", s, stop) for s in self.system.stops)
        brake = partial(laws.brake, at_rest=self.program.at_rest)
        yield from (("brake", b, brake) for b in self.system.brakes)

    def _modes(self) -> None:
        """Elasticity and damping of flexible bodies, mode by mode."""
        for link in self.graph.links:
            if not link.n_modes:
                continue
            stiffness, damping = np.reshape(self.numbers("modes", link.body.name), (2, link.n_modes))
            x, u = np.array(self.q[link.q_modes]), np.array(self.v[link.v_modes])
            self._tau[link.v_modes] = list(-stiffness * x - damping * u)
            if link.modes:
                self.guards.append(link.modes.smallness.guard(self.numbers("bending", link.body.name), x))
            self._heat.append(damping @ (u * u))
            self.stored.append(0.5 * (stiffness @ (x * x)))
