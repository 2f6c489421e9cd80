"""The pivoting solver against an exhaustive search of active sets; friction solutions against Coulomb's conditions."""

from itertools import product

import numpy as np
import pytest
from heavylift.kernel.algebra import skew
from heavylift.kernel.constraints import ROUNDS, pivot, round_of, solve, start_of
from heavylift.kernel.simulation.impacts import ContactProblem, settle, sweep

EXACT = 1e-12  # of a well-conditioned problem of order one
CONDITION = 1e-7  # to which each condition of a contact of order one holds


def all_solutions(A, b, lo, hi):
    """Every set tried one after the other."""
    for side in product((-1, 0, 1), repeat=len(b)):
        s = np.array(side)
        if np.isinf(lo[s < 0]).any() or np.isinf(hi[s > 0]).any():
            continue
        x, free = np.where(s < 0, lo, np.where(s > 0, hi, 0.0)), s == 0
        x[free] = 0.0
        if free.any():
            x[free] = np.linalg.solve(A[np.ix_(free, free)], -(b + A @ x)[free])
        w = A @ x + b
        if (x >= lo - EXACT).all() and (x <= hi + EXACT).all() and (w[s < 0] >= 0).all() and (w[s > 0] <= 0).all():
            yield x


def random_box_problem(rng):
    n = int(rng.integers(1, 6))
    B = rng.normal(size=(n, n))
    lo = np.where(rng.random(n) < 0.5, 0.0, -rng.random(n))
    hi = np.where(rng.random(n) < 0.5, np.inf, rng.random(n))
    return B @ B.T + 0.1 * np.eye(n), rng.normal(size=n), lo, hi


def test_the_active_set_found_by_pivoting_is_that_of_an_exhaustive_search():
    rng = np.random.default_rng(3)
    for _ in range(100):
        problem = random_box_problem(rng)
        s = solve(*problem)
        (x,) = all_solutions(*problem)
        assert s.found
        assert s.x == pytest.approx(x, abs=1e-11)


@pytest.mark.parametrize("n", [1, 5, 6, 9])
def test_machine_code_and_interpreted_python_make_the_same_pivots_with_the_same_bits(n):
    """Filled up with rows that have no part in it."""
    rng = np.random.default_rng(7)
    for _ in range(20):
        B, b = rng.normal(size=(n, n)), rng.normal(size=n)
        A, lo, hi = B @ B.T + 0.1 * np.eye(n), -rng.random(n), rng.random(n)
        s, native = start_of(n, np.zeros(n)), start_of(n, np.zeros(n))
        while s.run > 0.0:
            round_of(s, A, b, lo, hi, EXACT, EXACT)
        pivot(native, A, b, lo, hi, (EXACT, EXACT))
        assert native.x.tobytes() == np.array(s.x).tobytes()
        assert native.w.tobytes() == np.array(s.w).tobytes()
        assert native.side.tobytes() == np.array(s.side, float).tobytes()
        assert (native.budget, native.number, native.run) == (s.budget, s.number, s.run)


def test_of_four_equal_ropes_one_goes_slack_under_an_eccentric_load():
    """A table on four legs: three equations for four forces; the solver neither fails nor prefers one leg."""
    corners = np.array([(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)])
    G = np.column_stack([np.ones(4), corners])
    central = solve(G @ G.T, -G @ [1.0, 0.0, 0.0], np.zeros(4), np.full(4, np.inf))
    assert central.x == pytest.approx([0.25] * 4, abs=1e-9)
    far = solve(G @ G.T, -G @ [1.0, 0.7, 0.7], np.zeros(4), np.full(4, np.inf))
    assert far.found
    assert far.x[2] == 0.0, "the leg opposite of the load is slack"
    assert G.T @ far.x == pytest.approx([1.0, 0.7, 0.7], abs=1e-8)


def test_a_complementarity_problem_without_a_solution_is_reported_as_unsolvable():
    assert not solve(np.array([[-1.0]]), np.array([-1.0]), np.zeros(1), np.full(1, np.inf)).found


