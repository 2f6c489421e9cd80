"""What statics and modes found, as text for people and as plain data for programs; SI units in the data."""

from collections import Counter
from math import inf, pi
from typing import Any

import numpy as np
from heavylift.kernel.model.reactions.joint_reactions import COMPONENTS, Reactions

from .equilibrium import Equilibrium
from .modes import Modes, NaturalMode

MOVED = 0.05  # share of the energy from which a part is named
NAMED = 3  # parts of a mode
UNDETERMINED = "~"
CARRIED = 1e-6  # part of the largest force that counts as none


def modes_text(found: Modes) -> str:
    """A table of oscillations, followed by other motions."""
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
    """Frequencies [Hz], pulsations [rad/s], damping ratios, shares and shapes (amplitude and phase [rad])."""
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
    """Tensions, pad forces and joint reactions; `growth` of a perturbation [1/s].

    "~" stands before what rigid bodies do not determine.
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
    """Undetermined forces, and the solution shown instead."""
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
    """Coordinates, tensions and normal forces [N], joint reactions in joint axes [N, N m], growth rate [1/s],
    undetermined forces."""
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
