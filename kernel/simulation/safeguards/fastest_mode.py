"""The fastest motion of a scene as it stands: how fast, which body moves in it, which law holds that body.

Asked when a step is refused or has collapsed, never in a run.  The scene is linearised about its state with all
discrete states as they are; the shape is that of the eigenvalue farthest from zero.  The law is the one whose stored
energy curves most along the shape, or which makes most heat of it, counted per radian.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from heavylift.kernel.model.evaluation import Evaluation, evaluate
from heavylift.kernel.model.kinetic_energy import KineticShares
from heavylift.kernel.simulation.native.native_state import NativeState

ASIDE = 1e-4  # [m, rad] along the shape to either side


@dataclass(frozen=True)
class Fastest:
    """Frequency |s|/2 pi [Hz], damping ratio, the body with most kinetic energy, the law that holds it, or ""."""

    frequency: float
    damping: float
    body: str
    law: str

    @property
    def told(self) -> str:
        """As part of a sentence."""
        held = f" on '{self.law}'" if self.law else ""
        kind = "decays" if self.damping >= 1.0 else "swings"
        return f"'{self.body}'{held} {kind} at {self.frequency:.3g} Hz"


def told_fastest(native: NativeState, J: np.ndarray | None = None) -> str:
    """The fastest mode of the scene as it stands, as part of a sentence, or ""."""
    mode = fastest(native, native.jacobian() if J is None else J)
    return mode.told if mode else ""


def fastest(native: NativeState, J: np.ndarray) -> Fastest | None:
    """Of J (n, n), the derivative of the rates of coordinates and velocities; None if nothing holds anything."""
    p, y = native.program, native.state.copy()
    if not (np.isfinite(J).all() and np.isfinite(y).all()):
        return None
    s, vectors = np.linalg.eig(J)
    k = int(np.argmax(np.abs(s)))
    size = float(np.abs(s[k]))
    shape = vectors[:, k] * np.exp(-1j * np.angle(vectors[:, k][np.argmax(np.abs(vectors[: p.nq, k]))]))
    if size == 0.0 or not np.abs(shape[p.nq :]).any():
        return None
    bodies, _ = KineticShares(p, native.P, y[: p.nq]).shares(shape[p.nq :])
    aside = np.real(shape[: p.nq])
    aside *= ASIDE / max(float(np.abs(aside).max()), 1e-300)
    speed = np.real(shape[p.nq :] / s[k])
    speed *= ASIDE * size / max(float(np.abs(speed).max()), 1e-300)

    def at(move: float, rush: float) -> Evaluation:
        there = y.copy()
        there[: p.nq] += move * aside
        there[p.nq : p.nq + p.nv] = rush * speed
        return evaluate(p, native["t"], there, native.P, native.among())

    with np.errstate(all="ignore"):  # what is not finite stays out of the ranking below
        here, ahead, back, fast, slow = at(0.0, 0.0), at(1.0, 0.0), at(-1.0, 0.0), at(0.0, 1.0), at(0.0, -1.0)
        share: dict[str, float] = {}
        for i, label in enumerate(p.stores):
            curved = ahead.stored[label] - 2.0 * here.stored[label] + back.stored[label]
            heated = (fast.dy[p.nq + p.nv + i] + slow.dy[p.nq + p.nv + i]) / size
            share[label[1]] = share.get(label[1], 0.0) + float(np.nan_to_num(abs(curved) + abs(heated)))
    law = max(share, key=lambda n: (share[n], n)) if share else ""
    return Fastest(size / (2.0 * pi), float(-s[k].real / size), bodies[0][0], law if share.get(law, 0.0) > 0.0 else "")
