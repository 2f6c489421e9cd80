"""The parts of a lift in maximal coordinates, as they stand at the start; their numbers come from the plan."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
from numpy.polynomial.legendre import leggauss
from rail_lifts import lift_of
from vectors import rotation


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
    path, v = abs(distance), min(speed, sqrt(accel * abs(distance)))
    sign, ramp = np.sign(distance), v / accel
    return [(ramp, sign * accel), (max(0.0, path / v - ramp), 0.0), (ramp, -sign * accel)] if v else []


class Parts:
    """Bodies (numbered upper, lower of each loader, then the block), drives, slings, supports, lumps, girders."""

    def __init__(self, plan, lumps: int = 2) -> None:
        self.plan, self.g, self.n_lumps = plan, plan.gravity, lumps
        self.ropes = list(lift_of(plan).rig.hook_ropes)
        self.loaders = [next(x for x in lift_of(plan).loaders if x.name == r.carries) for r in self.ropes]
        n = self.n = len(self.ropes)
        self.n_bodies = 2 * n + 1
        inertias = [i for x in self.loaders for i in (x.upper, x.lower)] + [lift_of(plan).block.body]
        self.mass = np.array([i.mass for i in inertias])
        self.com = np.array([i.com for i in inertias])
        self.moments = np.array([np.diagonal(i.inertia) for i in inertias])
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
        self.friction = np.array([x.damping for x in self.loaders])
        self.straight = np.array([0, 1, 2, 6, 7, 8])  # of velocity, spin of an upper, of a lower: what its mass holds
        self.lightness = np.repeat(1.0 / self.mass[:-1].reshape(n, 2), 3, axis=1)
        self._points_on_bodies()
        self.y0 = self._start()
        self._sagging()

    # ---- the parts at the start

    def _bodies_at_start(self) -> None:
        p, q = [], []
        for x in self.loaders:
            top = np.array(x.pose[:3])
            p += [top + x.upper.com, top + np.array(x.hinge) + x.lower.com]
            q += [x.pose[3:], x.pose[3:]]
        pose = lift_of(self.plan).block.pose
        R = rotation(np.array(pose[3:]))
        p.append(np.array(pose[:3]) + R @ lift_of(self.plan).block.body.com)
        q.append(pose[3:])
        self.p0, self.q0 = np.array(p), np.array(q, float)

    def _points_on_bodies(self) -> None:
        """Eyes (of the lines on one side, then on the other), hinges (on uppers, then on lowers), beams, lugs, pads."""
        n, block = self.n, self.n_bodies - 1
        up, low = 2 * np.arange(n), 2 * np.arange(n) + 1
        eyes = [side * self.half[:, None] * np.array([1.0, 0.0, 0.0]) for side in (-1.0, 1.0)]
        groups = [
            (up, eyes[0]),
            (up, eyes[1]),
            (up, np.array([x.hinge for x in self.loaders])),
            (low, np.zeros((n, 3))),
        ]
        slings, pads = len(self.sling_of), len(self.pad)
        groups += [(2 * self.sling_of + 1, self.beam), ([block] * slings, self.lug), ([block] * pads, self.pad)]
        self.on = np.concatenate([bodies for bodies, _ in groups]).astype(int)
        self.from_com = np.concatenate([places.reshape(-1, 3) for _, places in groups]) - self.com[self.on]
        ends = np.cumsum([0, 2 * n, 2 * n, slings, slings, pads])
        self.eyes, self.hinges, self.beams, self.lugs, self.pads = map(slice, ends[:-1], ends[1:])
        self.onto = (np.arange(self.n_bodies)[:, None] == self.on).astype(float)

    def _drives(self) -> None:
        """Gantries, then trolleys: masses, servos, starts; of each hook its gantry and trolley."""
        plan = self.plan
        self.names, self.drive_mass, self.kp, self.kv, self.refs = [], [], [], [], []
        self.cranes = list(lift_of(plan).cranes)
        for c in self.cranes:
            self._drive(f"{c.name}.gantry.drive", c.main.mass + c.upper.body.mass + c.lower.body.mass, c.gantry)
        for c in self.cranes:
            for t in (c.upper, c.lower):
                self._drive(f"{c.name}.{t.name}-slide.drive", t.body.mass, t.axis)
        self.drive_mass, self.kp, self.kv = map(np.array, (self.drive_mass, self.kp, self.kv))
        self.refs0 = np.array([r.x0 for r in self.refs])
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
        self.under = np.arange(2 * k) // 2  # girder of each trolley
        self.to_gantry, self.to_trolley = (
            (at[:, None] == np.arange(len(self.names))).astype(float) for at in (self.on_gantry, self.on_trolley)
        )
        self.to_girder = (self.under[:, None] == np.arange(k)).astype(float)
        g = [c.girder for c in self.cranes]
        self.span = np.array([x.span for x in g])
        self.lever = self.exits[:, 2] - np.array([x.height for x in g])[self.on_gantry]
        self.k_girder = pi**4 / 2.0 * np.array([x.stiffness for x in g]) / 48.0
        self.m_girder = np.array([x.mass for x in g]) / 2.0
        zeta = np.array([x.flexible.damping for x in g])
        self.c_girder = 2.0 * zeta * np.sqrt(self.k_girder * self.m_girder)

    def _drive(self, name, mass, axis) -> None:
        self.names.append(name)
        self.drive_mass.append(mass)
        self.kp.append(axis.kp)
        self.kv.append(axis.kv)
        self.refs.append(Reference(axis.start))

    def _slings(self) -> None:
        lugs = {lug.name: lug.p for lug in lift_of(self.plan).block.lugs}
        hooked = [s for s in lift_of(self.plan).rig.slings if s.lug]
        index = {x.name: i for i, x in enumerate(self.loaders)}
        self.sling_of = np.array([index[s.loader] for s in hooked])
        self.beam = np.array([s.beam.p for s in hooked])
        self.lug = np.array([lugs[s.lug] for s in hooked])
        self.sling_L, self.sling_k = np.array([s.L0 for s in hooked]), np.array([s.EA / s.L0 for s in hooked])
        self.sling_d = np.array([s.damping for s in hooked])

    def _pads(self) -> None:
        pads = [p.support for p in lift_of(self.plan).block.pads if p.closed]
        self.pad = np.array([s.point.p for s in pads])
        self.pad_z, self.pad_k = np.array([s.height for s in pads]), np.array([s.k for s in pads])
        self.pad_d, self.pad_mu = np.array([s.d for s in pads]), np.array([s.mu for s in pads])
        self.pad_kt, self.pad_dt = np.array([s.kt for s in pads]), np.array([s.dt for s in pads])

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
            (len(self.pad), 2),
        ]  # fmt: skip
        start = [self.p0, self.q0, np.concatenate([lumps, yaw], -1), np.array([r.x0 for r in self.refs])]
        start += [np.zeros(len(self.cranes))]
        flat = np.concatenate([x.ravel() for x in start])
        rest = sum(int(np.prod(s)) for s in self.shapes[5:])
        return np.concatenate([flat, np.zeros(rest)])

    def _sagging(self) -> None:
        """Girders at the start, bent by all that they carry: how far, and how steep under each hook's trolley."""
        k, phase = len(self.cranes), pi * self.refs0 / self.span[np.r_[np.arange(len(self.cranes)), self.under]]
        weight = self.drive_mass[k:] * self.g * np.sin(phase[k:])
        self.held = weight @ self.to_girder + (self.still * np.sin(phase[self.on_trolley])) @ self.to_gantry[:, :k]
        self.sag0 = (4.0 / pi * self.m_girder * self.g + self.held) / self.k_girder
        sag, phase = self.sag0[self.on_gantry], phase[self.on_trolley]
        self.low0, self.steep0 = sag * np.sin(phase), sag * pi / self.span[self.on_gantry] * np.cos(phase)
