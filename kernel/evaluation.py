"""The equations of a whole scene at one instant: places -> laws -> forces -> accelerations.

The one text that the float oracle runs and the tracer turns into machine code.  Each method is one stage; they run in
the order in which they stand.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from . import laws
from .constraints.rows import Rows
from .describe import Brake, Drive, Measured, RigidRope, Stop, Threshold
from .elementary import atan2, cos, sin
from .forces.describe import Reeving, Signal
from .spatial import cross, join
from .symbol import named, scope, sqrt

if TYPE_CHECKING:
    from .rate import Program

__all__ = ["Evaluation"]

GROUND = np.concatenate([np.eye(3).ravel(), np.zeros(12)])
Reference = tuple[Any, Any, Any]  # value, rate, acceleration


class Evaluation:
    """`dy`, `tensions`, `guards` and what samples show, at time t [s], state y, parameters P.

    Without `forces` nothing is known but where the bodies are and how they move.
    """

    def __init__(self, program: Program, t: Any, y: Any, P: Any, inside: Any, forces: bool = True) -> None:
        self.program, self.system, self.graph, self._P = program, program.system, program.graph, P
        self._t = [t, inside]
        nq, nv = program.nq, program.nv
        self.q, self.v = list(y[:nq]), list(y[nq : nq + nv])
        self.accounts = list(y[nq + nv :])
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
        self._heat: list[Any] = []
        self._work: list[Any] = []
        self._ends: dict[int, Any] = {-1: GROUND}
        self._wrenches: list[Any] = [np.zeros(6) for _ in self.graph.links]
        self._tau: list[Any] = [0.0] * nv
        self._masters: list[tuple[Any, Any, Any, Any, Any]] = []
        self._references: dict[str, Reference] = {}
        self._drive_work: dict[str, Any] = {}
        self.loads: Callable[[], list[Any]] = list  # of the joints that close loops
        self.lengths_of: dict[str, Reference] = {}  # of rigid ropes
        self._held: Rows | None = None
        self.pressing: list[Any] = []  # normal force per contact
        self._follow_and_place()
        if not forces:
            return
        self._ropes()
        self._supports()
        self._joints()
        self._forces()
        self._modes()
        self._accelerate()
        self._thresholds()

    def numbers(self, kind: str, name: str) -> Any:
        """Its part of the parameters P."""
        return self._P[self.program.parameters.at[kind, name]]

    @property
    def ends(self) -> dict[int, Any]:
        """(21,) R, o, r, V of every body that a law acts on, by its number."""
        return self._ends

    @property
    def pulls(self) -> list[Any]:
        """Tensions of all ropes of straight lines, the rigid ones last [N]."""
        return [*self.tensions, *(self._held.tensions.values() if self._held else ())]

    @property
    def gravity(self) -> Any:
        return self.numbers("gravity", "")[0]

    @property
    def wrenches(self) -> list[Any]:
        """(6,) per link: what laws do to each body, about its tree's point."""
        return self._wrenches

    # ---- references, then places -------------------------------------------------------------------------

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
        self._masters += [self._measured(m) for m in self.system.measured]
        for d in self.system.drives:
            if d.kind != "prescribed":
                self._references[d.name] = self._reference(d.name)

    def _commanded(self, name: str) -> tuple[Any, Any, Any, Any, Any]:
        """s, ds/dt, d2s/dt2, sin s, cos s of a master."""
        x = self.program.profile(t=self._t, p=self.numbers("reference", name))
        s = named(f"s({name})", x.x[0])
        return s, named(f"ds({name})", x.v[0]), named(f"dds({name})", x.a[0]), sin(s), cos(s)

    def _measured(self, m: Measured) -> tuple[Any, Any, Any, Any, Any]:
        if m.kind == "joint":
            _, x, u = self._joint(m.name, m.of, m.coordinate)
            return named(f"s({m.name})", x), named(f"ds({m.name})", u), 0.0, sin(x), cos(x)
        sine, cosine, rate = attitude(self._ends[self.graph.number(m.of)], m.axis)
        square = sine * sine + cosine * cosine
        n = 1.0 / sqrt(square)
        s, ds = named(f"s({m.name})", atan2(sine, cosine)), named(f"ds({m.name})", rate / square)
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

    # ---- laws --------------------------------------------------------------------------------------------

    def _push(self, body: int, wrench: Any) -> None:
        if body >= 0:
            self._wrenches[body] = self._wrenches[body] + wrench

    def _joint(self, law: str, joint: str, coordinate: str) -> tuple[int, Any, Any]:
        """Number of the degree of freedom, coordinate and velocity of what a law acts along."""
        i, k = self.graph.coordinate(law, joint, coordinate)
        return k, self.q[i], self.v[k]

    def _ropes(self) -> None:
        for r in self.system.ropes:
            L0, dL0 = self.numbers("reference", r.name)[1], 0.0
            if r.winch:
                L0, dL0, _ = self._reference(r.name)
            bodies = [(self.graph.number(line.a.body), self.graph.number(line.b.body)) for line in r.lines]
            ends = {f"{e}{n}": self._ends[i] for n, ab in enumerate(bodies) for e, i in zip("ab", ab, strict=True)}
            with scope(r.name):
                x = self.program.ropes[len(r.lines)](L=[L0, dL0], p=self.numbers("rope", r.name), **ends)
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
            with scope(x.name):
                out = x.function(**blocks)
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
        yield from (("brake", b, laws.brake) for b in self.system.brakes)

    # ---- accelerations and guards ------------------------------------------------------------------------

    def _modes(self) -> None:
        """Elasticity and damping of flexible bodies, mode by mode."""
        for link in self.graph.links:
            if not link.n_modes:
                continue
            stiffness, damping = np.reshape(self.numbers("modes", link.body.name), (2, link.n_modes))
            x, u = np.array(self.q[link.q_modes]), np.array(self.v[link.v_modes])
            self._tau[link.v_modes] = list(-stiffness * x - damping * u)
            self._heat.append(damping @ (u * u))
            self.stored.append(0.5 * (stiffness @ (x * x)))

    def _accelerate(self) -> None:
        dq: list[Any] = []
        dv: list[Any] = []
        rows = self._held = self.constraint_rows() if len(self.program.constraints) else None
        if rows:
            rows.accelerate()
            self.loads = rows.loads
            self.guards += rows.guards()
            self._contacts(rows)
        for i, (_, shared) in enumerate(self.program.instances):
            drives = self._prescribed(i)
            x = rows.motion(i) if rows and shared.opened else shared.accelerate(**self._arguments(i))
            dq += list(x.dq)
            dv += list(x.dv)
            for d, force in zip(drives, x.reaction, strict=False):
                if d:  # it carries what the other laws of its joint do not
                    self._drive_work[d.name] = force * self._references[d.name][1]
        self._heat += [0.0 for _ in self.system.rigid_ropes]  # made at once, see `constraints.ropes`
        self.stored += [0.0 for _ in self.system.rigid_ropes]
        self._heat += [0.0 for _ in self.system.locks]  # made at once, see `locking`
        for body, wrench in rows.wrenches() if rows else ():
            self._push(body, wrench)
        self._work += [self._drive_work[d.name] for d in self.system.drives]
        for r in self.system.rigid_ropes:
            if r.winch and rows:
                self._work.append(-rows.tensions[r.name] * self.lengths_of[r.name][1])
        self.dy = join(dq, dv, self._heat, self._work)

    def _contacts(self, rows: Rows) -> None:
        contacts = self.program.contacts
        first = len(rows.rows) - len(contacts.held)
        guards, heat, self.pressing = contacts.loads(rows.slots, rows.multipliers[first:])
        self.guards += contacts.watched(self.numbers, self._ends) + guards
        self._heat += heat
        self.stored += [0.0 for _ in heat]

    def _prescribed(self, i: int) -> list[Drive | None]:
        """Drives that prescribe degrees of freedom of a tree, in their order; None: locked."""
        drives = {self.program.driven(d)[1]: d for d in self.system.drives if d.kind == "prescribed"}
        tree = self.program.instances[i][0]
        return [drives.get(tree.v.start + k) for k in tree.prescribed_dofs]

    def _arguments(self, i: int) -> dict[str, Any]:
        """What the motion of the i-th tree depends on."""
        tree, shared = self.program.instances[i]
        return {
            "q": self.q[tree.q],
            "v": self.v[tree.v],
            "tau": self._tau[tree.v] or [0.0],
            "P": self.numbers("tree", str(i)),
            "g": [self.gravity],
            "a": [self._references[d.name][2] if d else 0.0 for d in self._prescribed(i)] or [0.0],
            **{f"w{b}": self._wrenches[tree.first + b] for b in shared.ends},
        }

    def length_of(self, r: RigidRope) -> Reference:
        """Of a rigid rope, with two rates."""
        return self._reference(r.name) if r.winch else (self.numbers("reference", r.name)[1], 0.0, 0.0)

    def constraint_rows(self) -> Rows:
        """The constraint rows under the forces known so far; those of the accelerations once these are known."""
        if self._held:
            return self._held
        arguments = {i: self._arguments(i) for i in self.program.constraints.linked}
        for r in self.system.rigid_ropes:
            self.lengths_of[r.name] = self.length_of(r)
        return Rows(self.program, arguments, self._ends, self.numbers, self.lengths_of)

    def _thresholds(self) -> None:
        self.guards += [self._threshold(h) for h in self.system.thresholds]

    def _threshold(self, h: Threshold) -> Any:
        """a x + b, for angles a sin + a2 cos + b; Python sets a, a2, b when a threshold is armed."""
        p = self.numbers("threshold", h.name)
        a, a2, b = p[:3]
        if h.quantity == "angle":
            sine, cosine, _ = attitude(self._ends[self.graph.number(h.of)], h.axis)
            return a * sine + a2 * cosine + b
        ropes = zip(self.system.ropes, self.tensions, self.lengths, strict=True)
        known = {r.name: (tension, length) for r, tension, length in ropes} | self._reeved
        if self._held:
            known |= {r: (tension, self.lengths_of[r][0]) for r, tension in self._held.tensions.items()}
        if h.quantity == "height":
            assert h.point is not None, "checked by the program"
            x = laws.attachment(self._ends[self.graph.number(h.point.body)], p[3:6])[1][2]
        elif h.quantity == "tension":
            x = sum((known[r][0] for r in h.ropes), 0.0)
        elif h.quantity == "length":
            x = known[h.ropes[0]][1]
        else:
            x = self._joint(h.name, h.of, h.coordinate)[1 if h.quantity == "joint" else 2]
        return a * x + b

    # ---- for samples -------------------------------------------------------------------------------------

    def poses_and_energies(self) -> tuple[list[Any], Any, Any]:
        """Origin and rotation of every body (12 numbers each), kinetic and gravitational energy [J]."""
        poses: list[Any] = []
        kinetic: Any = 0.0
        potential: Any = 0.0
        for i, (tree, shared) in enumerate(self.program.instances):
            numbers = self.numbers("tree", str(i))
            x = shared.pose(q=self.q[tree.q], v=self.v[tree.v], P=numbers, g=[self.gravity])
            poses += list(x.poses)
            kinetic, potential = kinetic + x.energy[0], potential + x.energy[1]
        return poses, kinetic, potential


def attitude(body: Any, axis: int) -> tuple[Any, Any, Any]:
    """sin, cos (not normalised) of the angle by which body axis w leans towards +y (axis 0, about -x) or +x (axis 1,
    about +y), and sin' cos - sin cos'."""
    w = np.reshape(body[:9], (3, 3))[:, 2]
    dw = cross(body[15:18], w)
    i = 1 if axis == 0 else 0
    return w[i], w[2], dw[i] * w[2] - w[i] * dw[2]
