"""Small dense linear algebra on Python floats: the same bits on every processor, without NumPy, BLAS or LAPACK.

Used for decisions and messages, where a few milliseconds do not matter: ranks, null spaces, least-norm solutions.
Matrices are lists of rows; products are summed exactly and rounded once (`fsum`), so that no order of summation counts.
Sources: Householder QR with column pivoting (Golub, Van Loan 2013, section 5.4.2), one-sided Jacobi rotations (section
8.6.3) on its triangle (Drmac, Veselic 2008), cyclic Jacobi for symmetric matrices (section 8.5.3).
"""

from collections.abc import Sequence
from math import copysign, fsum, inf, nan, sqrt
from operator import mul

Row = Sequence[float]
Matrix = Sequence[Row]

ORTHOGONAL = 1e-15  # cosine between columns that count as perpendicular
SWEEPS = 60  # far more than any matrix needs


def dot(a: Row, b: Row) -> float:
    """Return the dot product of two vectors, with an exact sum of the rounded products; inf or nan on overflow."""
    try:
        return fsum(map(mul, a, b))
    except OverflowError:
        return inf
    except ValueError:
        return nan


def cross(a: Row, b: Row) -> tuple[float, float, float]:
    """Return the cross product a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def norm(a: Row) -> float:
    """Return the Euclidean norm of a vector; the squares of its entries must not overflow."""
    return sqrt(dot(a, a))


def product(A: Matrix, x: Row) -> list[float]:
    """Return the product A x of a matrix and a vector."""
    return [dot(row, x) for row in A]


def solve(A: Matrix, b: Row) -> list[float]:
    """Return x with A x = b, by elimination with partial pivoting; raises ZeroDivisionError for a singular matrix."""
    return [x for (x,) in solutions(A, [[x] for x in b])]


def solutions(A: Matrix, B: Matrix) -> list[list[float]]:
    """Return X with A X = B for right-hand sides B (n, m), as `solve` does for one."""
    n, m = len(A), len(B[0]) if B else 0
    M = [[*row, *r] for row, r in zip(A, B, strict=True)]
    for s in range(n):
        pivot = max(range(s, n), key=lambda r: abs(M[r][s]))
        M[s], M[pivot] = M[pivot], M[s]
        for r in range(s + 1, n):
            if M[r][s]:
                x = M[r][s] / M[s][s]
                M[r][s:] = [p - x * q for p, q in zip(M[r][s:], M[s][s:], strict=True)]
    columns = [[0.0] * n for _ in range(m)]
    for k, out in enumerate(columns):
        for s in reversed(range(n)):
            out[s] = (M[s][n + k] - dot(M[s][s + 1 : n], out[s + 1 :])) / M[s][s]
    return [list(row) for row in zip(*columns, strict=True)]


def inverse(A: Matrix) -> list[list[float]]:
    """Return the inverse of a square matrix; raises ZeroDivisionError for a singular one."""
    n = len(A)
    return solutions(A, [[1.0 if i == j else 0.0 for j in range(n)] for i in range(n)])


def eigenvalues(A: Matrix) -> list[float]:
    """Return the eigenvalues of a symmetric matrix in ascending order."""
    M = [list(row) for row in A]
    n = len(M)
    for _ in range(SWEEPS):
        done = True
        for i in range(n):
            for j in range(i):
                if abs(M[i][j]) <= ORTHOGONAL * sqrt(abs(M[i][i])) * sqrt(abs(M[j][j])):
                    continue
                if M[i][i] + M[i][j] == M[i][i] and M[j][j] + M[i][j] == M[j][j]:
                    continue
                done = False
                c, s = _rotation(M[j][j], M[i][i], M[i][j])
                for k in range(n):
                    M[k][j], M[k][i] = c * M[k][j] - s * M[k][i], s * M[k][j] + c * M[k][i]
                M[j], M[i] = (
                    [c * p - s * q for p, q in zip(M[j], M[i], strict=True)],
                    [s * p + c * q for p, q in zip(M[j], M[i], strict=True)],
                )
                M[i][j] = M[j][i] = 0.0
        if done:
            break
    return sorted(M[i][i] for i in range(n))


def _rotation(a: float, b: float, off: float) -> tuple[float, float]:
    """Return the cosine and sine of the rotation that makes [[a, off], [off, b]] diagonal."""
    z = (b - a) / (2.0 * off)
    t = copysign(1.0, z) / (abs(z) + sqrt(1.0 + z * z))
    c = 1.0 / sqrt(1.0 + t * t)
    return c, c * t


def singular_values(A: Matrix) -> list[float]:
    """Return all min(m, n) singular values of a matrix (m, n) in descending order."""
    return [size for size, _ in decomposed(A)[0]]


def combinations(A: Matrix, least: float) -> list[dict[int, float]]:
    """Return a basis of the left null space of A: combinations of rows that sum to zero, as coefficients by row number.

    Elimination with complete pivoting keeps zeros, so that locally coupled rows give local vectors; remainders up to
    `least` times the largest element count as zero.
    """
    rows = [{j: x for j, x in enumerate(row) if x} for row in A]
    made: list[dict[int, float]] = [{i: 1.0} for i in range(len(rows))]
    waiting = list(range(len(rows)))
    smallest = least * max((abs(x) for row in rows for x in row.values()), default=0.0)
    while waiting:
        size, s, c = max(
            ((abs(x), -i, -j) for i in waiting for j, x in rows[i].items()), default=(0.0, 0, 0)
        )  # fmt: skip
        if not size > smallest:
            break
        s, c = -s, -c
        waiting.remove(s)
        for i in waiting:
            if c in rows[i]:
                x = rows[i].pop(c) / rows[s][c]
                for into, what in ((rows[i], rows[s]), (made[i], made[s])):
                    for j, y in what.items():
                        if into is made[i] or j != c:
                            into[j] = into.get(j, 0.0) - x * y
    return [made[i] for i in waiting]


def least_norm(A: Matrix, b: Row, least: float = 0.0) -> list[float]:
    """Return the minimum-norm least-squares solution x of A x = b; singular values up to `least` count as zero."""
    n = len(A[0]) if A else 0
    x = [0.0] * n
    for size, direction in decomposed(A, n)[0]:
        if size > least:
            # with u = A v / size, the part of b along u is (A v) . b / size
            part = dot(product(A, direction), b) / (size * size)
            x = [p + part * q for p, q in zip(x, direction, strict=True)]
    return x


def decomposed(A: Matrix, n: int = -1) -> tuple[list[tuple[float, list[float]]], list[list[float]]]:
    """Return the singular values of a matrix in descending order with their right singular vectors, and a basis of its
    null space.

    n: number of columns, needed for a matrix without rows.
    """
    n = len(A[0]) if n < 0 and A else max(n, 0)
    rows = [list(r) for r in A if any(r)]
    # A^T P = Q R: the rows of A, long ones first, in an orthonormal basis Q of what they span
    Q: list[list[float]] = []  # Householder vectors
    R: list[list[float]] = []
    left = rows
    while left and len(Q) < n:
        k = len(Q)
        sizes = [dot(r[k:], r[k:]) for r in left]
        first = max(range(len(left)), key=lambda i: (sizes[i], -i))
        if not sizes[first] > 0.0:
            break
        left[0], left[first] = left[first], left[0]
        size = sqrt(sizes[first])
        v = [0.0] * k + left[0][k:]
        v[k] += copysign(size, v[k])
        scale = 2.0 / dot(v, v)
        left = [_reflected(r, v, scale) for r in left]
        Q.append(v)
        R.append(left[0][: k + 1])
        left = left[1:]
    R += [r[: len(Q)] for r in left]  # what is left of further rows once n of them span everything
    m = len(Q)
    # A = L Q^T with L (rows, m), lower trapezoidal: rotate the columns of L until they are perpendicular
    columns = [[r[k] if k < len(r) else 0.0 for r in R] for k in range(m)]
    V = [[1.0 if i == j else 0.0 for j in range(m)] for i in range(m)]
    for _ in range(SWEEPS):
        done = True
        for i in range(m):
            for j in range(i):
                a, b, off = dot(columns[j], columns[j]), dot(columns[i], columns[i]), dot(columns[i], columns[j])
                if not abs(off) > ORTHOGONAL * sqrt(a) * sqrt(b):
                    continue
                done = False
                c, s = _rotation(a, b, off)
                for M in (columns, V):
                    M[j], M[i] = (
                        [c * p - s * q for p, q in zip(M[j], M[i], strict=True)],
                        [s * p + c * q for p, q in zip(M[j], M[i], strict=True)],
                    )
        if done:
            break

    def back(x: list[float]) -> list[float]:
        out = [*x, *(0.0 for _ in range(n - len(x)))]
        for v in reversed(Q):
            out = _reflected(out, v, 2.0 / dot(v, v))
        return out

    pairs = sorted(((norm(c), i) for i, c in enumerate(columns)), key=lambda p: (-p[0], p[1]))
    found = [(size, back(V[i])) for size, i in pairs]
    rest = [back([0.0] * k + [1.0]) for k in range(m, n)]
    return found, rest


def _reflected(r: list[float], v: list[float], scale: float) -> list[float]:
    x = scale * dot(r, v)
    return [p - x * q for p, q in zip(r, v, strict=True)]
