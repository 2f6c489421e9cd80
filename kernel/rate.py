"""The right-hand side of a whole scene: laws -> forces -> accelerations, with guards, tensions and powers.

State y = [q, v, w]: coordinates, velocities, and one integral per law of the work it takes or the heat it makes.
Equal trees and equal laws are one traced function each, called for every instance with its own numbers: code stays
small however large the yard.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from . import laws
from .describe import System
from .dynamics import dynamics, energies, kinematics
from .errors import KernelError
from .graph import build_graph
from .joints import JOINTS
from .parameters import PROFILE, ROPE_HEAD, ROPE_LINE, Parameters
from .spatial import cross, join
from .symbol import Function, atan2, cos, named, sin, sqrt
from .trees import cut, kind_of, numbers, with_numbers

__all__ = ["Program"]

END = 21  # numbers that describe a body to a law: R, o, r, V
GROUND = np.concatenate([np.eye(3).ravel(), np.zeros(12)])
SINGLE = ("revolute", "prismatic")


class Program:
    """A compiled description: layout of state, parameters, guards and accounts, and the text of its equations.

    Raises KernelError if a law names a body, joint or rope that is not there, or two drives share a joint.
    """

    def __init__(self, system: System) -> None:
        self.system = system
        self.graph = build_graph(system)
        prescribed = {d.joint for d in system.drives if d.kind == "prescribed"}
        self.trees = cut(self.graph, prescribed)
        self.parameters = Parameters.of(system, self.trees)
        self.nq, self.nv = self.graph.nq, self.graph.nv
        self._check()
        laws_ = (system.ropes, system.supports, system.springs, system.stops, system.brakes)
        self.accounts = [("heat", x.name) for group in laws_ for x in group]
        self.accounts += [("work", r.name) for r in system.ropes if r.winch] + [("work", d.name) for d in system.drives]
        self.guards = [("rope", r.name) for r in system.ropes]
        self.guards += [(what, s.name) for s in system.supports for what in ("support", "rub")]
        self.guards += [(what, s.name) for s in system.stops for what in ("lower", "upper")]
        self.guards += [("brake", b.name) for b in system.brakes] + [("threshold", h.name) for h in system.thresholds]
        self.stored = [("stored", x.name) for group in laws_ for x in group]
        self.ny = self.nq + self.nv + len(self.accounts)
        self.quaternions = [
            k.q.start + start for k in self.graph.links if (start := JOINTS[k.joint.kind].quaternion) is not None
        ]
        self._functions()

    def _check(self) -> None:
        s = self.system
        driven: dict[str, str] = {}
        for law in (*s.springs, *s.stops, *s.brakes, *s.drives):
            link = self.graph.joint(law.joint)
            if link.joint.kind not in SINGLE:
                raise KernelError(f"'{law.name}': joint '{law.joint}' is {link.joint.kind}; it must be one of {SINGLE}")
        for d in s.drives:
            if d.joint in driven:
                raise KernelError(f"drive '{d.name}': joint '{d.joint}' already has the drive '{driven[d.joint]}'")
            driven[d.joint] = d.name
        points = [(r.name, p) for r in s.ropes for line in r.lines for p in (line.a, line.b)]
        points += [(u.name, u.point) for u in s.supports]
        points += [(h.name, h.point) for h in s.thresholds if h.point]
        for name, p in points:
            if p.body != "world" and p.body not in {b.name for b in s.bodies}:
                raise KernelError(f"'{name}': there is no body '{p.body}'")

    def initial_state(self) -> np.ndarray:
        """(ny,) state at the start of a run."""
        y = np.zeros(self.ny)
        for k in self.graph.links:
            y[k.q] = k.joint.q0 or JOINTS[k.joint.kind].rest
            y[self.nq + k.v.start : self.nq + k.v.stop] = k.joint.v0 or (0.0,) * (k.v.stop - k.v.start)
        return y

    # ---- functions shared by equal parts ------------------------------------------------------------------

    def _functions(self) -> None:
        s, number = self.system, self.graph.number
        used = {number(p.body) for r in s.ropes for line in r.lines for p in (line.a, line.b)}
        used |= {number(u.point.body) for u in s.supports} | {number(m.of) for m in s.measured if m.kind == "angle"}
        used |= {number(h.point.body) for h in s.thresholds if h.point}
        used |= {number(h.of) for h in s.thresholds if h.quantity == "angle"}
        self.ends_of_tree = [[i for i in range(len(t.bodies)) if t.first + i in used] for t in self.trees]
        kinds: dict[str, tuple[Function, Function, Function]] = {}
        self.tree_functions = []
        for t, ends in zip(self.trees, self.ends_of_tree, strict=True):
            key = kind_of(t) + str(ends)
            if key not in kinds:
                kinds[key] = _tree_functions(len(kinds), t, ends)
            self.tree_functions.append(kinds[key])
        self.f_profile = Function(
            "profile", lambda t, p: dict(zip("xva", map(_one, laws.profile(t[0], p)), strict=True)), {"t": 1, "p": PROFILE}
        )
        self.f_rope = {n: _rope_function(n) for n in {len(r.lines) for r in s.ropes}}
        self.f_support = Function(
            "support",
            lambda p, body: {k: _one(v) for k, v in vars(laws.support(p, body)).items()},
            {"p": 15, "body": END},
        )

    # ---- the text -----------------------------------------------------------------------------------------

    def evaluate(self, t: Any, y: Any, P: Any) -> SimpleNamespace:
        """Every law and acceleration at time t [s]: the one place where the scene's equations stand."""
        s = self.system
        part = self.parameters.at
        num = lambda kind, name: P[part[kind, name]]  # noqa: E731
        g = num("gravity", "")[0]
        q, v = list(y[: self.nq]), list(y[self.nq : self.nq + self.nv])
        masters = [self._commanded(t, num("reference", m.name)) for m in s.masters]
        ends: dict[int, Any] = {-1: GROUND}

        def place(trees: range) -> None:
            for i in trees:
                tree, (f_ends, _, _) = self.trees[i], self.tree_functions[i]
                if self.ends_of_tree[i]:
                    out = f_ends(q=q[tree.q], v=v[tree.v], P=num("tree", str(i)))
                    ends.update({tree.first + b: getattr(out, f"b{b}") for b in self.ends_of_tree[i]})

        prescribed = {self.graph.joint(d.joint).body.name: d for d in s.drives if d.kind == "prescribed"}
        references: dict[str, tuple[Any, Any, Any]] = {}
        if s.measured:  # what is measured cannot depend on joints that follow it: prescribed ones follow masters only
            for d in prescribed.values():
                references[d.name] = self._prescribe(d, t, masters, num, q, v)
            place(range(len(self.trees)))
            masters += [self._measured(m, q, v, ends) for m in s.measured]
        for d in s.drives:
            if d.name not in references:
                references[d.name] = (
                    self._prescribe(d, t, masters, num, q, v)
                    if d.kind == "prescribed"
                    else self._reference(t, masters, num("reference", d.name), num("follow", d.name))
                )
        if not s.measured:
            place(range(len(self.trees)))
        out = SimpleNamespace(tensions=[], elongations=[], lengths=[], length_rates=[], guards=[])
        out.normals, out.places, out.velocities = [], [], []
        heat: list[Any] = []
        work: list[Any] = []
        stored: list[Any] = []
        W: list[Any] = [np.zeros(6) for _ in self.graph.links]
        tau: list[Any] = [0.0] * self.nv

        def push(body: int, wrench: Any) -> None:
            if body >= 0:
                W[body] = W[body] + wrench

        for r in s.ropes:
            L0, dL0 = num("reference", r.name)[1], 0.0
            if r.winch:
                L0, dL0, _ = self._reference(t, masters, num("reference", r.name), num("follow", r.name))
            numbers_ = [(self.graph.number(line.a.body), self.graph.number(line.b.body)) for line in r.lines]
            blocks = {f"{e}{n}": ends[i] for n, ab in enumerate(numbers_) for e, i in zip("ab", ab, strict=True)}
            x = self.f_rope[len(r.lines)](L=[L0, dL0], p=num("rope", r.name), **blocks)
            out.tensions.append(named(f"T({r.name})", x.tension[0]))
            out.elongations.append(x.elongation[0])
            out.lengths.append(L0)
            out.length_rates.append(dL0)
            out.guards.append(x.guard[0])
            heat.append(x.heat[0])
            stored.append(x.stored[0])
            if r.winch:
                work.append(x.work[0])
            for n, (a, b) in enumerate(numbers_):
                push(a, getattr(x, f"wa{n}"))
                push(b, getattr(x, f"wb{n}"))
        for u in s.supports:
            body = self.graph.number(u.point.body)
            x = self.f_support(p=num("support", u.name), body=ends[body])
            push(body, x.wrench)
            out.normals.append(x.normal[0])
            out.places += list(x.place)
            out.velocities += list(x.velocity)
            out.guards += list(x.guards)
            heat.append(x.heat[0])
            stored.append(x.stored[0])

        def joint(name: str) -> tuple[int, Any, Any]:
            link = self.graph.joint(name)
            return link.v.start, q[link.q.start], v[link.v.start]

        for c in s.springs:
            (k, x, u_), (stiff, damp, rest) = joint(c.joint), num("spring", c.name)
            tau[k] = tau[k] + stiff * (rest - x) - damp * u_
            heat.append(damp * u_ * u_)
            stored.append(0.5 * stiff * (rest - x) * (rest - x))
        for kind, law, group in (("stop", laws.stop, s.stops), ("brake", laws.brake, s.brakes)):
            for e in group:
                k, x, u_ = joint(e.joint)
                f = law(num(kind, e.name), x, u_)
                tau[k] = tau[k] + f.force
                out.guards += f.guards
                heat.append(f.heat)
                stored.append(f.stored)
        drive_work: dict[str, Any] = {}
        for d in s.drives:
            if d.kind != "prescribed":
                k, x, u_ = joint(d.joint)
                force = laws.drive(d.kind, num("drive", d.name), references[d.name], x, u_)
                tau[k] = tau[k] + force
                drive_work[d.name] = force * u_
        dq: list[Any] = []
        dv: list[Any] = []
        for i, tree in enumerate(self.trees):
            _, f_dynamics, _ = self.tree_functions[i]
            own = [d for b in tree.bodies if (d := prescribed.get(b.name))]
            blocks = {f"w{b}": W[tree.first + b] for b in self.ends_of_tree[i]}
            blocks["a"] = [references[d.name][2] for d in own] or [0.0]
            x = f_dynamics(
                q=q[tree.q], v=v[tree.v], tau=tau[tree.v] or [0.0], P=num("tree", str(i)), g=[g], **blocks
            )
            dq += list(x.dq)
            dv += list(x.dv)
            for d, force in zip(own, x.reaction, strict=False):
                drive_work[d.name] = (force - tau[self.graph.joint(d.joint).v.start]) * references[d.name][1]
        work += [drive_work[d.name] for d in s.drives]
        out.guards += [self._threshold(h, num("threshold", h.name), out, ends, joint) for h in s.thresholds]
        out.dy = join(dq, dv, heat, work) if self.ny else np.zeros(0)
        out.stored, out.q, out.v, out.accounts = stored, q, v, list(y[self.nq + self.nv :])
        return out

    def observe(self, t: Any, y: Any, P: Any) -> SimpleNamespace:
        """What a sample row shows: see `kernel.samples`."""
        x = self.evaluate(t, y, P)
        g = P[self.parameters.at["gravity", ""]][0]
        poses: list[Any] = []
        kinetic: Any = 0.0
        potential: Any = 0.0
        for i, tree in enumerate(self.trees):
            out = self.tree_functions[i][2](q=x.q[tree.q], v=x.v[tree.v], P=P[self.parameters.at["tree", str(i)]], g=[g])
            poses += list(out.poses)  # 12 numbers a body: origin, rotation
            kinetic, potential = kinetic + out.energy[0], potential + out.energy[1]
        x.poses, x.kinetic, x.potential = poses, kinetic, potential
        return x

    # ---- references ---------------------------------------------------------------------------------------

    def _commanded(self, t: Any, p: Any) -> tuple[Any, Any, Any, Any, Any]:
        """s, ds/dt, d2s/dt2, sin s, cos s of a master."""
        x = self.f_profile(t=[t], p=p)
        return x.x[0], x.v[0], x.a[0], sin(x.x[0]), cos(x.x[0])

    def _measured(self, m: Any, q: Any, v: Any, ends: Any) -> tuple[Any, Any, Any, Any, Any]:
        if m.kind == "joint":
            link = self.graph.joint(m.of)
            x = q[link.q.start]
            return x, v[link.v.start], 0.0, sin(x), cos(x)
        sine, cosine, rate = attitude(ends[self.graph.number(m.of)], m.axis)
        n2 = sine * sine + cosine * cosine
        n = 1.0 / sqrt(n2)
        return atan2(sine, cosine), rate / n2, 0.0, sine * n, cosine * n

    def _reference(self, t: Any, masters: Any, p: Any, follow: Any) -> tuple[Any, Any, Any]:
        """A profile plus f(s) of every master followed: f = k1 s + kc cos s + ks sin s."""
        x = self.f_profile(t=[t], p=p)
        ref, dref, ddref = x.x[0], x.v[0], x.a[0]
        for i, (s, ds, dds, sine, cosine) in enumerate(masters):
            k1, kc, ks = follow[3 * i : 3 * i + 3]
            slope = k1 - kc * sine + ks * cosine
            ref = ref + k1 * s + kc * cosine + ks * sine
            dref = dref + slope * ds
            ddref = ddref + slope * dds - (kc * cosine + ks * sine) * ds * ds
        return ref, dref, ddref

    def _prescribe(self, d: Any, t: Any, masters: Any, num: Any, q: list[Any], v: list[Any]) -> tuple[Any, Any, Any]:
        """A rheonomic joint: coordinate and velocity are the reference itself."""
        x = self._reference(t, masters, num("reference", d.name), num("follow", d.name))
        link = self.graph.joint(d.joint)
        q[link.q.start], v[link.v.start] = x[0], x[1]
        return x

    def _threshold(self, h: Any, p: Any, out: Any, ends: Any, joint: Any) -> Any:
        """a x + b, for angles a sin + a2 cos + b; Python sets a, a2, b when a threshold is armed."""
        a, a2, b = p[:3]
        if h.quantity == "angle":
            sine, cosine, _ = attitude(ends[self.graph.number(h.of)], h.axis)
            return a * sine + a2 * cosine + b
        names = [r.name for r in self.system.ropes]
        if h.quantity == "height":
            x = laws.attachment(ends[self.graph.number(h.point.body)], p[3:6])[1][2]
        elif h.quantity == "tension":
            x = sum((out.tensions[names.index(r)] for r in h.ropes), 0.0)
        elif h.quantity == "length":
            x = out.lengths[names.index(h.ropes[0])]
        else:
            x = joint(h.of)[1 if h.quantity == "joint" else 2]
        return a * x + b


