"""Accelerations and energies of random mechanisms are those of an independent library."""

import numpy as np
import pinocchio as pin
import pytest
from heavylift.kernel.model import Program, evaluate
from heavylift.kernel.simulation import Simulation
from hypothesis import HealthCheck, given, settings, strategies as st
from random_trees import pinocchio_model, random_state, random_system

DECADES = 3.0  # masses 100 kg to 100 t
SAME = 1e-10  # relative
SAME_ENERGY = 1e-12  # of the sum of all weights times 10 m: sums of some ten terms
EPS = np.finfo(float).eps
WHATEVER = settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))


def relative(x, want):
    return np.abs(np.asarray(x, float) - want).max() / np.abs(want).max()


def evaluated(program, q, v):
    return evaluate(program, 0.0, np.concatenate([q, v]), program.parameters.initial)


@WHATEVER
@given(st.integers(0, 2**31), st.integers(1, 12))
def test_accelerations_in_interpreted_python_agree_with_pinocchio(seed, n):
    program = Program(random_system(seed, n, DECADES))
    model = pinocchio_model(program.graph)
    q, v = random_state(program.graph, seed)
    dv = evaluated(program, q, v).dy[program.nq :]
    assert relative(dv, pin.aba(model, model.createData(), q, v, np.zeros(model.nv))) < SAME


@WHATEVER
@given(st.integers(0, 2**31), st.integers(1, 12))
def test_accelerations_of_ill_conditioned_trees_of_bodies_lose_no_more_digits_than_their_inertia_matrix(seed, n):
    program = Program(random_system(seed, n, 6.0, floating=True))
    model = pinocchio_model(program.graph)
    data = model.createData()
    q, v = random_state(program.graph, seed)
    H = np.triu(pin.crba(model, data, q))
    H = H + np.triu(H, 1).T
    scale = 1.0 / np.sqrt(np.diag(H))
    condition = np.linalg.cond(H * scale[:, None] * scale)
    dv = evaluated(program, q, v).dy[program.nq :]
    assert relative(dv, pin.aba(model, data, q, v, np.zeros(model.nv))) < 1000 * EPS * condition


@WHATEVER
@given(st.integers(0, 2**31), st.integers(1, 12))
def test_kinetic_and_potential_energies_agree_with_pinocchio(seed, n):
    program = Program(random_system(seed, n, DECADES))
    model = pinocchio_model(program.graph)
    heights, want = [], []
    for i in (seed, seed + 1):
        q, v = random_state(program.graph, i)
        _, kinetic, potential = evaluated(program, q, v).poses_and_energies()
        data = model.createData()
        assert kinetic == pytest.approx(pin.computeKineticEnergy(model, data, q, v), rel=SAME_ENERGY)
        heights.append(potential)
        want.append(pin.computePotentialEnergy(model, data, q))  # leaves out what is fixed to the ground
    scale = 10.0 * sum(b.mass for b in program.system.bodies) * program.system.gravity
    assert heights[1] - heights[0] == pytest.approx(want[1] - want[0], abs=SAME_ENERGY * scale)


@WHATEVER
@given(st.integers(0, 2**31), st.integers(1, 12))
def test_coordinate_rates_move_the_pose_as_in_pinocchio(seed, n):
    program = Program(random_system(seed, n, DECADES))
    model = pinocchio_model(program.graph)
    q, v = random_state(program.graph, seed)
    h = 1e-5
    rate = np.asarray(evaluated(program, q, v).dy[: program.nq], float)
    central = (pin.integrate(model, q, h * v) - pin.integrate(model, q, -h * v)) / (2 * h)
    assert np.abs(rate - central).max() < 1e-8  # differences of second order in h


@pytest.mark.parametrize("seed", range(4))
def test_accelerations_in_machine_code_agree_with_pinocchio(seed):
    simulation = Simulation(random_system(seed, 10, DECADES), cache=False)
    program = simulation.program
    model = pinocchio_model(program.graph)
    at = simulation.method.layout.at["f"]
    for i in range(10):
        q, v = random_state(program.graph, i)
        simulation.state[:] = np.concatenate([q, v])
        simulation.native.call("refresh")
        assert relative(simulation.X[at][program.nq :], pin.aba(model, model.createData(), q, v, 0 * v)) < SAME
