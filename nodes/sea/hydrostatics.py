"""Hydrostatics of a hull from its mesh, exact for flat panels.

The divergence theorem turns each volume or waterplane integral into one over the wetted panels: the volume is the sum
of z n_z dS, and the waterplane that of -n_z dS. Integrands are at most quadratic, for which the midpoints of
a triangle's edges integrate exactly.
"""

from typing import NamedTuple

import numpy as np
from heavylift.kernel.errors import SceneError

AT_SURFACE = 1e-6  # of the size: panels there are no part of the wetted hull


class Hydrostatics(NamedTuple):
    """Hydrostatics of a hull: displaced volume [m3], centre of buoyancy (3,) [m], and waterplane.

    Of the waterplane: area [m2], first moments of x and y [m3] and second moments of x x, y y and x y [m4]."""

    volume: float
    buoyancy: np.ndarray
    waterplane: float
    first: np.ndarray
    second: np.ndarray

    def stiffness(self, weight: float) -> np.ndarray:
        """Return the hydrostatic stiffness (6, 6) [N/m, N, N m] about the origin, for a centre of mass at the origin's
        height.

        `weight`: specific weight of the water [N/m3]."""
        (x, y), (xx, yy, xy), lift = self.first, self.second, self.volume * self.buoyancy[2]
        K = np.zeros((6, 6))
        K[2:5, 2:5] = [[self.waterplane, y, -x], [y, yy + lift, -xy], [-x, -xy, xx + lift]]
        return weight * K


def hydrostatics_of(panels: np.ndarray) -> Hydrostatics:
    """Return the hydrostatics of a hull from its mesh below the waterline z = 0, which may be closed by a lid.

    The mesh has triangles or quadrilaterals (n, 3 or 4, 3) [m]; raises SceneError if it encloses no volume."""
    hull = panels[(np.abs(panels[:, :, 2]) > AT_SURFACE * np.abs(panels).max()).any(axis=1)]
    a, b, c = np.concatenate([hull[:, [0, i, i + 1]] for i in range(1, hull.shape[1] - 1)]).swapaxes(0, 1)
    up = np.tile(np.cross(b - a, c - a)[:, 2] / 6.0, 3)  # a third of n_z dS for each midpoint
    x, y, z = 0.5 * np.concatenate([a + b, b + c, c + a]).T
    volume = float(up @ z)
    if not volume:
        raise SceneError("the mesh encloses no volume below z = 0; move the waterline to z = 0")
    up *= np.sign(volume)  # normals to the water
    centre = np.array([up @ (x * z), up @ (y * z), 0.5 * up @ (z * z)]) / abs(volume)
    moments = [-float(up @ f) for f in (np.ones(len(x)), x, y, x * x, y * y, x * y)]
    return Hydrostatics(abs(volume), centre, moments[0], np.array(moments[1:3]), np.array(moments[3:]))