def attitude(body: Any, axis: int) -> tuple[Any, Any, Any]:
    """sin, cos (not normalised) and their cross rate of the angle by which body axis w leans towards +y (axis 0, about
    -x) or towards +x (axis 1, about +y); rate = sin' cos - sin cos'."""
    w = np.reshape(body[:9], (3, 3))[:, 2]
    dw = cross(body[15:18], w)
    i = 1 if axis == 0 else 0
    return w[i], w[2], dw[i] * w[2] - w[i] * dw[2]


def _one(x: Any) -> Any:
    return x if isinstance(x, list | np.ndarray) else [x]


def _rope_function(n: int) -> Function:
    def body(L: Any, p: Any, **ends: Any) -> dict[str, Any]:
        x = laws.rope(p, L[0], L[1], [(ends[f"a{i}"], ends[f"b{i}"]) for i in range(n)])
        out = {f"w{e}{i}": w for i, ab in enumerate(x.wrenches) for e, w in zip("ab", ab, strict=True)}
        names = ("tension", "elongation", "guard", "heat", "work", "stored")
        return {**{k: [getattr(x, k)] for k in names}, **out}

    blocks = {f"{e}{i}": END for i in range(n) for e in "ab"}
    return Function(f"rope{n}", body, {"L": 2, "p": ROPE_HEAD + ROPE_LINE * n, **blocks})


