"""Vessels whose motion is prescribed: a body on six joints in series, each moved as a harmonic of the waves.

The joints are surge, sway, heave, yaw, pitch and roll in the axes of the vessel at rest. Motions are small, so that the
angles are the rotation vector of a frequency response.
"""

from collections.abc import Mapping
from math import sqrt

from heavylift.kernel.algebra.elementary import atan2
from heavylift.kernel.description.forces import Wave, WaveSum
from heavylift.kernel.description.mechanics import IDENTITY, WORLD, Body, Drive, Joint, Matrix, System, Vector

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
CHAIN = {"surge": X, "sway": Y, "heave": Z, "yaw": Z, "pitch": Y, "roll": X}  # axes of joints, the first on the world
MODES = ("surge", "sway", "heave", "roll", "pitch", "yaw")  # in matrices


def carried(body: Body, at: Vector, R: Matrix, motions: Mapping[str, Wave | WaveSum | None], gravity: float) -> System:
    """Return a body on six joints that prescribe its motions [m, rad] about a given position and rotation."""
    name = body.name
    names = [WORLD, *(f"{name}.{mode}" for mode in CHAIN)][:-1]
    bodies = [*(Body(massless, 0.0) for massless in names[1:]), body]
    joints = [
        Joint(
            f"{name}.{mode}", "prismatic" if mode in MODES[:3] else "revolute", parent, child.name,
            p_PJ=at if parent == WORLD else (0.0, 0.0, 0.0), axis=axis, q0=(0.0,),
            R_PJ=R if parent == WORLD else IDENTITY,
        )
        for (mode, axis), parent, child in zip(CHAIN.items(), names, bodies, strict=True)
    ]  # fmt: skip
    drives = []
    for mode in CHAIN:
        wave = motions[mode]
        kinds = {"waves" if isinstance(wave, WaveSum) else "wave": wave}
        drives.append(Drive(f"{name}.{mode}.drive", f"{name}.{mode}", "prescribed", **kinds))  # type: ignore[arg-type]
    return System(tuple(bodies), tuple(joints), drives=tuple(drives), gravity=gravity)


def one_wave(frequency: float, c: float, s: float, ramp: float) -> Wave:
    """Return the harmonic c cos(w t) + s sin(w t) of a frequency w [rad/s] as an amplitude and a phase."""
    return Wave(sqrt(c * c + s * s), frequency, ramp, float(atan2(-s, c)))
