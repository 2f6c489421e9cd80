"""What the kernel shows of a run: the columns of a sample and how raw rows of the native table become them.

Columns are grouped in channels of one topic and unit.  Poses are (x, y, z, qx, qy, qz, qw) of a body's frame in the
world; the energy channel carries the balance: kinetic + potential + stored - work + heat is constant.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from heavylift.kernel.model.program import Program
from heavylift.kernel.multibody.graph import coordinate_names

from .native_functions import Stepping

__all__ = ["Channel", "channels", "published"]


POSE = "m, quaternion x y z w"


@dataclass(frozen=True)
class Channel:
    """Columns start to stop of a sample under one topic."""

    topic: str
    names: tuple[str, ...]
    unit: str
    start: int
    stop: int


def shown(p: Program) -> dict[tuple[str, str], list[tuple[str, int]]]:
    """Topic and unit of what forces show -> names with their columns in `row.shown`."""
    groups: dict[tuple[str, str], list[tuple[str, int]]] = {}
    for i, (_, _, x) in enumerate(p.columns["shown"]):
        groups.setdefault((x.topic, x.unit), []).append((x.name, i))
    return groups


def channels(method: Stepping) -> list[Channel]:
    """The channels of a scene in the order of `published`'s columns."""
    p = method.program
    s = p.system
    ropes, straight = (tuple(r.name for r in group) for group in (s.ropes, s.straight_ropes))
    winches = tuple(r.name for r in s.ropes if r.winch)
    positions, velocities = coordinate_names(p.graph)
    groups: list[tuple[str, tuple[str, ...], str]] = [
        ("joint/position", tuple(positions), "m or rad"),
        ("joint/velocity", tuple(velocities), "m/s or rad/s"),
        ("rope/tension", straight, "N"),
        ("rope/peak", straight, "N"),
        ("rope/peak_time", straight, "s"),
        ("rope/length", straight, "m"),
        ("rope/length_rate", ropes, "m/s"),
        ("rope/elongation", ropes, "m"),
        ("hook/load", winches, "N"),
        ("support/force", tuple(u.name for u in s.supports), "N"),
        ("rigid/slack", tuple(r.name for r in s.rigid_ropes), "m"),
        ("contact/force", tuple(c.name for c in s.contacts), "N"),
        ("loop/force", tuple(f"{j.name}.{x}" for j in p.graph.loops for x in "xyz"), "N"),
        ("loop/moment", tuple(f"{j.name}.{x}" for j in p.graph.loops for x in "xyz"), "N m"),
        ("energy", ("kinetic", "potential", "stored", "work", "heat"), "J"),
        ("account", tuple(f"{name}.{what}" for what, name in p.accounts), "J"),
    ]
    groups += [(topic, tuple(n for n, _ in columns), unit) for (topic, unit), columns in shown(p).items()]
    groups += [
        (f"pose/{k.body.name}", ("x", "y", "z", "qx", "qy", "qz", "qw"), "m, quaternion x y z w") for k in p.graph.links
    ]
    out, at = [], 0
    for topic, names, unit in groups:
        if names:
            out.append(Channel(topic, names, unit, at, at + len(names)))
            at += len(names)
    return out


def published(method: Stepping, rows: np.ndarray) -> np.ndarray:
    """(n, columns) samples from (n, method.columns) raw rows."""
    from scipy.spatial.transform import (
        Rotation,  # 0.3 s to import: not before the first sample, so that runs start fast
    )

    p, at = method.program, method.row_layout.at
    part = {name: rows[:, i if isinstance(i, slice) else slice(i, i + 1)] for name, i in at.items()}
    winches = [i for i, r in enumerate(p.system.ropes) if r.winch]
    works = [i for i, (what, _) in enumerate(p.accounts) if what == "work"]
    heats = [i for i, (what, _) in enumerate(p.accounts) if what == "heat"]
    energy = [part["kinetic"], part["potential"]]
    sums = (part["stored"], part["accounts"][:, works], part["accounts"][:, heats])
    n = len(rows)
    energy += [sum(x.T, start=np.zeros(n))[:, None] for x in sums]  # one by one: equal in any batch
    poses = part["poses"].reshape(n, -1, 12)
    quaternions = Rotation.from_matrix(poses[:, :, 3:].reshape(-1, 3, 3)).as_quat(canonical=True)
    pose = np.concatenate([poses[:, :, :3], quaternions.reshape(n, -1, 4)], axis=2).reshape(n, -1)
    columns = [part[k] for k in ("q", "v", "tension", "pull", "peak", "peak_time", "length", "span")]
    columns += [part[k] for k in ("length_rate", "elongation")]
    forces = [i for group in shown(p).values() for _, i in group]
    loads = part["loop"].reshape(n, len(p.graph.loops), 2, 3)
    columns += [
        part["tension"][:, winches],
        part["normal"],
        part["slack"],
        part["pressing"],
    ]
    columns += [loads[:, :, i].reshape(n, 3 * len(p.graph.loops)) for i in range(2)]
    columns += [*energy, part["accounts"], part["shown"][:, forces], pose]
    return np.ascontiguousarray(np.concatenate(columns, axis=1))
