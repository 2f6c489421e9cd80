"""Equal branches of a tree share one compiled function and move as in the whole tree."""

import numpy as np
import pytest
from heavylift.kernel.algebra import axis_rotation
from heavylift.kernel.description import Body, Joint, Line, Point, Rope, System
from heavylift.kernel.model import Program
from heavylift.kernel.simulation import Simulation
from random_trees import random_state

SAME = 1e-10  # two orders of elimination, of masses within a decade


def spider(legs: int, odd: float = 0.0) -> System:
    """A free body with legs of a spherical and two hinged links, side by side on it; the third leg may differ."""
    bodies = [Body("trunk", 900.0, (0.1, 0.2, 0.3), ((300.0, 5.0, 1.0), (5.0, 400.0, 2.0), (1.0, 2.0, 350.0)))]
    joints = [Joint("float", "free", "world", "trunk")]
    ropes = []
    for i in range(legs):
        place = (2.2 * i - 3.1, 0.3 + 0.5 * i, 0.2)
        R = tuple(map(tuple, axis_rotation(np.array([0.0, 0.6, 0.8]), 0.3 + odd * (i == 2)).tolist()))
        box = ((8.0 + i, 0.5, 0.1), (0.5, 9.0, 0.2), (0.1, 0.2, 7.0))
        parts = [("hip", "spherical", "trunk"), ("knee", "revolute", f"hip{i}"), ("hook", "revolute", f"hip{i}")]
        for j, (name, kind, on) in enumerate(parts):
            if not (odd and i == 2 and name == "hook"):
                bodies.append(Body(f"{name}{i}", 20.0 + i + j, (0.1, 0.3, -0.6), box))
                joints.append(Joint(f"j-{name}{i}", kind, on, f"{name}{i}", place, R, (0.0, 0.6, 0.8)))
        ropes.append(
            Rope(f"rope{i}", (Line(Point("world", (i, 0.0, 9.0)), Point(f"knee{i}", (0.2, 0.1, -1.0))),), 1e4, 5.0)
        )
    return System(tuple(bodies), tuple(joints), ropes=tuple(ropes))


def accelerations(system, formulation, native):
    s = Simulation(system, native=native, formulation=formulation)
    q, v = random_state(s.program.graph, 3)
    s.state[: s.program.nq + s.program.nv] = [*q, *v]
    s.start()
    return s.X[s.method.layout.at["f"]].copy()


@pytest.mark.parametrize("native", [False, True])
@pytest.mark.parametrize(("legs", "odd"), [(2, 0.0), (3, 0.0), (5, 0.1)])
@pytest.mark.large(beyond=2)
def test_equal_limbs_of_a_tree_that_share_code_have_the_accelerations_of_another_formulation(legs, odd, native):
    got, want = (accelerations(spider(legs, odd), f, native) for f in ("recursive", "articulated"))
    assert np.abs(got - want).max() < SAME * np.abs(want).max()


def code(legs, odd=0.0):
    s = Simulation(spider(legs, odd))
    return {n.name: n for n in functions(s.method.f_rate)}


def functions(f):
    called = {n.args[0]: None for n in f.nodes if n.op == "call"}
    return [f, *(g for c in called for g in functions(c))]


def test_further_equal_limbs_of_a_tree_of_bodies_add_no_code():
    assert "limb0.0.bend" not in code(2)
    three, five = code(3), code(5)
    assert len(three["limb0.0.bend"].nodes) == len(five["limb0.0.bend"].nodes)
    assert "limb0.1.bend" not in code(5, 0.1), "the odd one is part of the trunk"
    assert "limb0.0.bend" in code(5, 0.1)


def test_bodies_of_a_mechanism_that_could_move_without_inertia_are_reported_by_name():
    from heavylift.kernel import KernelError

    system = spider(3)
    bodies = tuple(Body(b.name, 0.0) if b.name.startswith("hook") else b for b in system.bodies)
    with pytest.raises(KernelError, match="hook"):
        Simulation(System(bodies, system.joints, ropes=system.ropes))
    assert Program(spider(3)).nv == 6 + 3 * 5
