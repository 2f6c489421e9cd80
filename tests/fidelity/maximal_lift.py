"""The equations of a lift in maximal coordinates: rigid bodies, Lagrange multipliers at the hinges of loaders."""

from __future__ import annotations

from math import pi

import numpy as np
from maximal_parts import Parts
from vectors import cross, hamilton, hat, rotation

BAUMGARTE = 20.0  # [1/s] at which a hinge that has drifted comes back
TINY = 1e-12


class Lift(Parts):
    """Derivatives of (n, B) states, and the tensions of the hook ropes."""

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
        *parts, bent = self.split(Y)
        p, q, _, _, _, v, w, du, dd, ds = parts
        R = rotation(q / np.linalg.norm(q, axis=-1, keepdims=True))
        force, moment = np.zeros_like(v), np.zeros_like(w)
        force[..., 2] = -self.mass * self.g
        lumps, drives, girder = self._chains(t, R, parts, force, moment)
        self._hang(p, R, v, w, force, moment)
        bending = self._stand(p, R, v, w, bent, force, moment)
        I = R @ (self.moments[:, :, None] * np.swapaxes(R, -1, -2))
        inverse = R @ ((1.0 / self.moments)[:, :, None] * np.swapaxes(R, -1, -2))
        moment = moment - cross(w, (I @ w[..., None])[..., 0])
        a, alpha = self._hinged(p, R, v, w, force, moment, inverse)
        spin = np.concatenate([w, np.zeros_like(w[..., :1])], -1)
        parts = [v, 0.5 * hamilton(spin, q), du, dd, ds, a, alpha, lumps, drives, girder, bending]
        out = np.concatenate([x.reshape(len(x), -1) for x in parts], -1).T
        return out[:, 0] if y.ndim == 1 else out

    def tensions(self, t: float, y: np.ndarray) -> np.ndarray:
        """(B, n_hooks) of the ropes at their hooks at times (B,) and states (n, B) [N]."""
        *parts, _ = self.split(y)
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

    def _stand(self, p, R, v, w, bent, force, moment):
        """Stools under the block, and how fast their tops bend: as the block moves, or as sliding lets them."""
        block = np.full(len(self.pad), self.n_bodies - 1)
        x, dx, arm = self._point(block, self.pad, p, R, v, w)
        depth = self.pad_z - x[..., 2]
        carried = self.pad_k * depth - self.pad_d * dx[..., 2]
        N = np.where(depth > 0.0, np.maximum(0.0, carried), 0.0)
        self.standing = np.where(depth > 0.0, carried, -1.0)
        k, d = self.pad_kt[:, None], self.pad_dt[:, None]
        held = k * bent + d * dx[..., :2]
        size = np.sqrt((held * held).sum(-1)) + TINY
        rub = held * np.minimum(1.0, self.pad_mu * N / size)[..., None]
        F = np.concatenate([-rub, N[..., None]], -1)
        force[:, -1] += F.sum(1)
        moment[:, -1] += cross(arm, F).sum(1)
        return (rub - k * bent) / d

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
