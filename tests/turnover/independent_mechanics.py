"""Mechanics of a recorded run, recomputed from the scene's numbers, poses, velocities and unstretched lengths.

Written from the text of the model (ropes are tension-only springs with a damper between points of bodies), not from
the kernel: plain NumPy, world axes, nothing of heavylift.  Arrays are (n, 3) over the n samples, SI units.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from stock_reader import Array, Reading


@dataclass(frozen=True)
class Body:
    """Rotation (n, 3, 3), place, velocity, angular velocity, in world axes; mass, its centre, its moments."""

    R: Array
    p: Array
    v: Array
    w: Array
    mass: float
    com: Array
    moments: Array

    def place(self, x: Any) -> Array:
        """Where a point of the body is; x (3,) or (n, 3) in its frame."""
        return self.p + _turned(self.R, x)

    def velocity(self, x: Any) -> Array:
        """How fast a point of the body moves."""
        return self.v + np.cross(self.w, _turned(self.R, x))


@dataclass(frozen=True)
class Pull:
    """Tension (n,) of a rope, what it is or would be while taut, its stretch; per line, force and direction (n, 3) at
    its lower end; its energy and powers [W]."""

    tension: Array
    if_taut: Array
    stretch: Array
    forces: list[Array]
    directions: list[Array]
    stored: Array
    heating: Array
    winding: Array

    @property
    def force(self) -> Array:
        """(n, 3) what the rope does to the body at its lower end."""
        return sum(self.forces)  # type: ignore[return-value]


class Mechanics:
    """Bodies and ropes of a yard of cranes, loaders and a block."""

    def __init__(self, reading: Reading) -> None:
        self.reading, self.scene = reading, reading.scene
        self.g: float = self.scene.get("gravity", 9.80665)
        machines = self.scene["machines"]
        ropes = {rope["name"]: rope for m in machines for rope in m["system"].get("ropes", [])}
        hooks = [hook["rope"] for m in machines for hook in m.get("hooks", [])]
        self.hook_ropes: dict[str, dict[str, Any]] = {name: ropes[name] for name in hooks}
        self.slings: dict[str, dict[str, Any]] = {
            tie["rope"]: {**ropes[tie["rope"]], "loader": m["name"], "lug": tie.get("lug", ""), "beam": tie["upper"]}
            for m in machines
            for tie in m.get("ties", [])
        }
        (cargo,) = (cargo for m in machines for cargo in m.get("cargo", []))
        self.lugs = {name: np.array(p) for name, p in cargo["lugs"].items()}

    @cached_property
    def bodies(self) -> dict[str, Body]:
        """All bodies by name."""
        found: dict[str, Body] = {}
        n = len(self.reading.t)
        zero = np.zeros((n, 3))

        def take(name: str, v: Array, w: Array, inertia: dict[str, Any]) -> None:
            pose = self.reading.pose[name]
            com, moments = np.array(inertia.get("com", (0.0, 0.0, 0.0))), np.diag(inertia["inertia"])
            found[name] = Body(_rotation(pose[:, 3:]), pose[:, :3], v, w, inertia["mass"], com, moments)

        def rate(name: str) -> Array:
            return self.reading.column("/joint/velocity", name)

        def free(name: str, joint: str, inertia: dict[str, Any]) -> None:
            R = _rotation(self.reading.pose[name][:, 3:])
            v, w = (np.stack([rate(f"{joint}.{k}{c}") for c in "xyz"], axis=1) for k in "vw")
            take(name, _turned(R, v), _turned(R, w), inertia)

        machines = self.scene["machines"]
        for crane in (m for m in machines if any(row.get("stiffness") for row in m.get("bends", ()))):
            c, own = crane["name"], {body["name"]: body for body in crane["system"]["bodies"]}
            along = np.outer(rate(f"{c}.gantry.speed"), (1.0, 0.0, 0.0))
            take(f"{c}.main", along, zero, own[f"{c}.main"])
            for trolley in ("upper", "lower"):
                across = np.outer(rate(f"{c}.{trolley}-slide.speed"), (0.0, 1.0, 0.0))
                take(f"{c}.{trolley}", along + across, zero, own[f"{c}.{trolley}"])
        for loader in (m for m in machines if m.get("latches")):
            name, (top, low) = loader["name"], loader["system"]["bodies"]
            free(f"{name}.upper", f"{name}.free", top)
            upper = found[f"{name}.upper"]
            turning = upper.w + _turned(upper.R, (0.0, 1.0, 0.0)) * rate(f"{name}.hinge.rate")[:, None]
            take(f"{name}.lower", upper.velocity(loader["system"]["joints"][1]["p_PJ"]), turning, low)
        (block,) = (body for m in machines for body in m["system"]["bodies"] if body["name"] == "block")
        free("block", "block.free", block)
        return found

    @cached_property
    def lug_of(self) -> dict[str, Array]:
        """(n, 3) the lug of each sling over time, NaN while it is off: scene, then the hook and unhook events."""
        n, times = len(self.reading.t), np.array(self.reading.t_ns)
        found = {}
        for name, sling in self.slings.items():
            lug = np.tile(self.lugs[sling["lug"]], (n, 1))
            for event in self.reading.said(sling["loader"], "input"):
                if event["type"] in ("Hook", "Unhook") and event["value"]["rope"] == name:
                    lug[times >= event["t_ns"]] = event["value"]["b"] if event["type"] == "Hook" else np.nan
            found[name] = lug
        return found

    @cached_property
    def pulls(self) -> dict[str, Pull]:
        """What every hook rope and sling does, by name."""
        found = {}
        for name, rope in self.hook_ropes.items():
            lines = [(x["a"]["body"], x["a"]["p"], x["b"]["body"], x["b"]["p"], x["share"]) for x in rope["lines"]]
            found[name] = self._pull(rope, lines)
        for name, sling in self.slings.items():
            beam = sling["beam"]
            found[name] = self._pull(sling, [(beam["body"], beam["p"], "block", self.lug_of[name], 1.0)])
        return found

    def _pull(self, rope: dict[str, Any], lines: list[tuple[Any, ...]]) -> Pull:
        L0 = self.reading.column("/rope/length", rope["name"])
        dL0 = self.reading.column("/rope/length_rate", rope["name"])
        length = rate = 0.0
        distances = []
        for a, p_a, b, p_b, share in lines:
            A, B = self.bodies[a], self.bodies[b]
            d = A.place(p_a) - B.place(p_b)
            l = np.linalg.norm(d, axis=1)
            u = d / l[:, None]
            length = length + share * l
            rate = rate + share * np.sum(u * (A.velocity(p_a) - B.velocity(p_b)), axis=1)
            distances.append((u, share))
        stretch = length - L0
        spring = rope["EA"] * stretch / L0 + rope["damping"] * (rate - dL0)
        taut = (stretch > 0.0) & (spring > 0.0)  # off: NaN compares false
        tension = np.where(taut, spring, 0.0)
        forces = [np.nan_to_num(u) * (share * tension)[:, None] for u, share in distances]
        strain = np.where(taut, rope["EA"] * (stretch / L0) ** 2 / 2, 0.0)
        heating = np.where(taut, rope["damping"] * (rate - dL0) ** 2, 0.0)
        return Pull(
            tension, spring, stretch, forces, [u for u, _ in distances], strain * L0, heating, -(tension + strain) * dL0
        )

    @cached_property
    def on_block(self) -> Array:
        """(n, 3) sum of the sling forces and of the normal forces of the supports on the block."""
        supports = self.reading.values["/support/force"].sum(axis=1)
        return sum(self.pulls[name].force for name in self.slings) + np.outer(supports, (0.0, 0.0, 1.0))

    @cached_property
    def hanging(self) -> list[Body]:
        """The block and all parts of the loaders: what hangs on the hook ropes."""
        return [body for name, body in self.bodies.items() if name == "block" or name.startswith("loader")]

    @cached_property
    def common(self) -> tuple[float, Array, Array]:
        """Mass of all that hangs, place and velocity (n, 3) of its centre."""
        mass = sum(b.mass for b in self.hanging)
        p = sum(b.mass * b.place(b.com) for b in self.hanging) / mass
        v = sum(b.mass * b.velocity(b.com) for b in self.hanging) / mass
        return mass, p, v

    @cached_property
    def acceleration(self) -> Array:
        """(n, 3) of the common centre, from the forces: hook ropes, supports (their normal forces), weight."""
        mass = self.common[0]
        supports = self.reading.values["/support/force"].sum(axis=1)
        force = sum(self.pulls[name].force for name in self.hook_ropes) + np.outer(supports, (0.0, 0.0, 1.0))
        return force / mass - np.array([0.0, 0.0, self.g])

    @cached_property
    def kinetic(self) -> Array:
        """(n,) [J] of all bodies."""
        total = np.zeros(len(self.reading.t))
        for b in self.bodies.values():
            spin = np.einsum("nji,nj->ni", b.R, b.w)
            total += b.mass * np.sum(b.velocity(b.com) ** 2, axis=1) / 2 + np.sum(b.moments * spin**2, axis=1) / 2
        return total

    @cached_property
    def potential(self) -> Array:
        """(n,) [J] of all bodies."""
        return sum(b.mass * self.g * b.place(b.com)[:, 2] for b in self.bodies.values())  # type: ignore[return-value]

    @cached_property
    def theta(self) -> Array:
        """(n,) [rad] how far the block has turned: the angle of its axis w from the vertical, towards +y."""
        w = self.bodies["block"].R[:, :, 2]
        return np.arctan2(w[:, 1], w[:, 2])


def _turned(R: Array, x: Any) -> Array:
    """R x for (n, 3, 3) and (3,) or (n, 3)."""
    return np.einsum("nij,nj->ni", R, np.broadcast_to(np.asarray(x, dtype=float), (len(R), 3)))


def _rotation(q: Array) -> Array:
    """(n, 3, 3) of unit quaternions x y z w."""
    x, y, z, w = q.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)
