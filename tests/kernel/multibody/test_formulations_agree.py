"""The paper's embedding, augmented and recursive formulations give the same motion and the same drive forces."""

from dataclasses import replace

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.multibody import build_graph, cut
from heavylift.kernel.multibody.formulations import FORMULATIONS
from heavylift.kernel.simulation import Simulation
from hypothesis import HealthCheck, given, settings, strategies as st
from random_trees import GRAVITY, KINDS, random_state, random_system
from small_scenes import SECOND, hand_over, hung, started
from test_the_four_link_arm import WANT, arm

AGREE = 1e-9  # relative: the acceptance of the issue
TREES = given(st.integers(0, 2**31), st.integers(1, 9))
SOME = settings(max_examples=25, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
OTHERS = [name for name in FORMULATIONS if name != "recursive"]


@SOME
@TREES
def test_formulations_agree_on_random_trees_with_prescribed_joints(seed, n):
    system, random = random_system(seed, n, 3.0, kinds=(*KINDS, "constant-velocity")), np.random.default_rng(seed)
    graph = build_graph(system)
    q, v = random_state(graph, seed)
    driven = {k for k in range(graph.nv) if random.random() < 0.2}
    for tree in cut(graph, driven):
        tau = random.normal(scale=1e4, size=len(v[tree.v]))
        W = [random.normal(scale=1e4, size=6) for _ in tree.bodies]
        a_ref = random.normal(size=len(tree.prescribed_dofs))
        results = {
            name: [np.array(x, float) for x in f(tree, q[tree.q], v[tree.v], tau, W, GRAVITY, a_ref)]
            for name, f in FORMULATIONS.items()
        }
        for name in OTHERS:
            for found, want in zip(results[name], results["recursive"], strict=True):
                assert np.abs(found - want).max(initial=0.0) <= AGREE * np.abs(want).max(initial=1.0), name


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_an_arm_of_slender_links_has_the_same_accelerations_in_every_formulation(formulation):
    """C19b: links without inertia about their own axes, which leave no inverse of M to the augmented formulation."""
    simulation = started(arm(), formulation=formulation)
    assert simulation.X[simulation.method.layout.at["f"]][4:8] == pytest.approx(WANT["qdd"], rel=AGREE)


@pytest.mark.parametrize("formulation", OTHERS)
def test_a_run_gives_the_same_motion_with_every_formulation_of_the_equations(formulation):
    for system in (hung(59.9, v0=1.0), arm()):  # a rope that slackens, links that fall
        states = []
        for name in ("recursive", formulation):
            simulation = started(system, tolerance=1e-10, formulation=name)
            hand_over(simulation, SECOND)
            states.append(simulation.state.copy())
        assert states[1] == pytest.approx(states[0], rel=1e-7, abs=1e-7)


@pytest.mark.parametrize("formulation", OTHERS)
def test_massless_parts_with_prescribed_joints_are_solved_in_every_formulation(formulation):
    """The force cells of the arm: links hang on pairs of massless sliders."""
    system = arm(cells=True)
    held = tuple(replace(j, v0=(0.0,)) for j in system.joints)
    graph = build_graph(replace(system, joints=held))
    (tree,) = cut(graph, {graph.coordinate(d.name, d.joint)[1] for d in system.drives})
    q, n = np.array([x for j in held for x in j.q0 or (0.0,)]), len(tree.bodies)
    given = (q, np.zeros(n), np.zeros(n), [np.zeros(6)] * n, system.gravity, np.zeros(len(system.drives)))
    _, dv, forces = FORMULATIONS["recursive"](tree, *given)
    _, other_dv, other_forces = FORMULATIONS[formulation](tree, *given)
    assert np.array(other_dv, float) == pytest.approx(np.array(dv, float), rel=AGREE, abs=AGREE)
    assert np.array(other_forces, float) == pytest.approx(np.array(forces, float), rel=AGREE, abs=1e-6)


def test_an_unknown_formulation_is_refused():
    with pytest.raises(
        KernelError, match="formulation 'magic' does not exist; choose recursive, articulated, embedding, augment"
    ):
        Simulation(hung(60.0), formulation="magic")