def body_on_points(rng, m, flat, friction):
    """m contacts with level ground of one free body with random forces."""
    places = np.column_stack([rng.normal(size=(m, 2)), np.full(m, -0.5) if flat else rng.normal(size=m)])
    G = np.array([np.hstack([np.eye(3), -skew(p)])[i] for p in places for i in (2, 0, 1)])
    force = rng.normal(size=6) - [0.0, 0.0, 2.0, 0.0, 0.0, 0.0]
    mobility = np.diag([1.0, 1.0, 1.0, *(1.0 / (0.5 + rng.random(3)))])
    return ContactProblem(G @ mobility @ G.T, G @ force, np.full(m, friction), np.zeros((m, 2)))


def breach(c, x):
    """By how much the worst condition of unilateral contact and Coulomb friction is broken."""
    w, worst = c.A @ x + c.b, 0.0
    for i, mu in enumerate(c.mu):
        n, t, wn, wt = x[3 * i], x[3 * i + 1 : 3 * i + 3], w[3 * i], w[3 * i + 1 : 3 * i + 3]
        held, speed = np.hypot(*t), np.hypot(*wt)
        worst = max(worst, -n, -wn, abs(n * wn), held - mu * n)
        worst = max(worst, speed * (mu * n - held), t @ wt + held * speed)  # moves only at the limit, against friction
    return worst


@pytest.mark.parametrize("m", [1, 2, 3, 4, 8])
@pytest.mark.parametrize("flat", [True, False])
def test_each_contact_force_pushes_and_obeys_the_law_of_coulomb_for_sticking_or_sliding(m, flat):
    rng = np.random.default_rng(m)
    for friction in (0.0, 0.1, 0.3, 0.5) * 3:
        c = body_on_points(rng, m, flat, friction)
        f = settle(c)
        assert f.found
        assert breach(c, f.x) < CONDITION
        assert (f.x[::3][~f.push] == 0.0).all()


def test_the_pivoting_solver_agrees_with_gauss_seidel_sweeps_where_contact_forces_are_unique():
    rng = np.random.default_rng(11)
    for _ in range(20):
        c = body_on_points(rng, 1, False, 0.3)
        x, settled = sweep(c.A, c.b, c.mu, c.moving)
        assert settled
        assert settle(c).x == pytest.approx(x, abs=1e-9)


def test_a_steeply_scraping_rod_has_no_consistent_contact_force():
    """Painleve: m = 1, half length 1, I = 1/3, at 60 degrees: with mu = 2 pushing the tip lowers it."""
    angle, mu = np.radians(60.0), 2.0
    r = np.array([np.cos(angle), -np.sin(angle)])  # from the centre to the tip
    n, t = np.array([0.0, 1.0, r[0]]), np.array([1.0, 0.0, -r[1]])
    G = np.array([n, t, [0.0, 0.0, 0.0]])
    mobility = np.diag([1.0, 1.0, 3.0])
    A, b = G @ mobility @ G.T, np.array([-1.0, 0.0, 0.0])
    against = A[0, 0] - mu * A[0, 1]
    assert against < 0.0, "the inequality of Painleve's paradox"
    sliding = ContactProblem(A, b, np.array([mu]), np.array([[1.0, 0.0]]))
    assert not settle(sliding).found
    assert settle(ContactProblem(A, b, np.array([mu]), np.array([[-1.0, 0.0]]))).found, (
        "the other way it is an easy case"
    )


def test_block_pivoting_needs_few_of_its_allowed_iterations():
    rng = np.random.default_rng(5)
    B = rng.normal(size=(12, 12))
    A, b = B @ B.T, rng.normal(size=12)
    s = start_of(12, -np.ones(12))
    while s.run > 0.0:
        round_of(s, A, b, np.zeros(12), np.full(12, np.inf), 1e-12, 1e-12)
    assert s.number == 0.0
    assert ROUNDS * 12 - s.budget < 30
