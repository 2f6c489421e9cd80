"""Loops of native code solve dense systems like LAPACK, with the pivots of the same algorithm in Python."""

import numpy as np
import pytest
from heavylift.kernel.compiler import OPAQUE, FactorLayout, Library, LoopEmitter, Primitive, module, solver

ROUNDED = 1e-12  # of a solution: condition numbers stay below 1e3
BESIDE = 3  # components that belong to no equation
START = 5  # numbers before the factors in their block


def native(factors: FactorLayout, ny: int) -> tuple[Library, Primitive]:
    code = LoopEmitter("factorise", ["M"])
    factors.factorise(code)
    factorise = Primitive("factorise", lambda M: {}, {"M": OPAQUE}, {}, code.text())
    solve = solver("solve", factors, ny)
    return Library("", lambda: module(factorise, solve), cache=False), solve


@pytest.mark.parametrize("planes", [1, 2])
@pytest.mark.parametrize("n", [1, 7, 8, 9, 24, 55])
def test_machine_code_solves_linear_systems_of_every_size(n, planes):
    rng = np.random.default_rng(n)
    number = (1.0, 1j)[:planes]
    A, b = (sum(x * rng.standard_normal(shape) for x in number) for shape in ((n, n), n + BESIDE))
    A[rng.random((n, n)) < 0.3] = 0.0  # zeros on the diagonal want row exchanges
    A += (0.1 * n) * np.eye(n)[rng.permutation(n)]
    factors = FactorLayout(n, planes, START)
    library, solve = native(factors, n + BESIDE)
    M = np.zeros(factors.stop)
    factors.write(M, A)
    floats = M.copy()
    library.call("factorise", M)
    factors.factorise_floats(floats)
    parts = [np.ascontiguousarray(x) for x in (b.real, b.imag)[:planes]]
    tail = np.array([0.5, 2.0][:planes])
    out = [np.zeros(n + BESIDE) for _ in parts]
    library.call("solve", M, *parts, tail, *out)
    got = sum(x * part for x, part in zip(number, out, strict=True))
    want = np.append(np.linalg.solve(A, b[:n]), b[n:] * (tail @ number))
    assert got == pytest.approx(want, rel=ROUNDED, abs=ROUNDED * np.abs(want).max())
    again = solve.body(M=floats, tail=tail, **dict(zip(("b_re", "b_im"), parts, strict=False)))
    assert out[0] == pytest.approx(again["re"], rel=ROUNDED, abs=ROUNDED * np.abs(want).max())


def test_machine_code_solves_a_singular_matrix_with_results_that_are_not_finite():
    factors = FactorLayout(4, 1, 0)
    library, _ = native(factors, 4)
    for A in (np.zeros((4, 4)), np.full((4, 4), np.nan), np.full((4, 4), np.inf)):
        M, x = np.zeros(factors.stop), np.zeros(4)
        factors.write(M, A)
        library.call("factorise", M)
        library.call("solve", M, np.ones(4), np.ones(1), x)
        assert not np.isfinite(x).all()
