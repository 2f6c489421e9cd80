"""A description that equals the last one to the bit shares its graph and trees; whatever differs is its own."""

from __future__ import annotations

import copy
from dataclasses import replace

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.model import Program
from random_trees import random_system


@pytest.mark.parametrize("seed", range(5))
def test_equal_islands_share_code_and_have_their_own_numbers(seed: int) -> None:
    system = random_system(seed)
    alone = Program(system)
    Program(random_system(seed + 100))
    first, again = Program(system), Program(copy.deepcopy(system))
    assert again.graph is first.graph
    assert again.trees is first.trees
    assert alone.graph is not first.graph
    assert np.array_equal(again.parameters.initial, alone.parameters.initial)


def test_the_sign_of_a_zero_and_other_locks_make_a_difference() -> None:
    system = random_system(3)
    first = Program(system)
    body = system.bodies[0]
    signed = replace(system, bodies=(replace(body, com=(-0.0, *body.com[1:])), *system.bodies[1:]))
    plain = replace(system, bodies=(replace(body, com=(0.0, *body.com[1:])), *system.bodies[1:]))
    assert Program(signed).graph is not Program(plain).graph
    assert Program(system).graph is not first.graph, "others came in between"
    assert Program(system, "augmented").trees is not Program(system).trees


def test_an_invalid_description_is_refused_again() -> None:
    system = random_system(3)
    wrong = replace(system, gravity=float("nan"))
    for _ in range(2):
        with pytest.raises(KernelError, match="gravity is nan"):
            Program(wrong)
        Program(system)
