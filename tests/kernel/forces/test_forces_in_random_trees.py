"""Random trees with one force of every kind agree in machine code and independent code; the energy balance closes."""

from dataclasses import replace

import numpy as np
import pytest
from heavylift.kernel.description import (
    Bushing,
    Characteristic,
    InputSignal,
    Load,
    Point,
    Reeving,
    Sheave,
    Spring,
    Torsion,
    UserLaw,
    Wind,
)
from msgspec import structs
from random_trees import random_system
from small_scenes import SECOND, events, imbalance, started

CLOSES = 1e-8  # of the energy turned over; integrated at 1e-11
SAME = 1e-9  # relative to the largest of a kind
KINDS = ("fixed", "revolute", "prismatic", "universal", "spherical", "free")


def forces(random, names, joints):
    """One of each kind, between random bodies."""

    def point():
        return Point(str(random.choice(names)), tuple(random.normal(size=3).tolist()))

    def unit():
        a = random.normal(size=3)
        return tuple((a / np.linalg.norm(a)).tolist())

    def matrix(size):
        A = random.normal(size=(6, 6))
        return tuple(map(tuple, (A @ A.T * size).tolist()))

    a, b = random.choice(names, 2, replace=False)
    distance = (Sheave(point(), efficiency=0.95), Sheave(point(), efficiency=0.9))
    reeved = Reeving("reeved", Point("world", (0.0, 0.0, 9.0)), distance, point(), 2e5, InputSignal(1e3), 1e2)
    ramp = InputSignal(times=(0.0, 0.1), values=(0.0, 1.0))
    out = [
        Load("load", point(), tuple((1e3 * random.normal(size=3)).tolist()), unit(), "body", ramp),
        Wind("wind", point(), 5.0, 1.2, unit(), InputSignal(20.0), sides=(2.0, 0.0, 7.0)),
        Spring("spring", point(), point(), 1.0, 1e3, 10.0),
        Torsion("torsion", str(a), str(b), unit(), 1e3, 10.0),
        Bushing("bushing", point(), point(), matrix(1000.0), matrix(20.0)),
        UserLaw("magnus", "laws_of_a_user:magnus", ends=(point(),), parameters=(0.1, 0.01)),
        reeved,
    ]
    if joints:
        out.append(Characteristic("curve", joints[0], "speed", (-1.0, 0.0, 0.2), (500.0, 0.0, -800.0)))
    return out


@pytest.mark.parametrize("seed", [3, 8])
def test_random_trees_with_every_force_law_agree_with_independent_code(seed):
    random = np.random.default_rng(seed)
    system = random_system(seed, 5, 1.0, kinds=KINDS)
    names = [b.name for b in system.bodies]
    joints = [j.name for j in system.joints if j.kind in ("revolute", "prismatic")]
    made = forces(random, names, joints)
    reeved = next(f for f in made if f.name == "reeved")
    slack = started(replace(system, forces=(reeved,)), native=False)
    taut = structs.replace(reeved, signal=InputSignal(0.99 * float(sum(slack.row().shown[3:6]))))
    system = replace(system, forces=tuple(taut if f is reeved else f for f in made))
    s = started(system, tolerance=1e-11, sample_ns=10_000_000, h_max=0.02)
    oracle = started(system, native=False)
    f, theirs = s.X[s.native.at["f"]], oracle.X[oracle.native.at["f"]]
    assert f == pytest.approx(theirs, abs=SAME * np.abs(theirs).max())
    s.run(SECOND // 2)
    assert ("reeved", "slip") in events(s)
    assert imbalance(s) < CLOSES