def _tree_functions(k: int, tree: Any, ends: list[int]) -> tuple[Function, Function, Function]:
    """Placement of the bodies that laws act on, accelerations, and poses with energies of one kind of tree."""
    nq, nv, n = tree.q.stop - tree.q.start, tree.v.stop - tree.v.start, len(numbers(tree))
    state = {"q": nq, "v": nv, "P": n}

    def place(q: Any, v: Any, P: Any) -> dict[str, Any]:
        K = kinematics(with_numbers(tree, P), q, v, 0.0, [0.0] * len(tree.prescribed_dofs))
        return {f"b{i}": join(K.R[i].ravel(), K.o, K.r[i], K.V[i]) for i in ends}

    def accelerate(q: Any, v: Any, tau: Any, P: Any, g: Any, a: Any, **w: Any) -> dict[str, Any]:
        W = [w.get(f"w{i}", np.zeros(6)) for i in range(len(tree.bodies))]
        a_ref = list(a)[: len(tree.prescribed_dofs)]
        dq, dv, reaction = dynamics(with_numbers(tree, P), q, v, tau, W, g[0], a_ref)
        return {"dq": dq, "dv": dv, "reaction": reaction}

    def pose(q: Any, v: Any, P: Any, g: Any) -> dict[str, Any]:
        t = with_numbers(tree, P)
        K = kinematics(t, q, v, 0.0, [0.0] * len(tree.prescribed_dofs))
        return {
            "poses": [join(K.o + K.r[i], K.R[i].ravel()) for i in range(len(t.bodies))],
            "energy": list(energies(t, K, g[0])),
        }

    wrenches = {f"w{i}": 6 for i in ends}
    size_a = max(1, len(tree.prescribed_dofs))
    return (
        Function(f"place{k}", place, state),
        Function(f"accelerate{k}", accelerate, {**state, "tau": max(1, nv), "g": 1, "a": size_a, **wrenches}),
        Function(f"pose{k}", pose, {**state, "g": 1}),
    )
