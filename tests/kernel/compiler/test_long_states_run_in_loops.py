"""Arithmetic on long states runs in loops with the bits of unrolled code, with every method."""

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from heavylift.kernel.compiler import vector_loops as wide
from heavylift.kernel.description import MethodName, Point
from heavylift.kernel.simulation import Simulation
from small_scenes import hung

LONGEST = 8  # numbers: fewer than the state of the scene
STEPS = {"semi-implicit-euler": 1e-3, "rk4": 1e-3}  # [s] of methods without an error estimate


def loads():
    """Four loads on four ropes, one after the other taut."""
    one, parts = hung(59.9), []
    (body,), (joint,), (rope,) = one.bodies, one.joints, one.ropes
    for i in range(4):
        line = replace(rope.lines[0], b=Point(f"load{i}"))
        parts.append(
            (
                replace(body, name=f"load{i}"),
                replace(joint, name=f"guide{i}", child=f"load{i}", q0=(-59.9 + 0.2 * i,)),
                replace(rope, name=f"rope{i}", lines=(line,)),
            )
        )
    bodies, joints, ropes = zip(*parts, strict=True)
    return replace(one, bodies=bodies, joints=joints, ropes=ropes)


def end(method):
    s = Simulation(loads(), 1e-6, 10_000_000, cache=False, method=method, step=STEPS.get(method))
    s.start()
    s.run(300_000_000)
    s.interrupt(300_000_000)
    return s.state.copy(), np.concatenate([r for _, r in s.rows])


@pytest.mark.parametrize("method", get_args(MethodName))
@pytest.mark.large(beyond=4)
def test_loops_over_long_vectors_and_unrolled_code_give_bit_identical_results(method, monkeypatch):
    made, loop = [], wide.Wide._loop
    monkeypatch.setattr(wide.Wide, "_loop", lambda self, *args: (made.append(args), loop(self, *args)))
    unrolled = end(method)
    before = len(made)
    monkeypatch.setattr(wide, "UNROLLED", LONGEST)
    looped = end(method)
    assert all(a.tobytes() == b.tobytes() for a, b in zip(looped, unrolled, strict=True))
    assert len(looped[0]) > LONGEST
    assert len(looped[0]) % 8
    assert len(made) > before + 10
