"""Modes of flexible bodies agree with LAPACK and have the same bits on every processor."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from heavylift.kernel.algebra import (
    derivative,
    eigen,
    eigenmodes,
    factored,
    integral,
    largest,
    roots,
    series,
    spline,
    times,
    total,
)
from heavylift.kernel.algebra.eigenvalues import product
from heavylift.kernel.description import Beam, Flexible, Nodal
from heavylift.kernel.multibody.flexible import (
    beam_matrices,
    modes_of,
    nodes_of,
    reduced,
    rigid_motions,
    track as track_of,
)
from numpy.polynomial import chebyshev
from scipy.interpolate import make_interp_spline

PLAIN = {"OPENBLAS_CORETYPE": "Prescott", "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4"}  # libraries without AVX
EXACT = 1e-12  # both algorithms are backward stable, and these matrices of random numbers well conditioned
FINE = 1e-7  # what LAPACK leaves open in the lowest modes of beams of many elements
TUBE = Beam(150.0, 1.7e4, EI_y=4e12, EI_z=4e12, elements=20)
SOLID = Beam(30.0, 500.0, 2e9, 1e9, 6e9, 4e8, 900.0, elements=12)


def plain(x):
    return tuple(tuple(map(float, row)) for row in x)


def bodies():
    """By name: slender and solid, each frame, equal stiffness in two planes, loads, matrices."""
    M, K = beam_matrices(SOLID)
    matrices = Nodal(plain(nodes_of(SOLID)), plain(M), plain(K))
    return {
        "girder": Flexible(3, Beam(150.0, 1.7e4, EI_y=4e12), frame="simply supported"),
        "tube": Flexible(6, TUBE, frame="simply supported"),
        "free tube": Flexible(6, TUBE, frame="free"),
        "boom": Flexible(8, SOLID),
        "free boom": Flexible(8, SOLID, frame="free"),
        "loaded": Flexible(2, TUBE, frame="simply supported", loads=(40.0, 75.0)),
        "matrices": Flexible(5, nodal=Nodal(matrices.nodes, matrices.mass, matrices.stiffness, tuple(range(6)))),
        "free matrices": Flexible(5, nodal=matrices),
    }


def bits(flexible: Flexible) -> str:
    """Of all constants of a body."""
    modes = modes_of("body", flexible)
    e = reduced(modes)
    parts = [modes.shapes, modes.mass, modes.stiffness, modes.smallness.rows, e.J0, e.J1, e.J2, e.G0, e.G1]
    if flexible.beam:
        track = track_of(modes, "joint")
        parts += [track.coefficients, track.shortening, modes.at(11.3), modes.shortening(11.3)]
    push, places, still = np.array([[-1e6, 0.0, 0.0]]), np.array([[29.0, 0.0, 0.0]]), np.zeros(3)
    parts.append(np.array([modes.column.part(push, places, still, still)]))
    return hashlib.sha256(b"".join(np.ascontiguousarray(x).tobytes() for x in parts)).hexdigest()


def test_modes_are_bit_identical_with_and_without_wide_cpu_instructions():
    here = Path(__file__)
    folders = [str(here.parent), str(here.parents[1])]
    code = f"import sys; sys.path[:0] = {folders!r}; from {here.stem} import bits, bodies; "
    code += "print(*(bits(b) for b in bodies().values()))"
    command = [sys.executable, "-c", code]
    out = subprocess.run(command, env={**os.environ, **PLAIN}, check=True, capture_output=True, text=True).stdout
    assert dict(zip(bodies(), out.split(), strict=True)) == {name: bits(b) for name, b in bodies().items()}


@pytest.mark.parametrize(("n", "sought"), [(1, 1), (2, 2), (5, 3), (30, 30), (60, 4), (90, 7)])
def test_eigenvalues_of_the_kernel_agree_with_lapack(n, sought):
    random = np.random.default_rng(n)
    A, B = (x @ x.T + np.eye(n) for x in random.normal(size=(2, n, n)))
    values, vectors = largest(B, A, sought)
    want = scipy.linalg.eigh(B, A)[0][::-1][:sought]
    assert values == pytest.approx(want, rel=EXACT)
    assert vectors.T @ A @ vectors == pytest.approx(np.eye(sought), abs=EXACT * n)
    assert B @ vectors == pytest.approx(A @ vectors * values, abs=EXACT * n * np.abs(B).max())


@pytest.mark.parametrize("n", [1, 2, 7, 40])
def test_matrix_products_sums_and_solutions_of_the_kernel_agree_with_lapack(n):
    random = np.random.default_rng(n)
    A, X = random.normal(size=(n, n)), random.normal(size=(n, 3))
    S = A @ A.T + np.eye(n)
    assert times(A, X) == pytest.approx(A @ X, abs=EXACT * n)
    assert total(X) == pytest.approx(X.sum(axis=0), abs=EXACT)
    assert S @ factored(S).solve(X) == pytest.approx(X, abs=EXACT * n)
    values, vectors = eigen(S)
    assert values == pytest.approx(np.linalg.eigvalsh(S), rel=EXACT)
    assert S @ vectors == pytest.approx(vectors * values, abs=EXACT * n * n)


@pytest.mark.parametrize("elements", [8, 50])
@pytest.mark.parametrize("held", [[*range(6)], []], ids=["clamped", "free"])
def test_modes_of_a_beam_agree_with_lapack(held, elements):
    beam = Beam(30.0, 500.0, 2e9, 1e9, 6e9, 4e8, 900.0, elements=elements)
    M, K = beam_matrices(beam)
    free = [d for d in range(len(M)) if d not in held]
    M, K, rigid = M[np.ix_(free, free)], K[np.ix_(free, free)], rigid_motions(nodes_of(beam))[free, len(held) :]
    shapes = eigenmodes(M, K, 8, rigid)
    mass, stiffness = np.diag(shapes.T @ M @ shapes), np.diag(shapes.T @ K @ shapes)
    first = rigid.shape[1]
    assert stiffness / mass == pytest.approx(scipy.linalg.eigh(K, M)[0][first : first + 8], rel=FINE)


def test_each_bending_mode_of_a_tube_with_round_cross_section_lies_in_one_principal_plane():
    """Its frequencies are equal in both, so that any mixture would be modes as well."""
    parts = modes_of("tube", Flexible(6, TUBE, frame="simply supported")).shapes.reshape(-1, 6, 6)
    across, up = np.abs(parts[:, 1]).max(axis=0), np.abs(parts[:, 2]).max(axis=0)
    assert np.count_nonzero(across) == np.count_nonzero(up) == 3
    assert not np.any(across * up)


@pytest.mark.parametrize("degree", [1, 3, 5, 7])
def test_splines_of_the_kernel_agree_with_scipy(degree):
    x, values = np.linspace(0.0, 150.0, 33), np.random.default_rng(degree).normal(size=(33, 4))
    at = 75.0 * (1.0 + roots(50))
    assert spline(x, values, degree, at) == pytest.approx(make_interp_spline(x, values, k=degree)(at), abs=EXACT)


@pytest.mark.parametrize("n", [1, 2, 3, 9])
def test_chebyshev_series_of_the_kernel_agree_with_numpy(n):
    random = np.random.default_rng(n)
    a, b, values = random.normal(size=n), random.normal(size=n), random.normal(size=12)
    x = np.linspace(-1.0, 1.0, 7)
    for own, other in (
        (product(a, b), chebyshev.chebmul(a, b)),
        (derivative(a), chebyshev.chebder(a)),
        (integral(a), chebyshev.chebint(a, lbnd=-1.0)),
        (series(values, n - 1), chebyshev.chebfit(roots(12), values, n - 1)),
    ):
        assert chebyshev.chebval(x, own) == pytest.approx(chebyshev.chebval(x, other), abs=EXACT)
