"""Formulas by which DNV-RP-N103 (as DNV-RP-H103, 4.7 and 5.3) estimates lifts at sea, over random lifts.

A published floating crane with figures that can be read was not found: papers are abstracts, or lack their tables. The
coupled motions of a floating crane are compared with another formulation in `tests/nodes/sea`.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from math import pi, sqrt
from pathlib import Path
from random import Random

import numpy as np
import pytest
from heavylift.kernel.analysis import equilibrium, linear_model, modes
from heavylift.kernel.description import WORLD, Body, Drive, Joint, JointSpring, Line, Load, Point, Rope, System
from heavylift.kernel.simulation import Simulation

sys.path.insert(0, str(Path(__file__).parents[1] / "kernel"))
from small_scenes import SECOND, G, Z, column, hand_over, started

SMALL = 1e-5  # relative: frequencies by differences
TIP = 1e-3  # mass of a crane tip over that of its load, which the rules neglect
EXACT = {"method": "dop853", "tolerance": 1e-11}
PEAK = 1e-6  # relative, of a peak that is found between steps


class SubseaLift:
    """A load with added mass in calm water on one line; M, A [kg], line of L [m], K [N/m], and m [kg]."""

    def __init__(self, seed: int) -> None:
        draw = Random(seed)
        self.M, self.L = draw.uniform(2e4, 4e5), draw.uniform(20.0, 400.0)
        self.A, self.K = self.M * draw.uniform(0.0, 2.0), self.M * G / draw.uniform(0.02, 0.4)
        self.m, self.crane = self.M * draw.uniform(0.0, 0.02), self.K * draw.uniform(0.5, 5.0)
        self.weight, self.v = self.M * G * draw.uniform(0.05, 0.9), draw.uniform(0.2, 2.0)

    def system(self, m: float = 0.0, weight: float | None = None, v: float = 0.0) -> System:
        """Below a fixed tip, with the line of its own length L; `weight` [N]: of the load in water."""
        A = [[0.0] * 6 for _ in range(6)]
        A[2][2] = self.A
        load = Body("load", self.M, added=tuple(map(tuple, A)))  # type: ignore[arg-type]
        lift = Load("water", Point("load"), (0.0, 0.0, self.M * G - (self.weight if weight is None else weight)))
        line = Rope("line", (Line(Point(WORLD), Point("load")),), self.K * self.L, self.L, mass=m)
        slide = Joint("slide", "prismatic", WORLD, "load", axis=Z, q0=(-self.L,), v0=(-v,))
        return System((load,), (slide,), ropes=(line,), forces=(lift,), gravity=G)

    def below(self, joint: Joint, **laws: tuple) -> System:
        """Below a tip of hardly any mass on a joint of its own."""
        alone = self.system()
        tip, line = Body("tip", TIP * self.M), replace(alone.ropes[0], lines=(Line(Point("tip"), Point("load")),))
        return replace(alone, bodies=(*alone.bodies, tip), joints=(*alone.joints, joint), ropes=(line,), **laws)


def at_rest(system: System) -> Simulation:
    s = started(system)
    equilibrium(s)
    return s


def period(system: System) -> float:
    """The longest period [s] of small motions about rest."""
    return max(1.0 / mode.frequency for mode in modes(at_rest(system)).oscillations)


@pytest.mark.parametrize("seed", range(8))
def test_the_natural_period_of_a_hoisting_system_includes_added_mass_and_a_third_of_the_line(seed: int) -> None:
    """T = 2 pi sqrt((M + A33 + m L / 3) / K); the third neglects (m L / M)^2 / 10 of wave motion in the line."""
    x = SubseaLift(seed)
    want = 2.0 * pi * sqrt((x.M + x.A + x.m / 3.0) / x.K)
    assert period(x.system(x.m)) == pytest.approx(want, rel=SMALL)


@pytest.mark.parametrize("seed", range(8))
def test_crane_and_line_yield_in_series_in_the_natural_period(seed: int) -> None:
    """1 / K = 1 / K_crane + 1 / K_line."""
    x = SubseaLift(seed)
    tip = Joint("boom", "prismatic", WORLD, "tip", axis=Z)
    soft = x.below(tip, springs=(JointSpring("crane", "boom", x.crane, 0.0),))
    want = 2.0 * pi * sqrt((x.M + x.A) * (1.0 / x.K + 1.0 / x.crane))
    assert period(soft) == pytest.approx(want, rel=TIP)


@pytest.mark.parametrize("seed", range(8))
def test_a_load_in_deep_water_follows_the_crane_tip_by_the_amplification_of_its_line(seed: int) -> None:
    """Amplitude of the load over that of the tip: 1 / |1 - (w / w0)^2|, without drag."""
    x = SubseaLift(seed)
    joint = Joint("boom", "prismatic", WORLD, "tip", axis=Z)
    model = linear_model(
        at_rest(x.below(joint, drives=(Drive("heave", "boom", "prescribed"),))), ["heave"], ["pose/load/z"]
    )
    w0 = sqrt(x.K / (x.M + x.A))
    for w in (0.2 * w0, 0.7 * w0, 1.5 * w0, 4.0 * w0):
        inner = np.linalg.solve(1j * w * np.eye(len(model.A)) - model.A, model.B)
        per_tip = (model.C @ inner + model.D)[0, 0] * -(w * w)  # its input is the acceleration of the tip
        assert abs(per_tip) == pytest.approx(1.0 / abs(1.0 - (w / w0) ** 2), rel=SMALL)


def peak(system: System) -> float:
    """The largest tension [N] of the line within a period."""
    s = started(system, **EXACT)
    hand_over(s, 4 * SECOND)
    return max(float(column(s, topic)[1].max()) for topic in ("rope/peak", "rope/tension"))


@pytest.mark.parametrize("seed", range(8))
def test_the_snap_force_on_a_neutrally_buoyant_load_is_that_of_the_dnv_rule(seed: int) -> None:
    """F = v sqrt(K (M + A33)): all kinetic energy goes into the line, of which the rule leaves the weight out."""
    x = SubseaLift(seed)
    assert peak(x.system(weight=0.0, v=x.v)) == pytest.approx(x.v * sqrt(x.K * (x.M + x.A)), rel=PEAK)


@pytest.mark.parametrize("seed", range(8))
def test_the_peak_tension_of_a_heavy_load_exceeds_the_snap_force_of_the_rule_by_one_to_two_weights(seed: int) -> None:
    """Exactly W + sqrt(W^2 + F^2), which lies between F + W and F + 2 W."""
    x = SubseaLift(seed)
    snap, found = x.v * sqrt(x.K * (x.M + x.A)), peak(x.system(v=x.v))
    assert found == pytest.approx(x.weight + sqrt(x.weight**2 + snap**2), rel=PEAK)
    assert snap + x.weight < found < snap + 2.0 * x.weight
