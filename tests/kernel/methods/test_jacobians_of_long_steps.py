"""Jacobians by one-sided differences in a native loop, for every kind of joint."""

from dataclasses import replace

import numpy as np
import pytest
from heavylift.kernel.methods import MOVED, SPED
from heavylift.kernel.simulation.native import Oracle
from random_mechanisms import mechanism
from small_scenes import started

CLOSE = 1e-4  # of the largest derivative: one-sided against central differences
ROUNDED = 1e-7  # of it: what rounding makes of differences over a micrometre


def moving(seed: int, **options):
    """A tree of random joints with springs and ropes, in motion."""
    system = mechanism(seed, 1.0)
    tree = tuple(j for j in system.joints if not j.name.startswith("loop"))
    return started(replace(system, joints=tree, rigid_ropes=()), method="radau5", opt=0, **options)


def by_native_loop(s) -> np.ndarray:
    """(2, nv, nv) derivatives of all accelerations by displacements and by velocities, a row for each of these."""
    native, at, n = s.native, s.native.at, s.program.nv
    native.X[at["z"]], native.X[at["here"]] = native.state, native.rate(native.state)[0]
    native.set(now=native["t"], within=native.among(), columns=2.0 * n)
    if isinstance(native.code, Oracle):
        native.code._functions |= {part.name: part for part in s.method.functions["step"].parts}
    native.code.call("differences", native.X, native.P, native.M)
    row = s.method.method._row
    return native.M[: 2 * n * row].reshape(2, n, row)[:, :, :n].copy()


def by_central_differences(s) -> np.ndarray:
    native, method, n = s.native, s.method.method, s.program.nv
    y, at = native.state.copy(), slice(s.program.nq, s.program.nq + s.program.nv)
    one, none, found = np.eye(n), np.zeros(n), []
    for steps in ((MOVED, 0.0), (0.0, SPED)):
        h = max(steps)
        for j in range(n):
            ends = [method._displaced(y=y, u=f * steps[0] * one[j] + none, w=f * steps[1] * one[j]).x for f in (1, -1)]
            high, low = (native.rate(np.asarray(x, float))[0][at] for x in ends)
            found.append((high - low) / (2.0 * h))
    return np.array(found).reshape(2, n, n)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.large(beyond=1)
def test_jacobians_of_implicit_methods_agree_with_central_differences(seed):
    s = moving(seed)
    mine, other = by_native_loop(s), by_central_differences(s)
    for part, true in zip(mine, other, strict=True):
        assert np.abs(part - true).max() < CLOSE * np.abs(true).max()


def test_jacobians_in_machine_code_and_interpreted_python_agree_except_for_rounding():
    native, floats = by_native_loop(moving(1)), by_native_loop(moving(1, native=False))
    assert np.abs(native - floats).max() < ROUNDED * np.abs(native).max()
