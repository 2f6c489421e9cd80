"""Ranks, null spaces, least-norm solutions and eigenvalues on Python floats, against NumPy's LAPACK."""

import hashlib
import struct

import numpy as np
import pytest
from heavylift.kernel.algebra import (  # fmt: skip
    combinations,
    decomposed,
    dot,
    least_norm,
    norm,
    singular_values,
    solve,
)
from heavylift.kernel.algebra.dense import eigenvalues, product  # fmt: skip

CLOSE = 1e-12  # relative to the largest: some hundred roundings
ZERO = 1e-9  # singular values of the matrices below are either far above or rounding
SHAPES = [(3, 5, 2), (5, 3, 3), (8, 8, 5), (20, 12, 7), (1, 1, 1), (6, 1, 1), (1, 6, 1), (12, 20, 12)]


def matrix(m, n, rank, seed=0):
    random = np.random.default_rng([seed, m, n, rank])
    return random.normal(size=(m, rank)) @ random.normal(size=(rank, n))


def null_space(A, n, least):
    """Vectors that A, of n columns, maps to less than `least` of their length."""
    found, rest = decomposed(A, n)
    return [direction for size, direction in found if size <= least] + rest


@pytest.mark.parametrize(("m", "n", "rank"), SHAPES)
def test_singular_values_and_null_spaces_agree_with_numpy(m, n, rank):
    A = matrix(m, n, rank)
    want = np.linalg.svd(A, compute_uv=False)
    got = singular_values(A.tolist())
    assert got == pytest.approx(want[: len(got)], abs=CLOSE * want[0])
    N = np.array(null_space(A.tolist(), n, ZERO)).reshape(-1, n)
    assert len(N) == n - rank
    assert pytest.approx(np.zeros((m, n - rank)), abs=CLOSE * want[0]) == A @ N.T
    assert pytest.approx(np.eye(n - rank), abs=CLOSE) == N @ N.T


@pytest.mark.parametrize(("m", "n", "rank"), SHAPES)
def test_the_least_norm_solution_equals_that_of_the_pseudo_inverse(m, n, rank):
    A = matrix(m, n, rank, 1)
    b = np.random.default_rng(m).normal(size=m)
    want = np.linalg.pinv(A, ZERO) @ b
    assert least_norm(A.tolist(), b.tolist(), ZERO) == pytest.approx(want, abs=1e2 * CLOSE * np.abs(want).max())


@pytest.mark.parametrize(("m", "n", "rank"), SHAPES)
def test_linear_combinations_of_matrix_rows_that_vanish_are_found(m, n, rank):
    A = matrix(m, n, rank, 2)
    found = combinations(A.tolist(), ZERO)
    Z = np.array([[distance.get(i, 0.0) for i in range(m)] for distance in found]).reshape(-1, m)
    assert len(Z) == m - rank
    assert not len(Z) or np.linalg.matrix_rank(Z) == len(Z)
    assert pytest.approx(np.zeros((m - rank, n)), abs=1e2 * CLOSE * np.abs(A).max()) == Z @ A


def test_vanishing_combinations_of_matrix_rows_do_not_mix_independent_blocks_of_the_matrix():
    """Two blocks that share nothing: no combination has a part in both."""
    A = np.zeros((6, 4))
    A[:3, :2], A[3:, 2:] = matrix(3, 2, 2), matrix(3, 2, 1)
    assert all(set(distance) <= {0, 1, 2} or set(distance) <= {3, 4, 5} for distance in combinations(A.tolist(), ZERO))


@pytest.mark.parametrize("n", [1, 2, 3, 6, 15])
def test_eigenvalues_and_solutions_of_linear_equations_agree_with_numpy(n):
    S = matrix(n, n, n)
    S = S + S.T
    assert eigenvalues(S.tolist()) == pytest.approx(np.linalg.eigvalsh(S), abs=CLOSE * np.abs(S).max() * n)
    A, b = matrix(n, n, n, 3), np.arange(1.0, n + 1.0)
    want = np.linalg.solve(A, b)
    assert solve(A.tolist(), b.tolist()) == pytest.approx(want, rel=1e-8)
    assert product(A.tolist(), want.tolist()) == pytest.approx(b, rel=1e-8)


def test_the_kernel_functions_of_dense_algebra_accept_zero_matrices_and_empty_matrices():
    assert singular_values([[0.0, 0.0], [0.0, 0.0]]) == []
    assert null_space([], 2, ZERO) == [[1.0, 0.0], [0.0, 1.0]]
    assert eigenvalues([[0.0, 0.0], [0.0, 0.0]]) == [0.0, 0.0]
    with pytest.raises(ZeroDivisionError):
        solve([[1.0, 2.0], [2.0, 4.0]], [1.0, 2.0])


def test_a_sum_of_products_does_not_depend_on_the_order_of_terms():
    random = np.random.default_rng(7)
    a, b = random.normal(size=1000) * 10.0 ** random.integers(-8, 8, 1000), random.normal(size=1000)
    order = random.permutation(1000)
    assert dot(a.tolist(), b.tolist()) == dot(a[order].tolist(), b[order].tolist())
    assert norm([3.0, 4.0]) == 5.0


def test_dense_algebra_gives_bit_identical_results_on_every_processor():
    """Additions, products, divisions and roots of IEEE 754: any machine that has them gives this digest."""
    rows = [[((7 * i + 3 * j) % 11 - 5) / 7.0 for j in range(5)] for i in range(6)]
    numbers = [*singular_values(rows), *least_norm(rows, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], ZERO)]
    message = hashlib.sha256(struct.pack(f"<{len(numbers)}d", *numbers)).hexdigest()
    assert message[:16] == "7953248964fed1b0"
