"""Andrews' squeezing mechanism: seven bodies in the x-y plane, three loops, a spring, a motor of given torque.

Dimensions and the names of points: Hairer, Wanner, Solving ODEs II, section VII.7 (also IFToMM A03).  Each body's frame
sits where it is pinned; joints are `K1` to `K7`.
"""

from heavylift.kernel.description import WORLD, Body, Joint, Load, Point, Spring, System

TORQUE, STIFFNESS, REST = 0.033, 4530.0, 0.07785  # [N m], [N/m], [m]
RR, D, E, SS, ZT, ZF, U = 7e-3, 28e-3, 2e-2, 35e-3, 4e-2, 2e-2, 4e-2  # [m]
A, B, C = (-0.06934, -0.00227, 0.0), (-0.03635, 0.03273, 0.0), (0.014, 0.072, 0.0)
LINKS = {  # mass [kg], centre of mass in the body's frame [m], moment of inertia about it [kg m2]
    "K1": (0.04325, (9.2e-4, 0.0), 2.194e-6),
    "K2": (0.00365, (-1.15e-2, 0.0), 4.410e-7),
    "K3": (0.02373, (1.874e-2, 1.043e-2), 5.255e-6),
    "K4": (0.00706, (0.0, -(E - 1.421e-2)), 5.667e-7),
    "K5": (0.07050, (2.308e-2, 9.16e-3), 1.169e-5),
    "K6": (0.00706, (ZF - 1.421e-2, 0.0), 5.667e-7),
    "K7": (0.05498, (1.228e-2, 4.49e-3), 1.912e-5),
}
PINS = {  # on which body, and where
    "K1": (WORLD, (0.0, 0.0, 0.0)),
    "K2": ("K1", (RR, 0.0, 0.0)),
    "K3": (WORLD, B),
    "K4": ("K5", (ZT, 0.0, 0.0)),
    "K5": (WORLD, A),
    "K6": ("K7", (0.0, -U, 0.0)),
    "K7": (WORLD, A),
}
ENDS = {"K3": (0.0, -SS, 0.0), "K4": (0.0, -E, 0.0), "K6": (ZF, 0.0, 0.0)}  # where they are pinned to the end of K2


def squeezer(angles: tuple[float, ...]) -> System:
    """The mechanism at beta, Theta, gamma, Phi, delta, Omega, epsilon [rad], at rest."""
    bodies = [
        Body(name, m, (*com, 0.0), ((0.0, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, i)))
        for name, (m, com, i) in LINKS.items()
    ]
    joints = [
        Joint(name, "revolute", parent, name, place, q0=(angle,))
        for (name, (parent, place)), angle in zip(PINS.items(), angles, strict=True)
    ]
    joints += [Joint(f"F-{k}", "revolute", "K2", k, (-D, 0.0, 0.0), p_CJ=end) for k, end in ENDS.items()]
    motor = Load("motor", Point("K1"), moment=(0.0, 0.0, TORQUE))
    spring = Spring("spring", Point(WORLD, C), Point("K3", (2e-2, -1.8e-2, 0.0)), REST, STIFFNESS)
    return System(tuple(bodies), tuple(joints), forces=(motor, spring), gravity=0.0)
