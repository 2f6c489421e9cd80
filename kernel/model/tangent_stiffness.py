"""The tangent stiffness of a scene in one native call: derivatives of the accelerations along every degree of freedom.

Central differences of the traced rate at rest, and LU factors of the matrix that they give; native loops, so that the
bits depend on no installed library. Discrete states are frozen; a column is marked if a guard became negative during
its differences, since clamping of a law may falsify it.

Kinetic energy of a scene by bodies and by joint velocities, at one pose, for any velocities there.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import SimpleNamespace

import numpy as np
from heavylift.kernel.compiler.function import OPAQUE, Outputs, Places, Primitive
from heavylift.kernel.compiler.native_linear_algebra import FactorLayout, solver
from heavylift.kernel.compiler.native_loops import VECTOR, LoopEmitter, padded
from heavylift.kernel.compiler.simd_batches import WIDEST
from heavylift.kernel.compiler.symbol import Array, Scalar
from heavylift.kernel.multibody.formulations.augmented import velocity_transformation
from heavylift.kernel.multibody.graph import coordinate_names
from heavylift.kernel.multibody.kinematics import body_inertia, elastic, kinematics, shared_inertia
from heavylift.kernel.multibody.trees import with_numbers

from .newton_step import newton_step
from .program import Program

FOURTH, SECOND = (2.0 / 3.0, -1.0 / 12.0), (0.5, 0.0)  # order of central differences: weights of h f'(0)

Rate = Callable[..., SimpleNamespace]  # (t (2,), y (ny,), P) -> dy, T, G, ... by name


@dataclass(frozen=True)
class Tangent:
    """Native functions that compute the tangent stiffness of a scene.

    `abreast`: largest number of degrees of freedom of a joint; as many evaluations give the coordinate rates of unit
    velocities, for all joints at once. Block G: guards. Block J: per velocity the derivative of all accelerations
    (nv,), then whether a guard became negative.
    """

    nq: int
    nv: int
    free: tuple[int, ...]  # velocities that no drive prescribes
    quaternions: tuple[int, ...]  # first coordinates of them
    abreast: int
    sizes: dict[str, int]  # of the arrays that `rate` returns, the derivative (ny,) first

    @property
    def n(self) -> int:
        """Number of free degrees of freedom."""
        return len(self.free)

    @cached_property
    def factors(self) -> FactorLayout:
        """Layout of an (n, n) matrix over the free degrees of freedom, stored at the start of block M."""
        return FactorLayout(self.n, 1, 0)

    @property
    def work(self) -> int:
        """Size, in numbers, of the work block of the native function `tangent`: state, results, displacements."""
        return self.sizes["dy"] + sum(self.sizes.values()) + self.abreast * self.nq

    def functions(self, rate: Rate) -> list[Primitive]:
        """Return the native functions that compute the tangent stiffness, factorise it, and solve with its factors.

        `tangent`(t, y, P, G, order, columns, work, J), `factorise_tangent`(M), `solve_tangent`(M, b, tail, x), and the
        `newton_step`. order: weights of the two differences; columns (nv, 4): difference step (0: skip this column),
        number of the evaluation with its coordinate rates, and the range of coordinates that it displaces.
        """
        c = LoopEmitter("factorise_tangent", ["M"])
        self.factors.factorise(c)

        def factorise(M: np.ndarray) -> Outputs:
            self.factors.factorise_floats(M)
            return {}

        factorised = Primitive(c.name, factorise, {"M": OPAQUE}, {}, c.text())
        solved = solver("solve_tangent", self.factors, self.n)
        moved = newton_step(rate, self.sizes, self.nq, self.free, self.quaternions, self.factors)
        return [self._differences(rate), factorised, solved, moved]

    def _differences(self, rate: Rate) -> Primitive:
        inputs = dict.fromkeys(("t", "y", "P", "G", "order", "columns", "work", "J"), OPAQUE)
        c = LoopEmitter("tangent", list(inputs))
        ny, nq, nv, width = self.sizes["dy"], self.nq, self.nv, self.nv + 1
        moved, out, place = "%work", {}, ny
        for name, n in self.sizes.items():
            out[name], place = c.at("%work", place), place + n
        along = c.at("%work", place)

        def evaluate() -> None:
            c.call("rate", ["%t", moved, "%P", *out.values()])

        def copied(n: int, source: str, target: str) -> None:
            with c.loop(0, n) as i:
                c.store(c.load(c.at(source, i)), c.at(target, i))

        def number(k: str, what: int) -> str:
            return c.let(f"fptosi double {c.load(c.at('%columns', c.integer('mul', k, 4), what))} to i64")

        def asked(k: str) -> str:
            return c.let(f"fcmp une double {c.load(c.at('%columns', c.integer('mul', k, 4)))}, 0.0")

        with c.loop(0, self.abreast) as m:
            copied(ny, "%y", moved)
            with c.loop(0, nv) as k:
                now = c.let(f"icmp eq i64 {number(k, 1)}, {m}")
                one = c.let(f"and i1 {now}, {asked(k)}")
                c.store(c.let(f"select i1 {one}, double 1.0, double 0.0"), c.at(moved, nq, k))
            evaluate()
            copied(nq, out["dy"], c.at(along, c.integer("mul", m, nq)))

        near, far = (c.load(c.at("%order", i)) for i in range(2))
        with c.loop(0, nv) as k, c.when(asked(k)):
            row, h = c.at("%J", c.integer("mul", k, width)), c.load(c.at("%columns", c.integer("mul", k, 4)))
            distance, first, last = c.at(along, c.integer("mul", number(k, 1), nq)), number(k, 2), number(k, 3)
            copied(ny, "%y", moved)
            with c.loop(0, width) as i:
                c.store("0.0", c.at(row, i))

            def differ(reach: float, weight: str) -> None:
                for side, part in ((reach, weight), (-reach, c.let(f"fneg double {weight}"))):
                    scaled = c.let(f"fmul double {h}, {side}")
                    with c.loop(first, last) as i:
                        step = c.let(f"fmul double {scaled}, {c.load(c.at(distance, i))}")
                        c.store(c.let(f"fadd double {c.load(c.at('%y', i))}, {step}"), c.at(moved, i))
                    evaluate()
                    with c.loop(0, nv) as i:
                        change = c.let(f"fmul double {c.load(c.at(out['dy'], nq, i))}, {part}")
                        c.store(c.let(f"fadd double {c.load(c.at(row, i))}, {change}"), c.at(row, i))
                    with c.loop(0, self.sizes["G"]) as i:
                        held = c.let(f"fcmp oge double {c.load(c.at('%G', i))}, 0.0")
                        below = c.let(f"fcmp olt double {c.load(c.at(out['G'], i))}, 0.0")
                        with c.when(c.let(f"and i1 {held}, {below}")):
                            c.store("1.0", c.at(row, nv))

            differ(1.0, near)
            with c.when(c.let(f"fcmp one double {far}, 0.0")):
                differ(2.0, far)
            with c.loop(0, nv) as i:
                c.store(c.let(f"fdiv double {c.load(c.at(row, i))}, {h}"), c.at(row, i))

        def floats(
            t: Scalar, y: Array, P: Array, G: Array, order: Array, columns: Array, work: Array, J: Array
        ) -> Outputs:
            steps, abreast, firsts, lasts = columns.reshape(nv, 4).T
            distances = []
            for n in range(self.abreast):
                v = ((abreast == n) & (steps != 0.0)).astype(float)
                distances.append(np.array(rate(t=t, y=np.concatenate([y[:nq], v, y[nq + nv :]]), P=P).dy)[:nq])
            for k in np.flatnonzero(steps):
                row, at, h = J.reshape(nv, width)[k], slice(int(firsts[k]), int(lasts[k])), steps[k]
                row[:] = 0.0
                near, far = order
                for x, weight in ((1.0, near), (-1.0, -near), (2.0, far), (-2.0, -far)):
                    if not weight:
                        continue
                    at_rest = np.array(y)
                    at_rest[at] += (h * x) * distances[int(abreast[k])][at]
                    r = rate(t=t, y=at_rest, P=P)
                    row[:nv] += np.array(r.dy)[nq : nq + nv] * weight
                    row[nv] = max(row[nv], float(((np.array(r.G) < 0.0) & (G >= 0.0)).any()))
                row[:nv] /= h
            return {}

        return Primitive("tangent", floats, inputs, {}, c.text())


def one_sided(
    at: Places, rate: Rate, sizes: Mapping[str, int], nq: int, nv: int, row: int, steps: tuple[float, float]
) -> Primitive:
    """Return the native function `one_sided`(X, P, M), which differentiates the accelerations by one-sided differences.

    The derivatives at the state z are stored in columns of M with stride `row`. Differences of `steps`, first by
    displacements, then, if X asks for more than nv columns, by velocities. X holds the state z with its accelerations
    `here`, the time `now` with a time `within` its step, the coordinate rates `way0`, `way1`, ... of unit velocities of
    several joints each, and for each displacement the number of its `way` and its range of coordinates.
    """
    ny, distances = sizes["dy"], at["way0"].start
    c = LoopEmitter("one_sided", ["X", "P", "M"])
    moved, t = c.reserve(f"[{padded(ny)} x double]"), c.reserve("[2 x double]")
    out = {name: c.reserve(f"[{max(1, n)} x double]") for name, n in sizes.items()}
    for place, name in enumerate(("now", "within")):
        c.store(c.load(c.at("%X", at[name])), c.at(t, place))
    columns = c.load(c.at("%X", at["columns"]))
    with c.loop(0, c.let(f"fptosi double {columns} to i64")) as k:
        with c.loop(0, ny, WIDEST) as i:
            c.store(c.load(c.at("%X", at["z"].start, i), VECTOR), c.at(moved, i), VECTOR)
        displaced = c.let(f"icmp slt i64 {k}, {nv}")
        with c.when(displaced):
            distance, first, last = (
                c.let(f"fptosi double {c.load(c.at('%X', at[name].start, k))} to i64")
                for name in ("way", "first", "last")
            )
            source = c.integer("mul", distance, ny)
            with c.loop(first, last) as i:
                step = c.let(f"fmul double {c.load(c.at('%X', distances, source, i))}, {steps[0]:.17e}")
                c.store(c.let(f"fadd double {c.load(c.at(moved, i))}, {step}"), c.at(moved, i))
        with c.when(c.let(f"xor i1 {displaced}, 1")):
            v = c.at(moved, nq - nv, k)
            c.store(c.let(f"fadd double {c.load(v)}, {steps[1]:.17e}"), v)
        c.call("rate", [t, moved, "%P", *out.values()])
        over = c.let(f"select i1 {displaced}, double {1.0 / steps[0]:.17e}, double {1.0 / steps[1]:.17e}")
        target = c.integer("mul", k, row)
        with c.loop(0, nv) as i:
            here = c.load(c.at("%X", at["here"].start + nq, i))
            change = c.let(f"fsub double {c.load(c.at(out['dy'], nq, i))}, {here}")
            c.store(c.let(f"fmul double {change}, {over}"), c.at("%M", target, i))
    spent = c.at("%X", at["differences"])
    c.store(c.let(f"fadd double {c.load(spent)}, {columns}"), spent)
    c.store("0.0", c.at("%X", at["columns"]))

    def floats(X: Array, P: Array, M: Array) -> Outputs:
        for j in range(int(X[at["columns"]])):
            y = np.array(X[at["z"]])
            if j < nv:
                n, start, stop = (int(X[at[name]][j]) for name in ("way", "first", "last"))
                y[start:stop] += X[distances + n * ny :][start:stop] * steps[0]
            else:
                y[nq - nv + j] += steps[1]
            dy = np.array(rate(t=[X[at["now"]], X[at["within"]]], y=y, P=P).dy)
            change = dy[nq : nq + nv] - X[at["here"]][nq : nq + nv]
            M[j * row : j * row + nv] = change * (1.0 / steps[0 if j < nv else 1])
        X[at["differences"]] += X[at["columns"]]
        X[at["columns"]] = 0.0
        return {}

    return Primitive("one_sided", floats, dict.fromkeys(("X", "P", "M"), OPAQUE), {}, c.text())


class KineticShares:
    """Kinetic energy at one pose, divided among bodies and among joint velocities."""

    def __init__(self, program: Program, P: np.ndarray, q: np.ndarray) -> None:
        self._parts = []
        self._momenta = []
        for i, (tree, _) in enumerate(program.instances):
            numbered = with_numbers(tree, P[program.parameters.at["tree", str(i)]])
            still = np.zeros(tree.v.stop - tree.v.start)
            K = kinematics(numbered, q[tree.q], still, 0.0, [0.0] * len(tree.prescribed_dofs))
            columns = list(velocity_transformation(tree, K))
            for n, V in enumerate(columns):
                b, J = numbered.bodies[n], body_inertia(numbered, K, n)
                H = np.array(V.T @ J @ V, dtype=float)
                if b.elastic is not None:
                    own = elastic(numbered, K, n)
                    H += np.array(V.T @ own.I @ V, dtype=float)
                    coupled = np.array([c @ V for c in own.C], dtype=float).reshape(b.n_modes, len(H))
                    H[b.v_modes] += coupled
                    H[:, b.v_modes] += coupled.T
                    H[b.v_modes, b.v_modes] += np.diag(np.array(own.mass, dtype=float))
                self._parts.append((b.name, tree.v, H))
                self._momenta.append((b.name, tree.v, np.array((J @ V)[3:], dtype=float)))
            for n, m, C in shared_inertia(numbered, K):
                H = np.array(columns[n].T @ C @ columns[m], dtype=float)
                self._parts += [(numbered.bodies[k].name, tree.v, 0.5 * (H + H.T)) for k in (n, m)]
        self._velocities = coordinate_names(program.graph)[1]

    def energy(self, shape: np.ndarray) -> float:
        """Return v^H H v [J] for the velocities v of a mode shape: twice the kinetic energy if they are real."""
        return float(sum((shape[at].conj() @ H @ shape[at]).real for _, at, H in self._parts))

    def momenta(self, shape: np.ndarray) -> dict[str, np.ndarray]:
        """Return the linear momentum (3,) of each rigid body, for complex velocities [kg m/s]."""
        return {name: G @ shape[at] for name, at, G in self._momenta}

    def shares(self, shape: np.ndarray) -> tuple[tuple[tuple[str, float], ...], tuple[tuple[str, float], ...]]:
        """Return each body's and each joint velocity's share of the kinetic energy, largest first."""
        bodies: dict[str, float] = {}
        joints = np.zeros(len(shape))
        for name, at, H in self._parts:
            x = shape[at]
            bodies[name] = bodies.get(name, 0.0) + float((x.conj() @ H @ x).real)
            joints[at] += np.diag(H) * np.abs(x) ** 2
        return _ranked(bodies), _ranked(dict(zip(self._velocities, map(float, joints), strict=True)))


def _ranked(parts: dict[str, float]) -> tuple[tuple[str, float], ...]:
    total = sum(parts.values()) or 1.0
    return tuple(sorted(((name, x / total) for name, x in parts.items()), key=lambda e: (-e[1], e[0])))
