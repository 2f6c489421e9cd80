"""Tendons of MuJoCo that wrap around geoms as ropes over sheaves.

A cylinder or sphere becomes a sheave if all bodies that the tendon touches there can move only in one plane
perpendicular to its axis, judging by their joints. Another cylinder, around which alone a tendon wraps, becomes an edge
along which the tendon slides. A conversion counts only if the rope has the length of the tendon in the pose of the file
and in random others: within the limits of joints, or else of turns all round and of shifts as long as the model.
"""

from collections.abc import Iterator
from copy import copy
from itertools import product
from math import pi
from typing import Any

import numpy as np
from heavylift.kernel.description.forces import InputSignal, Reeving, Sheave
from heavylift.kernel.description.mechanics import Point
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.reeving import ReevingLaw

FREE, SLIDE, HINGE = 0, 2, 3  # kinds of joints
SITE, SPHERE, CYLINDER = 3, 4, 5  # of a tendon's path
ENDLESS = (-1000.0, 1000.0)  # ends of a cylinder, which wraps beyond its own [m]
SAME = 1e-9  # of directions, and lengths relative to those of the tendon
ROUNDED = 1e-25  # [m, kg m2]; a scene refuses numbers below 1e-30
POSES = 16  # besides that of the file


class WrappedTendons:
    """Converter of MuJoCo's wrapped tendons into ropes.

    `data`: kinematics in the pose of the file; `bodies`: body names."""

    def __init__(self, library: Any, model: Any, bodies: list[str]) -> None:
        self.m, self.bodies, self.data = model, bodies, library.MjData(model)
        library.mj_forward(model, self.data)
        self.all_data = [self.data, *self._others(library)]

    def _others(self, library: Any) -> Iterator[Any]:
        """Yield the kinematics of other poses with random coordinates of all joints."""
        m, random = self.m, np.random.default_rng(0)
        far = float(m.stat.extent)  # [m]
        for _ in range(POSES if m.njnt else 0):
            data = copy(self.data)
            for at, kind, limited, ends in zip(m.jnt_qposadr, m.jnt_type, m.jnt_limited, m.jnt_range, strict=True):
                if kind in (SLIDE, HINGE):
                    reach = far if kind == SLIDE else pi
                    data.qpos[at] = random.uniform(*ends) if limited else m.qpos0[at] + random.uniform(-reach, reach)
                    continue
                if kind == FREE:
                    data.qpos[at : at + 3] += random.uniform(-far, far, 3)
                    at += 3
                data.qpos[at : at + 4] = random.normal(size=4)  # MuJoCo divides quaternions by their lengths
            library.mj_forward(m, data)
            yield data

    def rope(self, i: int, name: str, k: float, length: float, damping: float) -> Reeving | None:
        """Return tendon i as an elastic rope; None if the tendon cannot be converted.

        `k`: stiffness [N/m]; `length`: unstretched length [m]."""
        m, nodes = self.m, range(self.m.tendon_adr[i], self.m.tendon_adr[i] + self.m.tendon_num[i])
        kinds = [int(m.wrap_type[w]) for w in nodes]
        if not {*kinds} <= {SITE, SPHERE, CYLINDER}:  # each geom is between two sites
            return None
        inner = list(zip(nodes, kinds, strict=True))[1:-1]
        for senses in product((1.0, -1.0), repeat=len(inner) - kinds[1:-1].count(SITE)):
            sense, sheaves = iter(senses), list[Sheave]()
            for w, kind in inner:
                if kind == SITE:
                    sheaves.append(Sheave(self._site(int(m.wrap_objid[w]))))
                elif (made := self._sheave(w, kind, next(sense), alone=len(kinds) == 3)) is None:
                    return None
                else:
                    sheaves.append(made)
            ends = self._site(int(m.wrap_objid[nodes[0]])), self._site(int(m.wrap_objid[nodes[-1]]))
            found = Reeving(name, ends[0], tuple(sheaves), ends[1], k * length, InputSignal(length), damping)
            if all(self._equal(found, i, data) for data in self.all_data):
                return found
        return None

    def _equal(self, rope: Reeving, i: int, data: Any) -> bool:
        """Return whether a rope is as long as tendon i in the pose of `data`."""

        def pose(body: str) -> tuple[np.ndarray, np.ndarray]:
            k = self.bodies.index(body)
            return data.xmat[k].reshape(3, 3), data.xpos[k]

        try:
            there = ReevingLaw().start_length(rope, pose)
        except KernelError:
            return False
        wanted = float(data.ten_length[i])
        return abs(there - wanted) <= SAME * wanted

    def _sheave(self, w: int, kind: int, sense: float, alone: bool) -> Sheave | None:
        """Return the geom at place w of a tendon's path as a sheave or edge, around which the rope turns as it does in
        the pose of the file (`sense` 1) or the other way (-1); None if no sheave or edge is equivalent."""
        m, d, g = self.m, self.data, int(self.m.wrap_objid[w])
        first, last = (int(m.wrap_objid[w + step]) for step in (-1, 1))
        a, b, c = d.site_xpos[first], d.site_xpos[last], d.geom_xpos[g]
        n = d.geom_xmat[g].reshape(3, 3)[:, 2] if kind == CYLINDER else np.cross(a - c, b - c)
        if np.linalg.norm(n) <= SAME:
            return None
        n = n / np.linalg.norm(n)
        radius, side = float(m.geom_size[g][0]), round(float(m.wrap_prm[w]))
        straight, across = _flat(b - a, n), _flat(a - c, n)
        near = across - straight * (across @ straight) / max(float(straight @ straight), SAME)
        beside = _flat(d.site_xpos[side] - c, n) if side >= 0 else near
        if np.linalg.norm(beside) <= (radius if side >= 0 else SAME):
            return None  # it wraps inside, or on either side
        n = sense * (n if np.cross(straight, n) @ beside > 0.0 else -n)
        bodies = [int(m.site_bodyid[first]), int(m.geom_bodyid[g]), int(m.site_bodyid[last])]
        level = max(abs((a - c) @ n), abs((b - c) @ n)) <= SAME
        R = d.xmat[bodies[1]].reshape(3, 3)
        at = Point(self.bodies[bodies[1]], row_of(m.geom_pos[g]))
        if level and self._planar(bodies, n):
            return Sheave(at, row_of(R.T @ n), radius)
        if kind == CYLINDER and alone:
            return Sheave(at, row_of(R.T @ n), radius, edge="cylinder", span=ENDLESS)
        return None

    def _planar(self, bodies: list[int], n: np.ndarray) -> bool:
        """Return whether the joints between bodies move them only in planes perpendicular to the direction n."""
        own = [self._joints(body) for body in bodies]
        between = set[int]().union(*own) - own[0].intersection(*own)
        kinds = {j: int(self.m.jnt_type[j]) for j in between}
        along = {j: abs(float(self.data.xaxis[j] @ n)) for j in between}
        return all(
            (kinds[j] == HINGE and along[j] >= 1.0 - SAME) or (kinds[j] == SLIDE and along[j] <= SAME) for j in between
        )

    def _joints(self, body: int) -> set[int]:
        found = set[int]()
        while body:
            found |= {j for j in range(self.m.njnt) if self.m.jnt_bodyid[j] == body}
            body = int(self.m.body_parentid[body])
        return found

    def _site(self, i: int) -> Point:
        return Point(self.bodies[int(self.m.site_bodyid[i])], row_of(self.m.site_pos[i]))


def _flat(x: np.ndarray, n: np.ndarray) -> np.ndarray:
    """Return the component of a vector perpendicular to the direction n."""
    return np.asarray(x - (x @ n) * n)


def row_of(x: np.ndarray) -> Any:
    """Return numbers as a tuple, in which mere rounding errors are replaced by 0."""
    return tuple(float(e) if abs(e) > ROUNDED else 0.0 for e in x)
