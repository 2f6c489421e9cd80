"""Check of a fixed step that is unstable or does not resolve a mode, the fastest motion of a scene, and the run's
energy balance.

A step that distorts most of the motion is refused, since the result would not be the motion of the scene. At events,
and when a rope has become much shorter, the scene is linearised; each oscillation has the amplitude that the present
state gives it about its equilibrium. The share of energy in oscillations that the step does not resolve must not exceed
WRONG; each is weighted with its error after RADIANS, or after it has decayed if that is sooner, but at least after one
step. Below WRONG, a note states the distorted oscillations. If a step is refused or has collapsed, the fastest motion
is named with its body and with the law that holds it: the law whose stored energy curves most along the motion, or
which produces most heat from it, per radian.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

import numpy as np
from heavylift.kernel.description.findings import Note
from heavylift.kernel.errors import KernelError
from heavylift.kernel.methods.method import Method
from heavylift.kernel.methods.stability import Balance, bent, check_step, missed, unresolved
from heavylift.kernel.model.evaluation import Evaluation, evaluate
from heavylift.kernel.model.tangent_stiffness import KineticShares
from heavylift.kernel.simulation.native.native_state import NativeState

ASIDE = 1e-4  # [m, rad] along the shape to either side


@dataclass(frozen=True)
class Fastest:
    """The fastest mode of a scene: frequency [Hz], damping ratio, the body that moves most, and the stiff force law."""

    frequency: float
    damping: float
    body: str
    law: str

    @property
    def message(self) -> str:
        """The fastest mode in words: its body, its stiff force law, and its frequency [Hz]."""
        held = f" on '{self.law}'" if self.law else ""
        kind = "decays" if self.damping >= 1.0 else "swings"
        return f"'{self.body}'{held} {kind} at {self.frequency:.3g} Hz"


def fastest_mode_text(native: NativeState, J: np.ndarray | None = None) -> str:
    """Return the fastest mode of the scene in its present state, as part of a sentence, or "" if there is none."""
    mode = fastest(native, native.jacobian() if J is None else J)
    return mode.message if mode else ""


def fastest(native: NativeState, J: np.ndarray) -> Fastest | None:
    """Return the fastest mode of the Jacobian J (n, n) of the rates of q and v; None if it is not stiff."""
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
    lateral = np.real(shape[: p.nq])
    lateral *= ASIDE / max(float(np.abs(lateral).max()), 1e-300)
    speed = np.real(shape[p.nq :] / s[k])
    speed *= ASIDE * size / max(float(np.abs(speed).max()), 1e-300)

    def at(move: float, rush: float) -> Evaluation:
        there = y.copy()
        there[: p.nq] += move * lateral
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


RADIANS = 30.0  # five swings
WRONG = 0.25
CALM = 1e-3  # [m/s] what moves no faster is at rest
HALVINGS = 30  # of the bracket around the longest step that would do
SHORTER = 0.8  # of its length: a rope that much shorter is a quarter stiffer


class StepCheck:
    """Check whether a fixed `step` [s] stays stable and accurate while ropes become shorter."""

    def __init__(self, native: NativeState, step: float) -> None:
        self._native, self._step = native, step
        self.lengths = np.zeros(len(native.program.system.ropes))  # rope lengths at the last check [m]
        self.missed = False  # whether a note about a distorted mode was added

    def see(self, t_ns: int, row: np.ndarray) -> None:
        """Check the fixed step at a sample row if a rope has become much shorter since the last check."""
        if (row[self._native.method.row_layout.at["length"]] < SHORTER * self.lengths).any():
            self.check(t_ns, row)

    def check(self, t_ns: int, row: np.ndarray) -> None:
        """Raise KernelError if the fixed step is unstable at a sample row; add a note about a distorted mode."""
        native, at = self._native, self._native.method.row_layout.at
        nq, nv, now = native.program.nq, native.program.nv, native.X.copy()
        self.lengths = row[at["length"]].copy()
        native.state[:nq], native.state[nq : nq + nv] = row[at["q"]], row[at["v"]]
        native.set(t=native.local(t_ns))
        try:
            self._check_stable(t_ns)
        finally:
            native.X[:] = now

    def _check_stable(self, t_ns: int) -> None:
        t, method, J = t_ns * 1e-9, self._native.method.method, self._native.jacobian()

        def message() -> str:
            return fastest_mode_text(self._native, J) or "the scene is unstable"

        check_step(method, J, self._step, self._native.program.nq, t, message)
        _check_followed(self._native, J, self._step, t, message)
        blind, swings = unresolved(method, J, self._step)
        if blind and not self.missed:
            self.missed = True
            seen = (
                f"step {self._step:g} s at {t:.3f} s: method '{method.name}' is out of step by a tenth of a swing "
                f"{f'after {swings:.0f} swings' if swings > 1.0 else 'at once'} with oscillations from {blind:.3g} Hz "
                f"upwards, {message()}: do not trust what depends on those; choose a shorter step to see them"
            )
            self._native.notes.append(Note(t_ns, seen))


def _check_followed(native: NativeState, J: np.ndarray, step: float, t: float, message: Callable[[], str]) -> None:
    """Raise KernelError if a fixed step [s] distorts too much motion at t [s]; `message`: the fastest mode."""
    method = native.method.method
    if not np.isfinite(J).all() or not any(bent(method, s, step) for s in np.linalg.eigvals(J)):
        return
    modes = _energies(native, J)
    if not _wrong(method, modes, step) > WRONG:
        return
    low, high = 0.0, step
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _wrong(method, modes, middle) > WRONG else (middle, high)
    share = sum(e for s, e in modes if bent(method, s, step))
    raise KernelError(
        f"step {step:g} s at {t:.3f} s: method '{method.name}' does not follow {100.0 * share:.0f} % of the energy of "
        f"the motion, {message()}; choose at most {0.9 * low:.2g} s, or give no step"
    )


def _energies(native: NativeState, J: np.ndarray) -> list[tuple[complex, float]]:
    """Return the eigenvalues of the oscillations, each with its share of the energy of motion."""
    p, y = native.program, native.state.copy()
    n, speeds = p.nq + p.nv, slice(p.nq, p.nq + p.nv)
    rate = native.rate(native.state.copy())[0][:n]
    s, V = np.linalg.eig(J)
    amplitudes = np.linalg.lstsq(V, rate.astype(complex), rcond=None)[0]
    kinetic = KineticShares(p, native.P, y[: p.nq])
    rest, found = y[speeds].astype(complex), list[tuple[complex, float]]()
    for k in np.flatnonzero(s.imag > 0.0):
        shape = 2.0 * amplitudes[k] / s[k] * V[speeds, k]
        found.append((complex(s[k]), kinetic.energy(shape)))
        rest -= shape.real
    total = sum(e for _, e in found) + kinetic.energy(rest) + sum(b.mass for b in p.system.bodies) * CALM**2
    return [(x, e / total) for x, e in found]


def _wrong(method: Method, modes: list[tuple[complex, float]], step: float) -> float:
    """Return the share of energy in oscillations that the step distorts, weighted as the module describes."""

    def error(s: complex) -> float:
        lasts = max(min(RADIANS, abs(s) / max(-s.real, 1e-300)), abs(s) * step)
        return min(1.0, missed(method, s, step) * lasts)

    return sum(e * error(s) for s, e in modes if bent(method, s, step))


class EnergyCheck:
    """Check of a run's energy balance since the last event; `step`: the fixed step [s], or None."""

    def __init__(self, native: NativeState, tolerance: float, step: float | None) -> None:
        self._native = native
        name = native.method.method.name
        self._what = f"method '{name}'" if step is None else f"step {step:g} s"
        self.balance = Balance(tolerance if step is None else 0.0, native.method.method.implicit)
        p, self._at = native.program, native.method.row_layout.at
        columns = np.arange(native.method.columns)
        self._kinetic = int(columns[self._at["kinetic"]])
        self._parts = np.concatenate([np.ravel(columns[self._at[k]]) for k in ("potential", "stored", "accounts")])
        works = [what == "work" for what, _ in p.accounts]
        self._signs = np.where([False] * (1 + len(p.stores)) + works, -1.0, 1.0)
        self._mass = sum(b.mass for b in p.system.bodies)
        self._softness = np.array([0.5 / r.EA for r in p.system.ropes])  # of a metre: energy of a tension squared

    def energies(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return kinetic energies; potential, stored, heat and negative work energies of rows (..., columns) [J]."""
        return rows[..., self._kinetic], rows.take(self._parts, axis=-1) * self._signs

    def begin(self, row: np.ndarray) -> None:
        """Restart the energy balance after an event or a command."""
        kinetic, parts = self.energies(row)
        self.balance.begin(float(kinetic), parts)

    def see(self, rows: np.ndarray) -> None:
        """Add the energies of sample rows (n, columns) to the energy balance."""
        self.balance.see(*self.energies(rows))

    def check(self, row: np.ndarray, t: float) -> None:
        """Raise KernelError for energy created or lost since the last event; t: simulation time [s]."""
        before = self.balance.lost
        kinetic, parts, slip, held = self._reading(row)
        self.balance.check(f"{self._what} at {t:.3f} s", float(kinetic), parts, float(slip), float(held))
        if self.balance.lost > 0.0 and not before:
            message = (
                f"{self._what} at {t:.3f} s: {self.balance.lost:.3g} J, more than half of what was turned over, "
                "are gone with motions too fast for the steps; choose shorter ones to see those"
            )
            self._native.notes.append(Note(round(t * 1e9), message))

    def fine(self, rows: np.ndarray) -> bool:
        """Return whether energy is balanced in all sample rows (n, columns); if so, add these rows to the balance."""
        if self.balance.strict:
            self.see(rows)
            return True
        return self.balance.fine(*self._reading(rows))

    def _reading(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return the energies of `energies`, the effect of possible step errors, the largest rope energy (...) [J]."""
        kinetic, parts = self.energies(rows)
        weight, mass = self._mass * abs(self._native.program.system.gravity), self._mass
        size = kinetic + np.abs(parts).sum(axis=-1) + np.sqrt(2.0 * kinetic * mass) + weight
        return kinetic, parts, rows[..., self._at["steps"]] * size, self._held(rows, rows[..., self._at["peak"]])

    def end(self, t: float) -> None:
        """Close the energy balance before an event or a command."""
        native = self._native
        row = native.raw()
        kinetic, parts = self.energies(row)
        self.balance.end(float(kinetic), parts)
        highest = native.part("top" if "top" in native.at else "peak")
        if part := self.balance.strayed(float(self._held(row, highest))):
            message = (
                f"{self._what} at {t:.3f} s: {100.0 * part:.0f} % of the energy turned over has "
                "come or gone with the errors that its tolerance allows; do not trust tensions, or choose a smaller one"
            )
            native.notes.append(Note(round(t * 1e9), message))

    def _held(self, rows: np.ndarray, highest: np.ndarray) -> np.ndarray:
        """Return the largest elastic energy of a rope (...) [J], computed from the peak tensions (..., ropes) [N]."""
        T = highest[..., : len(self._softness)]
        held: np.ndarray = (T * T * rows[..., self._at["length"]] * self._softness).max(axis=-1, initial=0.0)
        return held
