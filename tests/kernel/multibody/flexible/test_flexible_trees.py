"""Trees with a flexible body obey Lagrange's equations and keep energy and momentum."""

from dataclasses import replace

import numpy as np
import pytest
from flexible_trees import flexible_tree
from heavylift.kernel.analysis import inverse_dynamics, momentum
from heavylift.kernel.description import Body
from heavylift.kernel.model import Program, evaluate
from heavylift.kernel.simulation import Simulation
from random_trees import random_state
from small_scenes import SECOND, G, hand_over, imbalance

LAGRANGE = 1e-8  # of the largest term: differences of second order
SAME = 1e-12
KEPT = 1e-8  # of momentum, at the tolerance of the run


def state_of(program, seed, scale=0.1):
    """Coordinates of order one, deflections of a tenth of the largest shapes."""
    q, v = random_state(program.graph, seed)
    for link in program.graph.links:
        q[link.q_modes] *= scale
        if link.joint.kind == "slider":
            q[link.q] = 0.6 + 0.2 * q[link.q]
    return q, v


def evaluated(program, q, v):
    y = np.concatenate([q, v, np.zeros(program.ny - program.nq - program.nv)])
    return evaluate(program, 0.0, y, program.parameters.initial)


def energy(program, q, v):
    """Kinetic energy, and potential energy with that of the modes, of the only tree."""
    ((_, shared),) = program.instances
    x = shared.pose(q=q, v=v, P=program.parameters.initial[program.parameters.at["tree", "0"]], g=[G])
    strain = sum(k.modes.stiffness @ q[k.q_modes] ** 2 for k in program.graph.links if k.modes) / 2
    return float(x.energy[0]), float(x.energy[1]) + strain


def difference(f, x, h):
    return np.array([(f(x + h * e) - f(x - h * e)) / (2 * h) for e in np.eye(len(x))])


@pytest.mark.parametrize("slider", [False, True])
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.large(beyond=2)
def test_accelerations_of_flexible_trees_satisfy_lagranges_equations(seed, slider):
    program = Program(flexible_tree(seed, slider=slider))
    n = program.nv
    q, v = state_of(program, seed)
    dv = np.asarray(evaluated(program, q, v).dy[n : 2 * n], float)

    def momentum(x):
        return difference(lambda u: energy(program, x, u)[0], v, 1.0)  # exact: T is quadratic in v

    H = np.array([difference(lambda u, e=e: energy(program, q, u + e)[0], 0 * v, 1.0) for e in np.eye(n)])
    H -= difference(lambda u: energy(program, q, u)[0], 0 * v, 1.0)
    assert np.linalg.eigvalsh((H + H.T) / 2)[0] > 0.0
    h = 1e-5
    drift = (momentum(q + h * v) - momentum(q - h * v)) / (2 * h)
    force = difference(lambda x: energy(program, x, v)[0] - energy(program, x, v)[1], q, h)
    terms = np.stack([H @ dv, drift, force])
    assert np.abs(H @ dv + drift - force).max() < LAGRANGE * np.abs(terms).max()


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.large(beyond=1)
def test_a_floating_flexible_tree_conserves_energy_and_momentum(seed):
    system = replace(flexible_tree(seed, ("revolute", "spherical"), root="free"), gravity=0.0)
    s = Simulation(system, tolerance=1e-11, sample_ns=50_000_000, h_max=0.01, cache=False)
    q, v = state_of(s.program, seed, 0.02)
    s.state[: len(q) + len(v)] = np.concatenate([q, 0.3 * v])
    s.start()
    before = momentum(s)
    start = energy(s.program, q, 0.3 * v)[0]
    h = 1e-6
    moved = energy(s.program, q, 0.3 * v + h * np.eye(len(v))[0])[0]
    R_WB = s.row().poses[3:12].reshape(3, 3)
    assert (moved - start) / h == pytest.approx(R_WB[:, 0] @ before.linear, rel=1e-4), "the momentum is dT/dv"
    hand_over(s, SECOND)
    after = momentum(s)
    assert np.abs(after.linear - before.linear).max() < KEPT * np.abs(before.linear).max()
    assert np.abs(after.angular - before.angular).max() < KEPT * np.abs(before.angular).max()
    assert np.abs(s.state[: len(q)] - q).max() > 0.1
    assert imbalance(s) < KEPT


@pytest.mark.parametrize("seed", range(3))
def test_inverse_dynamics_of_a_flexible_tree_returns_the_applied_forces(seed):
    program = Program(flexible_tree(seed, ("revolute", "prismatic", "spherical")))
    q, v = state_of(program, seed)
    x = evaluated(program, q, v)
    ((tree, _),) = program.instances
    dv = np.asarray(x.dy[len(q) : len(q) + len(v)], float)
    tau, _ = inverse_dynamics(tree, q, v, dv, [np.zeros(6)] * len(tree.bodies), G)
    elastic = np.zeros(len(v))
    for link in program.graph.links:
        if link.modes:
            elastic[link.v_modes] = -link.modes.stiffness * q[link.q_modes]
    assert np.asarray(tau, float) == pytest.approx(elastic, rel=1e-9, abs=1e-9 * np.abs(elastic).max())


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.large(beyond=1)
def test_machine_code_and_interpreted_python_agree_on_flexible_trees(seed):
    simulation = Simulation(flexible_tree(seed, ("revolute", "prismatic", "spherical")), cache=False)
    program = simulation.program
    q, v = state_of(program, seed)
    simulation.state[: len(q) + len(v)] = np.concatenate([q, v])
    simulation.native.call("refresh")
    native = simulation.X[simulation.method.layout.at["f"]][: program.nq + program.nv]
    plain = np.asarray(evaluated(program, q, v).dy[: program.nq + program.nv], float)
    assert native == pytest.approx(plain, rel=1e-10, abs=1e-10 * np.abs(plain).max())


def test_a_flexible_body_without_modes_moves_as_a_rigid_body():
    bent = flexible_tree(0, modes=0)
    beam = bent.bodies[1].flexible.beam
    m, l = beam.mass_per_length * beam.length, beam.length
    across = m * l * l / 12
    moments = ((beam.polar * l, 0.0, 0.0), (0.0, across, 0.0), (0.0, 0.0, across))
    stiff = Body("flex", m, (l / 2, 0.0, 0.0), moments)
    massless = replace(bent.bodies[1], mass=0.0)
    one = Program(replace(bent, bodies=(bent.bodies[0], massless, *bent.bodies[2:])))
    two = Program(replace(bent, bodies=(bent.bodies[0], stiff, *bent.bodies[2:])))
    q, v = state_of(one, 3)
    a, b = (np.asarray(evaluated(p, q, v).dy[: len(q) + len(v)], float) for p in (one, two))
    assert a == pytest.approx(b, rel=SAME, abs=SAME * np.abs(b).max())
    assert energy(one, q, v) == pytest.approx(energy(two, q, v), rel=SAME)
