"""Random mechanisms run: their energy balance closes, their statics balance, and all formulations agree.

Joint types, branchings, ropes and inertias over twelve decades are drawn at random, always the same ones.
"""

from dataclasses import replace

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.analysis import equilibrium, momentum, reactions
from heavylift.kernel.description import JOINTS, JointSpring, Line, Point, Rope, System
from heavylift.kernel.multibody.formulations import FORMULATIONS
from heavylift.kernel.simulation import Simulation
from hypothesis import HealthCheck, given, settings, strategies as st
from random_trees import random_system
from small_scenes import SECOND, imbalance, started

SOME = settings(max_examples=4, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
SEEDS = given(st.integers(0, 2**31), st.integers(2, 4))
CLOSES = 1e-6  # of the energy that is turned over, at a tolerance of 1e-9
BALANCED = 1e-6  # of the weight


def roped(seed: int, n: int, decades: float) -> System:
    """A random tree with springs on the joints that take them, and ropes from its bodies to the sky."""
    random = np.random.default_rng(seed)
    tree = random_system(seed, n, decades)
    springs = tuple(
        JointSpring(f"s-{j.name}-{c}", j.name, 1e4, 1e3, coordinate=c)
        for j in tree.joints
        for c in JOINTS[j.kind].actable
    )
    ropes = tuple(
        Rope(
            f"r{b.name}",
            (Line(Point("world", (*random.normal(scale=5.0, size=2).tolist(), 40.0)), Point(b.name)),),
            1e3 * b.mass * 9.81,
            float(random.uniform(25.0, 45.0)),
            damping=0.5 * b.mass,
        )
        for b in tree.bodies
    )
    return replace(tree, springs=springs, ropes=ropes)


def attempted(act) -> str:
    """The sentence with which an action is refused, "" if it is not."""
    try:
        act()
    except KernelError as error:
        return str(error)
    return ""


@SOME
@SEEDS
def test_random_mechanisms_run_and_conserve_their_energy_balance(seed, n):
    s = started(roped(seed, n, 2.0), tolerance=1e-9, sample_ns=SECOND // 20, native=True)
    s.run(SECOND // 2)
    s.interrupt(SECOND // 2)
    assert np.isfinite(s.state).all()
    assert imbalance(s) < CLOSES


@SOME
@SEEDS
def test_inertias_over_twelve_decades_give_finite_motion_or_an_error(seed, n):
    s = Simulation(roped(seed, n, 12.0), native=False)
    if sentence := attempted(s.start):
        assert "\n" not in sentence
        return
    at = s.method.layout.at
    assert np.isfinite(s.X[at["y"]]).all()
    assert np.isfinite(s.X[at["f"]]).all()


@SOME
@SEEDS
@pytest.mark.large
def test_at_rest_the_joints_and_ropes_attached_to_the_ground_carry_the_whole_weight(seed, n):
    s = started(roped(seed, n, 2.0))
    sentence = attempted(lambda: equilibrium(s))
    assert sentence == "" or "finds no rest" in sentence  # it may hang where nothing holds it
    if sentence:
        return
    p = s.program
    x = s.instant()
    up = sum(w[5] for w in x.wrenches)
    grounds = [k.joint.name for k in p.graph.links if k.parent < 0]
    carried = reactions(s)
    for link in p.graph.links:
        if link.joint.name in grounds:
            up += (np.array(link.joint.R_PJ) @ carried[link.joint.name].force)[2]
    weight = momentum(s).mass * p.system.gravity
    assert abs(up - weight) < BALANCED * weight
    assert np.all(s.row().tension >= 0.0)


@SOME
@SEEDS
def test_all_formulations_give_the_same_accelerations_of_systems_with_springs_and_ropes(seed, n):
    system = roped(seed, n, 3.0)
    rates = []
    for name in FORMULATIONS:
        s = Simulation(system, native=False, formulation=name)
        s.start()
        rates.append(s.X[s.method.layout.at["f"]][s.program.nq : s.program.nq + s.program.nv].copy())
    for other in rates[1:]:
        assert np.abs(other - rates[0]).max() <= 1e-9 * np.abs(rates[0]).max(initial=1.0)
