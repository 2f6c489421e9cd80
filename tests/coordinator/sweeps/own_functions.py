"""Functions for studies: a pendulum of the kernel, responses of runs."""

import numpy as np
from heavylift import simulate
from heavylift.kernel.description import Body, Joint, System


def pendulum(length: float, angle: float = 1e-3) -> dict[str, float]:
    """Period [s], and angle at the end [rad], of a point mass on a rod."""
    system = System(
        (Body("bob", 1.0, (0.0, 0.0, -length)),),
        (Joint("pin", "revolute", "world", "bob", axis=(0, 1, 0), q0=(angle,)),),
    )
    result = simulate(system, until=8.0, every=0.01, tolerance=1e-9)
    q = result["joint/position"]["pin.angle"]
    t = result.t[:-1][(q[:-1] > 0.0) & (q[1:] <= 0.0)]
    return {"period": float(np.mean(np.diff(t))), "end": float(q[-1])}


def fails(x: float) -> float:
    return 1.0 / x


def text(x: float) -> str:
    return "much"


def swing(result) -> float:
    """The largest speed of a joint in a run."""
    return float(np.abs(result["joint/velocity"].values).max())


def scaled(result, by: float) -> float:
    return by * swing(result)


def endless(result) -> float:
    return float("inf")


def huge(result=None) -> int:
    return 10**400


def words(result) -> str:
    return "much"
