"""Small motions about a pose: frequencies, damping and shapes of the linearised scene (Shabana 2005, chapter 3).

With x = (small displacement, velocity) in the tangent space, x' = [[0, 1], [da/dq, da/dv]] x; its eigenvalues are s =
-zeta w +- i w sqrt(1 - zeta^2). States of radiation are added to x; of all motions those count, as many as without
these states, of which the least energy is in them. Taut, closed and sticking laws stay as they are.

Results of statics and modes as text, and as plain data in SI units.
"""

from collections import Counter
from dataclasses import dataclass
from math import inf, pi
from typing import TYPE_CHECKING, Any

import numpy as np
from heavylift.kernel.model.reactions.joint_reactions import COMPONENTS, Reactions
from heavylift.kernel.model.tangent_stiffness import KineticShares

from .equilibrium import Equilibrium
from .poses import Poses

if TYPE_CHECKING:
    from heavylift.kernel.simulation.simulation import Simulation

GROWS = 0.1  # [1/s] below which growth is rounding, too: a mast of a kilometre falls faster
SPEED_STEP = 1e-3  # [m/s, rad/s]
FREE = 1e-2  # [rad/s] below which a motion has no frequency but only rounding


@dataclass(frozen=True)
class NaturalMode:
    """An oscillation: natural frequency w/2 pi [Hz] and damping ratio zeta (negative: growing).

    shape: (n_v,) complex velocities, the largest 1; bodies, joints: share of the kinetic energy, largest first;
    momenta: complex (3,) of each body, over the root of twice the kinetic energy [kg^0.5].
    """

    frequency: float
    damping: float
    shape: np.ndarray
    bodies: tuple[tuple[str, float], ...]
    joints: tuple[tuple[str, float], ...]
    momenta: dict[str, np.ndarray]


@dataclass(frozen=True)
class Modes:
    """All small motions about a pose: oscillations, and motions that decay or grow without oscillating.

    Oscillations by frequency; decay rates [1/s] (negative: growing); number of degrees of freedom without stiffness.
    """

    oscillations: tuple[NaturalMode, ...]
    decays: tuple[float, ...]
    free: int

    @property
    def growth(self) -> float:
        """The growth rate [1/s] of the fastest unstable motion; 0 if the pose is stable."""
        rates = [-x for x in self.decays] + [-2.0 * pi * m.frequency * m.damping for m in self.oscillations]
        return max([x for x in rates if x > GROWS], default=0.0)


def modes(simulation: "Simulation") -> Modes:
    """Return the modes of small motions of a simulation about its pose, with drives stopped; the pose should be at rest
    (see `equilibrium`)."""
    poses = Poses.stopped(simulation)
    return modes_at(poses, poses.q)


