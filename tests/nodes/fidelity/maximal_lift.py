"""The equations of a lift in maximal coordinates: rigid bodies, Lagrange multipliers at the hinges of loaders."""

from __future__ import annotations

from math import pi

import numpy as np
from maximal_parts import Parts
from vectors import cross, hamilton, hat, rotation, turned

BAUMGARTE = 20.0  # [1/s] at which a hinge that has drifted comes back
TINY = 1e-12
SIDES = np.array([-1.0, 1.0])  # of a rope's two lines


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
        p, q, u, d, s, v, w, du, dd, ds = parts
        R = rotation(q / np.linalg.norm(q, axis=-1, keepdims=True))
        x, dx, arm = self._points(p, R, v, w)
        F = np.zeros_like(x)
        F[:, self.eyes], *accelerations = self._chains(t, u, d, s, du, dd, ds, x, dx)
        F[:, self.beams] = pull = self._hang(x, dx)
        F[:, self.lugs] = -pull
        F[:, self.pads], bending = self._stand(x, dx, bent)
        force = self.onto @ F
        force[..., 2] -= self.mass * self.g
        inertia = R @ (self.moments[:, :, None] * np.swapaxes(R, -1, -2))
        inverse = R @ ((1.0 / self.moments)[:, :, None] * np.swapaxes(R, -1, -2))
        moment = self.onto @ cross(arm, F) - cross(w, turned(inertia, w))
        a, alpha = self._hinged(x, arm, R, v, w, force, moment, inverse)
        spin = np.concatenate([w, np.zeros_like(w[..., :1])], -1)
        rates = [v, 0.5 * hamilton(spin, q), du, dd, ds, a, alpha, *accelerations, bending]
        out = np.concatenate([r.reshape(len(r), -1) for r in rates], -1).T
        return out[:, 0] if y.ndim == 1 else out

    def tensions(self, t: float, y: np.ndarray) -> np.ndarray:
        """(B, n_hooks) of the ropes at their hooks at times (B,) and states (n, B) [N]."""
        p, q, u, d, s, v, w, du, dd, ds, _ = self.split(y)
        R = rotation(q / np.linalg.norm(q, axis=-1, keepdims=True))
        x, dx, _ = self._points(p, R, v, w)
        self._chains(t, u, d, s, du, dd, ds, x, dx)
        return self.tension

    def _points(self, p, R, v, w):
        """Places, velocities and arms from the centre of mass of all points on bodies."""
        i = self.on
        arm = turned(R[:, i], self.from_com)
        return p[:, i] + arm, v[:, i] + cross(w[:, i], arm), arm

    def _chains(self, t, u, d, s, du, dd, ds, x, dx):
        """Ropes from trolleys over lumps to the eyes: forces on the eyes, accelerations of lumps, drives, girders."""
        c, tr, shape = self.on_gantry, self.on_trolley, (len(u), 2, self.n, 1, 3)
        L0, dL0 = np.array([[winch(s) for winch in self.winches] for s in np.atleast_1d(t)]).transpose(2, 0, 1)
        length = self.L0_parts + self.parts * (L0 - self.L0_start)[..., None]
        phase = pi * d[:, tr] / self.span[c]
        sine, slope = np.sin(phase), pi / self.span[c] * np.cos(phase)
        sag, dsag = s[:, c] - self.sag0[c], ds[:, c]  # upwards, in all
        lost = sag**2 * self._bowed(d[:, tr], c) - self.sag0[c] ** 2 * self._bowed(self.refs0[tr], c)
        nods = 1.0 + self.lever * sag * (pi / self.span[c]) ** 2 * sine
        lateral = d[:, tr] - lost - self.lever * (sag * slope + self.steep0)
        top = np.stack([d[:, c] + self.exits[:, 0], lateral, self.exits[:, 2] + self.low0 + sag * sine], -1)
        daside = dd[:, tr] * nods - self.lever * dsag * slope
        dtop = np.stack([dd[:, c], daside, dsag * sine + sag * slope * dd[:, tr]], -1)
        cy, sy, offset = np.cos(u[..., 3]), np.sin(u[..., 3]), SIDES[:, None, None] * self.half[:, None]
        yaw, across = np.stack([cy, sy, 0.0 * cy], -1), np.stack([-sy, cy, 0.0 * cy], -1) * du[..., 3:]
        inner = u[:, None, ..., :3] + offset[..., None] * yaw[:, None]
        dinner = du[:, None, ..., :3] + offset[..., None] * across[:, None]
        tops = top[:, None] + offset * np.array([1.0, 0.0, 0.0])
        dtops = np.broadcast_to(dtop[:, None], tops.shape)
        places = np.concatenate([tops.reshape(shape), inner, x[:, self.eyes].reshape(shape)], 3)
        speeds = np.concatenate([dtops.reshape(shape), dinner, dx[:, self.eyes].reshape(shape)], 3)
        distance, speed = places[:, :, :, 1:] - places[:, :, :, :-1], speeds[:, :, :, 1:] - speeds[:, :, :, :-1]
        l = np.sqrt((distance * distance).sum(-1))
        unit = distance / l[..., None]
        stretch, rate = l.mean(1) - length, (speed * unit).sum(-1).mean(1) - self.parts * dL0[..., None]
        pulled = np.maximum(0.0, self.EA[:, None] / length * stretch + self.damping * rate)
        T = np.where(stretch > 0.0, pulled, 0.0)
        self.tension = T[:, :, -1]
        F = 0.5 * T[:, None, ..., None] * unit
        on = F[:, :, :, 1:] - F[:, :, :, :-1]  # on the lumps
        turning = (offset * (yaw[:, None, ..., 0] * on[..., 1] - yaw[:, None, ..., 1] * on[..., 0])).sum(1)
        yawing = turning / (self.lump * self.half[:, None] ** 2)
        lumps = np.concatenate([on.sum(1) / self.lump[..., None], yawing[..., None]], -1)
        lumps[..., 2] -= self.g
        portal = self._portal(t, d, dd, s, ds, F[:, :, :, 0].sum(1), sine, slope, nods)
        return -F[:, :, :, -1].reshape(len(u), -1, 3), lumps, *portal

    def _bowed(self, y, c):
        """How much of its way a trolley loses on a girder that is bent by 1 m: half of the slopes squared."""
        return (pi / self.span[c]) ** 2 / 4.0 * (y + self.span[c] / (2.0 * pi) * np.sin(2.0 * pi * y / self.span[c]))

    def _portal(self, t, d, dd, s, ds, pull, sine, slope, nods):
        """Accelerations of gantries and trolleys on their servos, and of the girders under all that they carry."""
        refs = np.array([[r(s) for r in self.refs] for s in np.atleast_1d(t)])
        sag = s - self.sag0
        F = self.kp * (refs[..., 0] - d) + self.kv * (refs[..., 1] - dd)
        F = F + pull[..., 0] @ self.to_gantry
        F = F + (pull[..., 1] * nods + pull[..., 2] * sag[:, self.on_gantry] * slope) @ self.to_trolley
        bend = -self.k_girder * s - self.c_girder * ds + self.held
        bend = bend + (pull[..., 2] * sine - pull[..., 1] * self.lever * slope) @ self.to_gantry[:, : len(self.cranes)]
        c, trolleys = self.under, slice(len(self.cranes), None)
        phase, m = pi * d[:, trolleys] / self.span[c], self.drive_mass[trolleys]
        shape = np.sin(phase)
        F[:, trolleys] -= m * self.g * sag[:, c] * pi / self.span[c] * np.cos(phase)  # down the slope
        mass = self.m_girder + (m * shape**2) @ self.to_girder
        return F / self.drive_mass, (bend - (m * self.g * shape) @ self.to_girder) / mass

    def _hang(self, x, dx):
        """Forces of the slings on the beams."""
        distance = x[:, self.lugs] - x[:, self.beams]
        l = np.sqrt((distance * distance).sum(-1))
        unit = distance / l[..., None]
        rate = ((dx[:, self.lugs] - dx[:, self.beams]) * unit).sum(-1)
        self.sling_stretch = l - self.sling_L
        pulled = np.maximum(0.0, self.sling_k * self.sling_stretch + self.sling_d * rate)
        return np.where(self.sling_stretch > 0.0, pulled, 0.0)[..., None] * unit

    def _stand(self, x, dx, bent):
        """Forces of the supports on pads, and how fast their tops bend: as the block moves, or as sliding lets them."""
        x, dx = x[:, self.pads], dx[:, self.pads]
        depth = self.pad_z - x[..., 2]
        carried = self.pad_k * depth - self.pad_d * dx[..., 2]
        N = np.where(depth > 0.0, np.maximum(0.0, carried), 0.0)
        self.standing = np.where(depth > 0.0, carried, -1.0)
        k, d = self.pad_kt[:, None], self.pad_dt[:, None]
        held = k * bent + d * dx[..., :2]
        size = np.sqrt((held * held).sum(-1)) + TINY
        rub = held * np.minimum(1.0, self.pad_mu * N / size)[..., None]
        return np.concatenate([-rub, N[..., None]], -1), (rub - k * bent) / d

    def _hinged(self, x, arm, R, v, w, force, moment, inverse):
        """Accelerations with the five multipliers of each hinge: ends meet, e_x and e_z of one stay across e_y = f."""
        n, loaders = self.n, slice(0, 2 * self.n)

        def both(a):
            """Of upper and lower, (B, 2, n, ...)."""
            return a[:, loaders].reshape(len(a), n, 2, *a.shape[2:]).swapaxes(1, 2)

        r = arm[:, self.hinges].reshape(len(x), 2, n, 3)
        omega, frames = both(w), both(R)
        f, e = frames[:, 1, ..., 1], frames[:, 0][..., ::2].transpose(0, 3, 1, 2)  # (B, n, 3), (B, 2, n, 3)
        turn = self.friction[:, None] * ((omega[:, 1] - omega[:, 0]) * frames[:, 0, ..., 1]).sum(-1, keepdims=True)
        turn = turn * frames[:, 0, ..., 1]
        moment[:, 0 : 2 * n : 2] += turn
        moment[:, 1 : 2 * n : 2] -= turn
        a, alpha = force / self.mass[:, None], turned(inverse, moment)
        across = cross(e, f[:, None]).swapaxes(1, 2)  # (B, n, 2, 3)
        levers = hat(r)
        G = np.zeros((len(x), n, 5, 12))  # on v and w of upper, then of lower
        G[:, :, :3, 0:3], G[:, :, :3, 6:9] = np.eye(3), -np.eye(3)
        G[:, :, :3, 3:6], G[:, :, :3, 9:12] = -levers[:, 0], levers[:, 1]
        G[:, :, 3:, 3:6], G[:, :, 3:, 9:12] = across, -across
        places = x[:, self.hinges].reshape(len(x), 2, n, 3)
        gap = np.concatenate([places[:, 0] - places[:, 1], (e * f[:, None]).sum(-1).swapaxes(1, 2)], -1)
        motion = np.stack([both(v), omega], 3).swapaxes(1, 2).reshape(len(x), n, 12)
        bias = cross(omega, cross(omega, r))
        # d2(e.f) = e''.f + 2 e'.f' + e.f'' with e'' = alpha x e + w x (w x e)
        wu, wl = omega[:, :1], omega[:, 1]
        de, df = cross(wu, e), cross(wl, f)
        twist = (cross(wu, de) * f[:, None]).sum(-1) + 2.0 * (de * df[:, None]).sum(-1)
        twist = twist + (e * cross(wl, df)[:, None]).sum(-1)
        bias = np.concatenate([bias[:, 0] - bias[:, 1], twist.swapaxes(1, 2)], -1)
        wanted = -bias - 2.0 * BAUMGARTE * turned(G, motion) - BAUMGARTE**2 * gap
        W = np.zeros((len(x), n, 12, 12))
        W[:, :, self.straight, self.straight] = self.lightness
        W[:, :, 3:6, 3:6], W[:, :, 9:12, 9:12] = inverse[:, 0 : 2 * n : 2], inverse[:, 1 : 2 * n : 2]
        free = np.stack([both(a), both(alpha)], 3).swapaxes(1, 2).reshape(len(x), n, 12)
        WG = W @ np.swapaxes(G, -1, -2)
        pull = np.linalg.solve(G @ WG, (wanted - turned(G, free))[..., None])
        held = (free + (WG @ pull)[..., 0]).reshape(len(x), n, 2, 2, 3)
        a[:, loaders], alpha[:, loaders] = (held[..., i, :].reshape(len(x), 2 * n, 3) for i in (0, 1))
        return a, alpha
