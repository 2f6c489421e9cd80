"""Accelerations and energies of random mechanisms are those of an independent library."""

import numpy as np
import pinocchio as pin
import pytest
from heavylift.kernel.rate import Program
from heavylift.kernel.simulation import Simulation
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from random_trees import pinocchio_model, random_state, random_system

SAME = 1e-10  # relative: two algorithms, masses over six decades
SAME_ENERGY = 1e-12  # relative: sums of some ten terms


def relative(x, want):
    return np.abs(np.asarray(x, float) - want).max() / np.abs(want).max()


@settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(st.integers(0, 2**31), st.integers(1, 12))
def test_accelerations_and_energies_of_the_float_text(seed, n):
    program = Program(random_system(seed, n))
    model = pinocchio_model(program.graph)
    data = model.createData()
    q, v = random_state(program.graph, seed)
    x = program.evaluate(0.0, np.concatenate([q, v]), program.parameters.initial)
    assert relative(x.dy[program.nq :], pin.aba(model, data, q, v, np.zeros(model.nv))) < SAME
    _, kinetic, potential = x.poses_and_energies()
    assert kinetic == pytest.approx(pin.computeKineticEnergy(model, data, q, v), rel=SAME_ENERGY)
    scale = sum(b.mass for b in program.system.bodies) * program.system.gravity
    assert potential == pytest.approx(pin.computePotentialEnergy(model, data, q), abs=SAME_ENERGY * scale * 10)


@settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(st.integers(0, 2**31), st.integers(1, 12))
def test_the_rate_of_a_coordinate_moves_it_as_pinocchio_does(seed, n):
    program = Program(random_system(seed, n))
    model = pinocchio_model(program.graph)
    q, v = random_state(program.graph, seed)
    h = 1e-5
    rate = program.evaluate(0.0, np.concatenate([q, v]), program.parameters.initial).dy[: program.nq]
    central = (pin.integrate(model, q, h * v) - pin.integrate(model, q, -h * v)) / (2 * h)
    assert np.abs(np.asarray(rate, float) - central).max() < 1e-8  # differences of second order in h


@pytest.mark.parametrize("seed", range(6))
def test_accelerations_of_the_machine_code(seed):
    simulation = Simulation(random_system(seed, 10), cache=False)
    program = simulation.program
    model = pinocchio_model(program.graph)
    at = simulation.method.layout.at["f"]
    for i in range(10):
        q, v = random_state(program.graph, i)
        simulation.state[:] = np.concatenate([q, v])
        simulation._call("refresh")
        assert relative(simulation.X[at][program.nq :], pin.aba(model, model.createData(), q, v, 0 * v)) < SAME