def modes_at(poses: Poses, q: np.ndarray) -> Modes:
    """Return the modes of small motions of a simulation about a pose q (nq,), with drives stopped."""
    simulation = poses.simulation
    allowed = poses.basis(q)
    basis = np.eye(len(poses.free)) if allowed is None else allowed
    n = basis.shape[1]
    by_water, rates = poses.water(q)
    m, free = len(rates), len(poses.free)
    A = np.block([
        [np.zeros((n, n)), np.eye(n), np.zeros((n, m))],
        [basis.T @ poses.stiffness(q) @ basis, _damping(poses, q, basis), basis.T @ by_water],
        [np.zeros((m, n)), rates[:, :free] @ basis, rates[:, free:]],
    ])  # fmt: skip
    s, vectors = np.linalg.eig(A)
    poses.accelerations(q)  # leaves the simulation at its own pose
    energy = KineticShares(simulation.program, simulation.P, q)
    away, moved = np.zeros((2, len(s), simulation.program.nv), dtype=complex)
    away[:, poses.free], moved[:, poses.free] = (basis @ vectors[:n]).T, (basis @ vectors[n : 2 * n]).T
    water = (np.abs(vectors[2 * n :]) ** 2).sum(axis=0)
    rates_of = np.maximum(np.abs(s), FREE) ** 2  # with which it moves, or would if something held it
    shares = [e / (r * energy.energy(x)) if e else 0.0 for e, r, x in zip(water, rates_of, away, strict=True)]
    ordered = np.argsort([float(f"{x:.6e}") for x in shares], kind="stable")  # conjugates are alike
    counted = sorted(ordered[: 2 * n].tolist(), key=lambda k: abs(s[k]))
    found, decays = [], []
    for k in counted:
        if abs(s[k]) < FREE:
            continue
        if abs(s[k].imag) <= 1e-9 * abs(s[k]):
            decays.append(-float(s[k].real))
        elif s[k].imag > 0.0:
            shape = moved[k] / moved[k][np.argmax(np.abs(moved[k]))]
            w = abs(s[k])
            root = energy.energy(shape) ** 0.5
            momenta = {name: p / root for name, p in energy.momenta(shape).items()}
            found.append(NaturalMode(w / (2.0 * pi), -float(s[k].real / w), shape, *energy.shares(shape), momenta))
    return Modes(tuple(found), tuple(sorted(decays)), (sum(1 for k in counted if abs(s[k]) < FREE) + 1) // 2)


def _damping(poses: Poses, q: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """Return da/dv (n, n) [1/s] of the motions `basis` at pose q with zero speeds, by fourth-order differences."""
    h = SPEED_STEP

    def along(e: np.ndarray) -> np.ndarray:
        a = [poses.accelerations(q, x * h * e) for x in (1.0, -1.0, 2.0, -2.0)]
        difference: np.ndarray = 8.0 * (a[0] - a[1]) - (a[2] - a[3])
        return difference / (12.0 * h)

    n = basis.shape[1]
    matrix: np.ndarray = basis.T @ np.array([along(e) for e in basis.T]).reshape(n, len(basis)).T
    return matrix


MOVED = 0.05  # share of the energy from which a part is named
NAMED = 3  # parts of a mode
UNDETERMINED = "~"
CARRIED = 1e-6  # part of the largest force that counts as none


def modes_text(found: Modes) -> str:
    """Return a table of the oscillations, followed by the motions that do not oscillate, as text."""
    rows = [("", "frequency", "period", "damping", "moves most (share of kinetic energy)")]
    for n, m in enumerate(found.oscillations, 1):
        damping = 0.0 if abs(m.damping) < 1e-7 else m.damping
        rows.append(
            (str(n), f"{m.frequency:.4f} Hz", f"{1.0 / m.frequency:.3f} s", f"{100.0 * damping:.3f} %", _movers(m))
        )
    lines = _columns(rows, "rrrrl") if found.oscillations else ["nothing oscillates"]
    for rate, count in Counter(f"{d:.4g}" for d in found.decays).items():
        what = "dies away within" if float(rate) > 0.0 else "GROWS, unstable, within"
        times = f" ({count} times)" if count > 1 else ""
        lines.append(f"creep: {what} {1.0 / abs(float(rate)):.4g} s{times}")
    if found.free:
        lines.append(f"free: {found.free} motion{'s' * (found.free > 1)} without any restoring force")
    return "\n".join(lines)


def _movers(mode: NaturalMode) -> str:
    bodies = [(name, share) for name, share in mode.bodies[:NAMED] if share >= MOVED]
    return ", ".join(f"{name} {100.0 * share:.0f} %" for name, share in bodies) + f"; by {mode.joints[0][0]}"


def modes_data(found: Modes) -> dict[str, object]:
    """Return modes as data: frequencies, damping ratios, energy shares of bodies and joints, and mode shapes.

    `pulsation`: angular frequency [rad/s]; shapes as amplitude and phase [rad].
    """
    return {
        "modes": [
            {
                "frequency": m.frequency,
                "pulsation": 2.0 * pi * m.frequency,
                "damping": m.damping,
                "bodies": dict(m.bodies),
                "joints": dict(m.joints),
                "amplitude": np.abs(m.shape).tolist(),
                "phase": np.angle(m.shape).tolist(),
            }
            for m in found.oscillations
        ],
        "decays": list(found.decays),
        "free": found.free,
    }


def statics_text(found: Equilibrium, reactions: Reactions, growth: float) -> str:
    """Return rope tensions, pad forces and joint reactions as text; "~" marks statically indeterminate forces.

    `growth`: growth rate of a perturbation [1/s].
    """
    lines = [f"at rest after {found.steps} step{'s' * (found.steps != 1)}"]
    if growth:
        lines.append(f"unstable: a small push grows e-fold in {1.0 / growth:.3g} s")
    tensions = found.tensions | reactions.tensions
    for title, values, empty in (("rope", tensions, "slack"), ("support", found.supports, "open")):
        if values:
            shared = [UNDETERMINED * (title == "rope" and n in reactions.tensions) for n in values]
            message = (f"{x / 1e3:.3f} kN" if x > 0.0 else empty for x in values.values())
            forces = [(n, mark + x) for n, mark, x in zip(values, shared, message, strict=True)]
            lines += ["", *_columns([(title, "force"), *forces], "lr")]
    rows: list[tuple[str, ...]] = [("joint", "force x", "y", "z  [kN]", "moment x", "y", "z  [kN m]")]
    largest = max((float(np.abs(f).max()) for r in reactions.values() for f in (r.force, r.moment)), default=inf)
    for name, r in reactions.items():
        shown = [0.0 if abs(x) < CARRIED * largest else x / 1e3 for x in (*r.force, *r.moment)]
        marks = (UNDETERMINED * (c in r.indeterminate) for c in COMPONENTS)
        rows.append((name, *(f"{mark}{x:.3f}" for mark, x in zip(marks, shown, strict=True))))
    lines += ["", *_columns(rows, "lrrrrrr")]
    if reactions.shared:
        lines += ["", f"{UNDETERMINED} {_choice(reactions)}"]
    return "\n".join(lines)


def _choice(reactions: Reactions) -> str:
    """Describe the statically indeterminate forces and the solution shown for them."""
    contacts = f"; nor do they determine the forces of the contacts {', '.join(reactions.contacts)}"
    shown = (
        "shown is the share with the smallest sum of squared forces and of squared moments over "
        f"{reactions.lever:.3g} m"
        if reactions.least
        else "shown is one of the possible shares"
    )
    return (
        "not determined by rigid bodies, since joints or ropes hold the same directions several times: stiffness and "
        f"clearances decide; {shown}{contacts * bool(reactions.contacts)}"
    )


def statics_data(found: Equilibrium, reactions: Reactions, growth: float) -> dict[str, object]:
    """Return the static state as data: coordinates, tensions, normal forces, joint reactions, growth rate.

    Forces [N] and moments [N m] in joint axes, growth rate [1/s]; statically indeterminate forces are listed.
    """
    return {
        "growth": growth,
        "coordinates": found.q.tolist(),
        "tensions": found.tensions | reactions.tensions,
        "supports": found.supports,
        "reactions": {
            n: {"force": r.force.tolist(), "moment": r.moment.tolist(), "indeterminate": list(r.indeterminate)}
            for n, r in reactions.items()
        },
        "indeterminate": {
            "joints": [n for n, r in reactions.items() if r.indeterminate],
            "ropes": list(reactions.tensions),
            "contacts": list(reactions.contacts),
            "shown": _choice(reactions) if reactions.shared else None,
        },
    }


def _columns(rows: list[Any], sides: str) -> list[str]:
    widths = [max(len(r[c]) for r in rows) for c in range(len(sides))]
    padded = [
        [x.rjust(w) if side == "r" else x.ljust(w) for x, w, side in zip(r, widths, sides, strict=True)] for r in rows
    ]
    return ["  ".join(r).rstrip() for r in padded]
