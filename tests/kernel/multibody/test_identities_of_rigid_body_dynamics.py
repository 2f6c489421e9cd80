"""Identities of dynamics for every tree: FD(ID(x)) = x, H symmetric and positive, H' = C + C^T, power balance.

Inertias span twelve decades.  What rounding then leaves is reported by the size of the forces: the residual of an
equation is compared with the sum of what stands in it, not with its small right hand side.
"""

import numpy as np
import pinocchio as pin
import pytest
from heavylift.kernel.analysis import inverse_dynamics
from heavylift.kernel.multibody import build_graph, composites, cut, energies, joint_space_inertia
from heavylift.kernel.multibody.dynamics import dynamics
from heavylift.kernel.multibody.kinematics import kinematics
from hypothesis import HealthCheck, given, settings, strategies as st
from random_trees import GRAVITY, pinocchio_model, random_state, random_system

EVERY = settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
TREES = given(st.integers(0, 2**31), st.integers(1, 10))
DECADES = 12.0
BACKWARD = 1e-12  # of the largest force in an equation
SAME = 1e-9  # relative, of well conditioned trees
DIFFERENCE = 1e-7  # differences of H of fourth order over 4e-4 s: h^4/30 of its fifth derivative, and rounding over h


def trees(seed, n, decades):
    graph = build_graph(random_system(seed, n, decades))
    q, v = random_state(graph, seed)
    return [(tree, q[tree.q], v[tree.v]) for tree in cut(graph, set())], np.random.default_rng(seed)


def inertia(tree, q):
    """(n_v, n_v) the joint-space inertia matrix."""
    K = kinematics(tree, q, np.zeros(tree.v.stop - tree.v.start), 0.0)
    I, _ = composites(tree, K, [np.zeros(6)] * len(tree.bodies))
    H = np.zeros((tree.v.stop - tree.v.start,) * 2)
    for (k, l), x in joint_space_inertia(tree, K, I).items():
        H[k, l] = H[l, k] = x
    return H


@EVERY
@TREES
def test_inverse_dynamics_inverts_forward_dynamics(seed, n):
    parts, random = trees(seed, n, 3.0)
    for tree, q, v in parts:
        W = [random.normal(scale=1e4, size=6) for _ in tree.bodies]
        dv = random.normal(size=len(v))
        tau, _ = inverse_dynamics(tree, q, v, dv, W, GRAVITY)
        _, found, _ = dynamics(tree, q, v, tau, W, GRAVITY)
        assert np.array(found, float) == pytest.approx(dv, rel=SAME, abs=SAME)


@EVERY
@TREES
def test_forward_dynamics_balances_forces_over_twelve_decades_of_inertia(seed, n):
    parts, random = trees(seed, n, DECADES)
    for tree, q, v in parts:
        W = [np.zeros(6)] * len(tree.bodies)
        given_tau = random.normal(scale=1e3, size=len(v))
        _, dv, _ = dynamics(tree, q, v, given_tau, W, GRAVITY)
        dv = np.array(dv, float)
        tau, F = inverse_dynamics(tree, q, v, dv, W, GRAVITY)
        H = inertia(tree, q)
        size = np.abs(H) @ np.abs(dv) + max((np.abs(f).max() for f in F), default=0.0)
        assert np.all(np.abs(tau - given_tau) <= BACKWARD * len(tree.bodies) * (size + np.abs(given_tau)))


@EVERY
@TREES
def test_the_inertia_matrix_is_positive_definite_and_equals_an_independently_computed_matrix(seed, n):
    system = random_system(seed, n, 3.0)
    graph = build_graph(system)
    q, _ = random_state(graph, seed)
    model = pinocchio_model(graph)
    want = np.triu(pin.crba(model, model.createData(), q))
    want = want + np.triu(want, 1).T
    for tree in cut(graph, set()):
        H = inertia(tree, q[tree.q])
        assert np.allclose(H, want[tree.v, tree.v], rtol=SAME, atol=SAME * np.abs(want).max())
        assert len(H) == 0 or np.linalg.eigvalsh(H).min() > 0.0


@EVERY
@TREES
def test_the_inertia_matrix_stays_positive_definite_over_twelve_decades(seed, n):
    for tree, q, _ in trees(seed, n, DECADES)[0]:
        H = inertia(tree, q)
        if len(H):
            scale = 1.0 / np.sqrt(np.diag(H))  # so that light and heavy degrees of freedom are looked at alike
            assert np.linalg.eigvalsh(scale[:, None] * H * scale).min() > -BACKWARD


@EVERY
@TREES
def test_the_rate_of_the_inertia_matrix_is_the_coriolis_matrix_plus_its_transpose(seed, n):
    system = random_system(seed, n, 3.0)
    graph = build_graph(system)
    q, v = random_state(graph, seed)
    model = pinocchio_model(graph)
    C = pin.computeCoriolisMatrix(model, model.createData(), q, v)
    h = 1e-4
    weights = {1.0: 8.0, -1.0: -8.0, 2.0: -1.0, -2.0: 1.0}
    near = {s: pin.integrate(model, q, s * h * v) for s in weights}
    for tree in cut(graph, set()):
        rate = sum(w * inertia(tree, near[s][tree.q]) for s, w in weights.items()) / (12.0 * h)
        want = (C + C.T)[tree.v, tree.v]
        assert np.all(np.abs(rate - want) <= DIFFERENCE * np.abs(inertia(tree, q[tree.q])).max(initial=1.0))


@EVERY
@TREES
def test_the_rate_of_energy_is_the_power_of_the_joint_forces(seed, n):
    parts, random = trees(seed, n, 3.0)
    for tree, q, v in parts:
        tau = random.normal(scale=1e4, size=len(v))
        W = [np.zeros(6)] * len(tree.bodies)
        dq, dv, _ = dynamics(tree, q, v, tau, W, GRAVITY)
        dq, dv, h = np.array(dq, float), np.array(dv, float), 1e-6 / (1.0 + np.abs(np.array(dv, float)).max(initial=0))

        def energy(s, tree=tree, q=q, v=v, dq=dq, dv=dv, h=h):
            return sum(energies(tree, kinematics(tree, q + s * h * dq, v + s * h * dv, 0.0), GRAVITY))

        power = (energy(1.0) - energy(-1.0)) / (2.0 * h)
        turned_over = np.abs(tau) @ np.abs(v) + abs(energy(0.0)) * 1e-16 / h + 1.0
        assert power == pytest.approx(float(tau @ v), abs=1e-6 * turned_over + 60.0 * abs(energy(0.0)) * 1e-16 / h)
