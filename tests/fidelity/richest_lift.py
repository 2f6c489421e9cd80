"""A lift on the richest rung in code of its own: maximal coordinates, NumPy, SciPy's Radau; nothing of the kernel.

Every loader is two rigid bodies with Lagrange multipliers at their hinge, every hook rope a chain of lumps (x, y, z and
yaw), the girder its first mode with what it carries, trolleys and gantries masses on servos, stools springs that only
push.  It plays the action list itself.  Numbers (masses, lengths, speeds) come from the plan; equations do not.

    richest(plan, rtol=1e-6) -> History: times, hook tensions, block positions, when each action ended
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import pi, sqrt

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.integrate import Radau

BAUMGARTE = 20.0  # [1/s] at which a hinge that has drifted comes back
TINY = 1e-12
INSIDE = np.array([0.2, 0.4, 0.6, 0.8])  # where peaks are looked for within a step


@dataclass
class History:
    """What one run showed at the ends of all steps."""

    hooks: list[str]
    times: list[float] = field(default_factory=list)
    tensions: list[np.ndarray] = field(default_factory=list)
    places: list[np.ndarray] = field(default_factory=list)  # of the middle of the block
    ended: list[float] = field(default_factory=list)  # of the actions
    evaluations: int = 0
    states: int = 0
    inside: np.ndarray | float = 0.0  # largest tensions between the ends of steps

    @property
    def peaks(self) -> np.ndarray:
        """(n_hooks,) [N]"""
        return np.maximum(self.inside, np.max(self.tensions, axis=0))


class Reference:
    """Coordinate of an actuator: ramps and cruises, begun and halted by the action list."""

    def __init__(self, x: float) -> None:
        self.t0, self.x0, self.v0, self.legs = 0.0, x, 0.0, []

    def begin(self, t: float, legs: list[tuple[float, float]]) -> None:
        """From now on: (duration, acceleration) one after the other, then the speed stays."""
        self.x0, self.v0 = self(t)
        self.t0, self.legs = t, legs

    def __call__(self, t: float) -> tuple[float, float]:
        x, v, left = self.x0, self.v0, t - self.t0
        for duration, a in self.legs:
            s = min(duration, left)
            x, v, left = x + v * s + a * s * s / 2.0, v + a * s, left - s
            if left <= 0.0:
                return x, v
        return x + v * left, v


def trapezoid(distance: float, speed: float, accel: float) -> list[tuple[float, float]]:
    """Legs of a move that starts and ends at rest."""
    way, v = abs(distance), min(speed, sqrt(accel * abs(distance)))
    sign, ramp = np.sign(distance), v / accel
    return [(ramp, sign * accel), (max(0.0, way / v - ramp), 0.0), (ramp, -sign * accel)] if v else []


def rotation(q: np.ndarray) -> np.ndarray:
    """(..., 3, 3) of quaternions x y z w."""
    x, y, z, w = np.moveaxis(q, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(r, -1) for r in rows], -2)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a x b along the last axis; NumPy's own is slower."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    out = np.empty(a.shape if a.shape == b.shape else np.broadcast_shapes(a.shape, b.shape))
    out[..., 0], out[..., 1], out[..., 2] = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    return out


class Lift:
    """The equations; bodies are numbered upper, lower of each loader, then the block."""

    def __init__(self, plan, lumps: int = 2) -> None:
        self.plan, self.g, self.n_lumps = plan, plan.gravity, lumps
        self.ropes = list(plan.rig.hook_ropes)
        self.loaders = [next(x for x in plan.loaders if x.name == r.carries) for r in self.ropes]
        n = self.n = len(self.ropes)
        self.n_bodies = 2 * n + 1
        inertias = [i for x in self.loaders for i in (x.upper, x.lower)] + [plan.block.body]
        self.mass = np.array([i.mass for i in inertias])
        self.com = np.array([i.com for i in inertias])
        self.moments = np.array([i.moments for i in inertias])
        self._bodies_at_start()
        self._drives()
        self._slings()
        self._pads()
        self.winches = [Reference(r.L0) for r in self.ropes]
        self.EA = np.array([r.EA for r in self.ropes])
        places, weights = leggauss(lumps)  # lumps where they have the mass and the inertia of the straight rope
        self.along, self.weights = (1.0 + places) / 2.0, weights / 2.0
        self.parts = np.diff([0.0, *self.along, 1.0])
        self.damping = np.array([r.damping for r in self.ropes])[:, None] / self.parts
        self.lump = np.array([r.line * r.L0 for r in self.ropes])[:, None] * self.weights
        self.half = np.array([max(abs(line.b.p[0]) for line in r.lines) for r in self.ropes])
        self.hinge = np.array([x.hinge for x in self.loaders])
        self.friction = np.array([x.damping for x in self.loaders])
        self.y0 = self._start()
        self._sagging()

    # ---- the parts at the start

    def _bodies_at_start(self) -> None:
        p, q = [], []
        for x in self.loaders:
            top = np.array(x.pose[:3])
            p += [top + x.upper.com, top + np.array(x.hinge) + x.lower.com]
            q += [x.pose[3:], x.pose[3:]]
        pose = self.plan.block.pose
        R = rotation(np.array(pose[3:]))
        p.append(np.array(pose[:3]) + R @ self.plan.block.body.com)
        q.append(pose[3:])
        self.p0, self.q0 = np.array(p), np.array(q, float)

    def _drives(self) -> None:
        """Gantries, then trolleys: masses, servos, starts; of each hook its gantry and trolley."""
        plan, self.names, self.drive_mass, self.kp, self.kv, self.refs = plan_of(self), [], [], [], [], []
        self.cranes = list(plan.cranes)
        for c in self.cranes:
            self._drive(f"{c.name}.gantry.drive", c.main.mass + c.upper.body.mass + c.lower.body.mass, c.gantry)
        for c in self.cranes:
            for t in (c.upper, c.lower):
                self._drive(f"{c.name}.{t.name}-slide.drive", t.body.mass, t.axis)
        self.drive_mass, self.kp, self.kv = map(np.array, (self.drive_mass, self.kp, self.kv))
        k = len(self.cranes)
        self.on_gantry, self.on_trolley, exits = [], [], []
        for r in self.ropes:
            c = next(i for i, x in enumerate(self.cranes) if x.name == r.crane)
            hook = next(h for h in self.cranes[c].hooks if h.rope == r.name)
            self.on_gantry.append(c)
            self.on_trolley.append(k + 2 * c + (hook.trolley == "lower"))
            exits.append(np.mean([line.a.p for line in r.lines], axis=0))
        self.exits = np.array(exits)
        self.on_gantry, self.on_trolley = np.array(self.on_gantry), np.array(self.on_trolley)
        g = [c.girder for c in self.cranes]
        self.span, self.height = np.array([x.span for x in g]), np.array([x.height for x in g])
        self.k_girder = pi**4 / 2.0 * np.array([x.stiffness for x in g]) / 48.0
        self.m_girder = np.array([x.mass for x in g]) / 2.0
        zeta = np.array([x.damping for x in g])
        self.c_girder = 2.0 * zeta * np.sqrt(self.k_girder * self.m_girder)

    def _drive(self, name, mass, axis) -> None:
        self.names.append(name)
        self.drive_mass.append(mass)
        self.kp.append(axis.kp)
        self.kv.append(axis.kv)
        self.refs.append(Reference(axis.start))

    def _slings(self) -> None:
        lugs = {lug.name: lug.p for lug in self.plan.block.lugs}
        hooked = [s for s in self.plan.rig.slings if s.lug]
        index = {x.name: i for i, x in enumerate(self.loaders)}
        self.sling_of = np.array([index[s.loader] for s in hooked])
        self.beam = np.array([s.beam.p for s in hooked])
        self.lug = np.array([lugs[s.lug] for s in hooked])
        self.sling_L, self.sling_k = np.array([s.L0 for s in hooked]), np.array([s.EA / s.L0 for s in hooked])
        self.sling_d = np.array([s.damping for s in hooked])

    def _pads(self) -> None:
        pads = [p.support for p in self.plan.block.pads if p.closed]
        self.pad = np.array([s.point.p for s in pads])
        self.pad_z, self.pad_k = np.array([s.height for s in pads]), np.array([s.k for s in pads])
        self.pad_d, self.pad_mu = np.array([s.d for s in pads]), np.array([s.mu for s in pads])
        self.pad_kt, self.pad_dt = np.array([s.kt for s in pads]), np.array([s.dt for s in pads])
        block = self.plan.block
        R = rotation(np.array(block.pose[3:]))
        self.pad_at = np.array(block.pose[:3]) + self.pad @ R.T  # where friction holds them

    def _start(self) -> np.ndarray:
        n, m = self.n, self.n_lumps
        eyes = np.array([x.pose[:3] for x in self.loaders])
        tops = self.exits + np.stack(
            [[self.refs[c].x0 for c in self.on_gantry], [self.refs[t].x0 for t in self.on_trolley], np.zeros(n)], -1
        )
        lumps = tops[:, None] + (eyes - tops)[:, None] * self.along[None, :, None]
        hang = np.linalg.norm(eyes - tops, axis=-1)
        under = self.mass[0 : 2 * n : 2] + self.mass[1 : 2 * n : 2]
        below = under[:, None] + np.concatenate([self.lump[:, ::-1].cumsum(1)[:, ::-1], np.zeros((n, 1))], 1)
        self.L0_parts = self.parts * hang[:, None] / (1.0 + below * self.g / self.EA[:, None])
        self.L0_start = np.array([r.L0 for r in self.ropes])
        self.still = below[:, 0] * self.g  # tension at the trolley
        yaw = np.zeros((n, m, 1))
        self.shapes = [
            (self.n_bodies, 3), (self.n_bodies, 4), (n, m, 4), (len(self.names),), (len(self.cranes),),
            (self.n_bodies, 3), (self.n_bodies, 3), (n, m, 4), (len(self.names),), (len(self.cranes),),
        ]  # fmt: skip
        start = [self.p0, self.q0, np.concatenate([lumps, yaw], -1), np.array([r.x0 for r in self.refs])]
        start += [np.zeros(len(self.cranes))]
        flat = np.concatenate([x.ravel() for x in start])
        rest = sum(int(np.prod(s)) for s in self.shapes[5:])
        return np.concatenate([flat, np.zeros(rest)])

    def _sagging(self) -> None:
        """Girders at the start, bent by all that they carry: how far, and how steep under each hook's trolley."""
        at = pi * self.refs0 / self.span[(np.arange(len(self.refs0)) - len(self.cranes)) // 2]
        load = 4.0 / pi * self.m_girder * self.g
        for j in range(len(self.cranes), len(self.names)):
            load[(j - len(self.cranes)) // 2] += self.drive_mass[j] * self.g * np.sin(at[j])
        for c, tr, tension in zip(self.on_gantry, self.on_trolley, self.still, strict=True):
            load[c] += tension * np.sin(at[tr])
        self.sag0 = load / self.k_girder
        sag, at = self.sag0[self.on_gantry], at[self.on_trolley]
        self.low0, self.steep0 = sag * np.sin(at), sag * pi / self.span[self.on_gantry] * np.cos(at)

    # ---- the equations

    def split(self, Y: np.ndarray) -> list[np.ndarray]:
        """The parts of (n, B) states, batch first."""
        Y, at, out = Y.T, 0, []
        for shape in self.shapes:
            size = int(np.prod(shape))
            out.append(Y[:, at : at + size].reshape(-1, *shape))
            at += size
        return out

    def __call__(self, t: float, y: np.ndarray) -> np.ndarray:
        Y = y[:, None] if y.ndim == 1 else y
        p, q, _, _, _, v, w, du, dd, ds = parts = self.split(Y)
        R = rotation(q / np.linalg.norm(q, axis=-1, keepdims=True))
        force, moment = np.zeros_like(v), np.zeros_like(w)
        force[..., 2] = -self.mass * self.g
        lumps, drives, girder = self._chains(t, R, parts, force, moment)
        self._hang(p, R, v, w, force, moment)
        self._stand(p, R, v, w, force, moment)
        I = R @ (self.moments[:, :, None] * np.swapaxes(R, -1, -2))
        inverse = R @ ((1.0 / self.moments)[:, :, None] * np.swapaxes(R, -1, -2))
        moment = moment - cross(w, (I @ w[..., None])[..., 0])
        a, alpha = self._hinged(p, R, v, w, force, moment, inverse)
        spin = np.concatenate([w, np.zeros_like(w[..., :1])], -1)
        parts = [v, 0.5 * hamilton(spin, q), du, dd, ds, a, alpha, lumps, drives, girder]
        out = np.concatenate([x.reshape(len(x), -1) for x in parts], -1).T
        return out[:, 0] if y.ndim == 1 else out

    def tensions(self, t: float, y: np.ndarray) -> np.ndarray:
        """(B, n_hooks) of the ropes at their hooks at times (B,) and states (n, B) [N]."""
        parts = self.split(y)
        R = rotation(parts[1] / np.linalg.norm(parts[1], axis=-1, keepdims=True))
        self._chains(t, R, parts, np.zeros_like(parts[5]), np.zeros_like(parts[6]))
        return self.tension

    def _point(self, i, P, p, R, v, w):
        """Place, velocity and arm from the centre of mass of body-fixed points (frame coordinates) of bodies i."""
        arm = (R[:, i] @ (P - self.com[i])[..., None])[..., 0]
        return p[:, i] + arm, v[:, i] + cross(w[:, i], arm), arm

    def _chains(self, t, R, parts, force, moment):
        """Ropes from trolleys over lumps to the eyes, with what they do to trolleys and girders."""
        p, _, u, d, s, v, w, du, dd, ds = parts
        n = self.n
        c, tr = self.on_gantry, self.on_trolley
        L0, dL0 = np.array([[x(s) for x in self.winches] for s in np.atleast_1d(t)]).transpose(2, 0, 1)
        length = self.L0_parts + self.parts * (L0 - self.L0_start)[..., None]
        rate = self.parts * dL0[..., None]
        phase = pi * d[:, tr] / self.span[c]
        sine, slope = np.sin(phase), pi / self.span[c] * np.cos(phase)
        lever = self.exits[:, 2] - self.height[c]
        sag, dsag = s[:, c] - self.sag0[c], ds[:, c]  # upwards, in all
        lost = sag**2 * self._bowed(d[:, tr], c) - self.sag0[c] ** 2 * self._bowed(self.refs0[tr], c)
        aside, up_ = d[:, tr] - lost - lever * (sag * slope + self.steep0), self.low0 + sag * sine
        top = np.stack([d[:, c] + self.exits[:, 0], aside, self.exits[:, 2] + up_], -1)
        daside = dd[:, tr] * (1.0 + lever * sag * (pi / self.span[c]) ** 2 * sine) - lever * dsag * slope
        dtop = np.stack([dd[:, c], daside, dsag * sine + sag * slope * dd[:, tr]], -1)
        ex = np.array([1.0, 0.0, 0.0])
        cy, sy = np.cos(u[..., 3]), np.sin(u[..., 3])
        yaw = np.stack([cy, sy, 0 * cy], -1)
        dyaw = np.stack([-sy, cy, 0 * cy], -1) * du[..., 3:]
        up = 2 * np.arange(n)
        push = np.zeros_like(u)
        _pull, trolley = np.zeros((len(u), n, self.n_lumps + 1)), np.zeros_like(top)
        for side in (-1.0, 1.0):
            offset = side * self.half[:, None]
            inner = u[..., :3] + offset[..., None] * yaw
            dinner = du[..., :3] + offset[..., None] * dyaw
            eye, deye, arm = self._point(up, offset * ex, p, R, v, w)
            places = np.concatenate([(top + offset * ex)[:, :, None], inner, eye[:, :, None]], 2)
            speeds = np.concatenate([dtop[:, :, None], dinner, deye[:, :, None]], 2)
            way = places[:, :, 1:] - places[:, :, :-1]
            l = np.sqrt((way * way).sum(-1))
            unit = way / l[..., None]
            dl = ((speeds[:, :, 1:] - speeds[:, :, :-1]) * unit).sum(-1)
            if side < 0:
                first = l, dl, unit, arm
        l2, dl2 = (first[0] + l) / 2.0, (first[1] + dl) / 2.0
        stretch = l2 - length
        T = np.where(
            stretch > 0.0, np.maximum(0.0, self.EA[:, None] / length * stretch + self.damping * (dl2 - rate)), 0
        )
        self.tension = T[:, :, -1]
        for side, unit_, arm_ in ((-1.0, first[2], first[3]), (1.0, unit, arm)):
            F = 0.5 * T[..., None] * unit_
            trolley += F[:, :, 0]
            on = F[:, :, 1:] - F[:, :, :-1]  # on the lumps
            push[..., :3] += on
            offset = side * self.half[:, None]
            push[..., 3] += offset * (yaw[..., 0] * on[..., 1] - yaw[..., 1] * on[..., 0])
            force[:, up] -= F[:, :, -1]
            moment[:, up] -= cross(arm_, F[:, :, -1])
        m = self.lump
        lumps = np.concatenate(
            [push[..., :3] / m[..., None], (push[..., 3] / (m * self.half[:, None] ** 2))[..., None]], -1
        )
        lumps[..., 2] -= self.g
        return lumps, *self._portal(t, d, dd, s, ds, trolley, sine, slope, lever)

    def _bowed(self, y, c):
        """How much of its way a trolley loses on a girder that is bent by 1 m: half of the slopes squared."""
        return (pi / self.span[c]) ** 2 / 4.0 * (y + self.span[c] / (2.0 * pi) * np.sin(2.0 * pi * y / self.span[c]))

    def _portal(self, t, d, dd, s, ds, trolley, sine, slope, lever):
        refs = np.array([[r(s) for r in self.refs] for s in np.atleast_1d(t)])
        F = self.kp * (refs[..., 0] - d) + self.kv * (refs[..., 1] - dd)
        k = len(self.cranes)
        bend = -self.k_girder * s - self.c_girder * ds
        mass = np.repeat(self.m_girder[None], len(d), 0)
        for i, (c, tr) in enumerate(zip(self.on_gantry, self.on_trolley, strict=True)):
            F[:, c] += trolley[:, i, 0]
            sag = s[:, c] - self.sag0[c]
            F[:, tr] += trolley[:, i, 1] * (1.0 + lever[i] * sag * (pi / self.span[c]) ** 2 * sine[:, i])
            F[:, tr] += trolley[:, i, 2] * sag * slope[:, i]  # down the slope
            at_start = np.sin(pi * self.refs0[tr] / self.span[c])
            bend[:, c] += trolley[:, i, 2] * sine[:, i] + self.still[i] * at_start
            bend[:, c] -= trolley[:, i, 1] * lever[i] * slope[:, i]
        for j in range(k, len(self.names)):
            c = (j - k) // 2
            shape = np.sin(pi * d[:, j] / self.span[c])
            mass[:, c] += self.drive_mass[j] * shape**2
            bend[:, c] -= self.drive_mass[j] * self.g * (shape - np.sin(pi * self.refs0[j] / self.span[c]))
            steep = pi / self.span[c] * np.cos(pi * d[:, j] / self.span[c])
            F[:, j] -= self.drive_mass[j] * self.g * (s[:, c] - self.sag0[c]) * steep
        return F / self.drive_mass, bend / mass

    def _hang(self, p, R, v, w, force, moment) -> None:
        """Slings between beams and lugs."""
        if not len(self.sling_of):
            return
        low, block = 2 * self.sling_of + 1, np.full(len(self.sling_of), self.n_bodies - 1)
        beam = self.beam
        a, da, arm_a = self._point(low, beam, p, R, v, w)
        b, db, arm_b = self._point(block, self.lug, p, R, v, w)
        way = b - a
        l = np.sqrt((way * way).sum(-1))
        unit = way / l[..., None]
        rate = ((db - da) * unit).sum(-1)
        stretch = l - self.sling_L
        T = np.where(stretch > 0.0, np.maximum(0.0, self.sling_k * stretch + self.sling_d * rate), 0.0)
        self.sling_stretch = stretch
        F = T[..., None] * unit
        for i, j in enumerate(low):
            force[:, j] += F[:, i]
            moment[:, j] += cross(arm_a[:, i], F[:, i])
        force[:, -1] -= F.sum(1)
        moment[:, -1] -= cross(arm_b, F).sum(1)

    def _stand(self, p, R, v, w, force, moment) -> None:
        """Stools under the block."""
        block = np.full(len(self.pad), self.n_bodies - 1)
        x, dx, arm = self._point(block, self.pad, p, R, v, w)
        depth = self.pad_z - x[..., 2]
        carried = self.pad_k * depth - self.pad_d * dx[..., 2]
        N = np.where(depth > 0.0, np.maximum(0.0, carried), 0.0)
        self.standing = np.where(depth > 0.0, carried, -1.0)
        rub = -self.pad_kt[:, None] * (x - self.pad_at)[..., :2] - self.pad_dt[:, None] * dx[..., :2]
        size = np.sqrt((rub * rub).sum(-1)) + TINY
        rub = rub * np.minimum(1.0, self.pad_mu * N / size)[..., None]
        F = np.concatenate([rub, N[..., None]], -1)
        force[:, -1] += F.sum(1)
        moment[:, -1] += cross(arm, F).sum(1)

    def _hinged(self, p, R, v, w, force, moment, inverse):
        """Accelerations with the five multipliers of every hinge."""
        n = self.n
        up, low = 2 * np.arange(n), 2 * np.arange(n) + 1
        ey = R[:, up][..., 1]
        turn = (self.friction[:, None] * ((w[:, low] - w[:, up]) * ey).sum(-1, keepdims=True)) * ey
        moment[:, up] += turn
        moment[:, low] -= turn
        a, alpha = force / self.mass[:, None], (inverse @ moment[..., None])[..., 0]
        x_u, _v_u, r_u = self._point(up, self.hinge, p, R, v, w)
        x_l, _v_l, r_l = self._point(low, np.zeros((n, 3)), p, R, v, w)
        G = np.zeros((len(p), n, 5, 12))  # on v and w of upper, then of lower
        eye = np.eye(3)
        G[:, :, :3, 0:3], G[:, :, :3, 6:9] = eye, -eye
        G[:, :, :3, 3:6], G[:, :, :3, 9:12] = -hat(r_u), hat(r_l)
        bend = []
        for row, axis in ((3, 0), (4, 2)):
            e, f = R[:, up][..., axis], R[:, low][..., 1]
            turning = cross(e, f)
            G[:, :, row, 3:6], G[:, :, row, 9:12] = turning, -turning
            bend.append(((e * f).sum(-1), e, f))
        gap = np.concatenate([x_u - x_l, np.stack([x[0] for x in bend], -1)], -1)
        motion = np.concatenate([v[:, up], w[:, up], v[:, low], w[:, low]], -1)
        rate = (G @ motion[..., None])[..., 0]
        bias = cross(w[:, up], cross(w[:, up], r_u)) - cross(w[:, low], cross(w[:, low], r_l))
        wu, wl = w[:, up], w[:, low]
        twist = []
        for _, e, f in bend:
            de, df = cross(wu, e), cross(wl, f)
            twist.append((cross(wu, de) * f).sum(-1) + 2 * (de * df).sum(-1) + (e * cross(wl, df)).sum(-1))
        # d2(e.f) = e''.f + 2 e'.f' + e.f'' with e'' = alpha x e + w x (w x e)
        bias = np.concatenate([bias, np.stack(twist, -1)], -1)
        wanted = -bias - 2 * BAUMGARTE * rate - BAUMGARTE**2 * gap
        W = np.zeros((len(p), n, 12, 12))
        W[:, :, 0:3, 0:3] = eye / self.mass[up][:, None, None]
        W[:, :, 6:9, 6:9] = eye / self.mass[low][:, None, None]
        W[:, :, 3:6, 3:6], W[:, :, 9:12, 9:12] = inverse[:, up], inverse[:, low]
        free = np.concatenate([a[:, up], alpha[:, up], a[:, low], alpha[:, low]], -1)
        WG = W @ np.swapaxes(G, -1, -2)
        pull = np.linalg.solve(G @ WG, (wanted - (G @ free[..., None])[..., 0])[..., None])
        held = free + (WG @ pull)[..., 0]
        a[:, up], alpha[:, up] = held[..., 0:3], held[..., 3:6]
        a[:, low], alpha[:, low] = held[..., 6:9], held[..., 9:12]
        return a, alpha


def plan_of(lift: Lift):
    """The plan of a lift, with the starts of its drives noted."""
    starts = [c.gantry.start for c in lift.plan.cranes]
    starts += [t.axis.start for c in lift.plan.cranes for t in (c.upper, c.lower)]
    lift.refs0 = np.array(starts)
    return lift.plan


def hat(a: np.ndarray) -> np.ndarray:
    """(..., 3, 3) of the cross product with a."""
    x, y, z = np.moveaxis(a, -1, 0)
    o = 0 * x
    return np.stack([np.stack(r, -1) for r in ([o, -z, y], [z, o, -x], [-y, x, o])], -2)


def hamilton(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Products of quaternions x y z w."""
    ax, ay, az, aw = np.moveaxis(a, -1, 0)
    bx, by, bz, bw = np.moveaxis(b, -1, 0)
    return np.stack([
        aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz,
    ], -1)  # fmt: skip


def richest(plan, rtol: float = 1e-6, lumps: int = 2, end: float | None = None) -> History:
    """Play the action list of a plan."""
    lift = Lift(plan, lumps)
    out = History([r.name for r in lift.ropes], states=len(lift.y0))
    player = _Player(lift, out, rtol)
    for action in plan.actions:
        player.play(action)
        out.ended.append(player.t)
    return out


class _Player:
    """Advances a lift from action to action."""

    def __init__(self, lift: Lift, out: History, rtol: float) -> None:
        self.lift, self.out, self.rtol, self.t, self.y = lift, out, rtol, 0.0, lift.y0
        self.atol = rtol * 1e-3
        self.note(0.0, self.y)

    def play(self, action) -> None:
        """Start all orders; go on until each is done."""
        self.bound = self.lift.plan.end or 1e9
        waiting, until = [self.t], []
        for order in action.orders:
            kind = type(order).__name__
            if kind == "Wait":
                waiting.append(self.t + order.seconds)
                continue
            reference = self.reference(order.actuator)
            if order.until is not None or order.by is None:
                until.append((reference, order))
                reference.begin(self.t, [(abs(order.speed) / order.accel, np.sign(order.speed) * order.accel)])
            else:
                legs = trapezoid(order.by, order.speed, order.accel)
                reference.begin(self.t, legs)
                waiting.append(self.t + sum(d for d, _ in legs))
        if until:
            self.go(None, self.condition(until[0][1].until))
            for reference, order in until:
                _, v = reference(self.t)
                reference.begin(self.t, [(abs(v) / order.accel, -np.sign(v) * order.accel)])
                waiting.append(self.t + abs(v) / order.accel)
        self.go(max(waiting), None)

    def reference(self, name: str) -> Reference:
        names = [r.name for r in self.lift.ropes]
        return self.lift.winches[names.index(name)] if name in names else self.lift.refs[self.lift.names.index(name)]

    def condition(self, until):
        """A function that is positive once it holds."""
        lift = self.lift
        if type(until).__name__ == "Lifted":
            return lambda: -float(lift.standing.max())
        return lambda: float(lift.sling_stretch.min())

    def go(self, until: float | None, holds) -> None:
        """Integrate to a time, or until a condition holds."""
        stop = min(until if until is not None else 1e9, self.bound)
        if stop <= self.t:
            return
        solver = Radau(self.moved, self.t, self.y - self.lift.y0, stop, rtol=self.rtol, atol=self.atol,
                       jac=self.jacobian, first_step=min(1e-3, stop - self.t), max_step=0.25)  # fmt: skip
        while solver.status == "running":
            before = solver.t
            told = solver.step()
            assert solver.status != "failed", told
            if holds is not None and self.value(holds, solver.t, solver.y + self.lift.y0) > 0.0:
                dense, a, b = self.within(solver), before, solver.t
                while b - a > 1e-7:
                    middle = (a + b) / 2.0
                    a, b = (a, middle) if self.value(holds, middle, dense(middle)) > 0.0 else (middle, b)
                self.t, self.y = b, dense(b)
                self.note(self.t, self.y)
                break
            dense = self.within(solver)
            t = before + INSIDE * (solver.t - before)
            self.out.inside = np.maximum(self.out.inside, self.lift.tensions(t, dense(t)).max(0))
            self.t, self.y = solver.t, solver.y + self.lift.y0
            self.note(self.t, self.y)
        self.out.evaluations += solver.nfev

    def moved(self, t: float, z: np.ndarray) -> np.ndarray:
        """The equations of what has moved since the start, on which relative errors count."""
        return self.lift(t, z + self.lift.y0)

    def within(self, solver: Radau):
        """The state within the last step."""
        dense = solver.dense_output()
        start = self.lift.y0
        return lambda t: (dense(t).T + start).T

    def value(self, holds, t: float, y: np.ndarray) -> float:
        self.lift(t, y)
        return holds()

    def jacobian(self, t: float, y: np.ndarray) -> np.ndarray:
        """By differences, all columns in one batch."""
        h = 1e-7
        y = y + self.lift.y0
        return (self.lift(t, y[:, None] + h * np.eye(len(y))) - self.lift(t, y)[:, None]) / h

    def note(self, t: float, y: np.ndarray) -> None:
        self.out.times.append(t)
        self.out.tensions.append(self.lift.tensions(t, y[:, None])[0])
        n = self.lift.n_bodies
        R = rotation(y[7 * n - 4 : 7 * n])
        self.out.places.append(y[3 * n - 3 : 3 * n] - R @ self.lift.com[-1])
