"""Descriptions equal to the last bit share one compiled program; others have their own."""

from __future__ import annotations

import copy
from dataclasses import replace

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.model import Program, program_of
from random_trees import random_system


@pytest.mark.parametrize("seed", range(5))
def test_equal_descriptions_of_systems_share_one_compiled_program(seed: int) -> None:
    system = random_system(seed)
    program_of(random_system(seed + 100))
    first = program_of(system)
    assert program_of(copy.deepcopy(system)) is first
    alone = Program(copy.deepcopy(system))
    assert np.array_equal(first.parameters.initial, alone.parameters.initial)


def test_descriptions_of_systems_that_differ_in_the_sign_of_a_zero_have_separate_programs() -> None:
    system = random_system(3)
    body = system.bodies[0]
    signed = replace(system, bodies=(replace(body, com=(-0.0, *body.com[1:])), *system.bodies[1:]))
    plain = replace(system, bodies=(replace(body, com=(0.0, *body.com[1:])), *system.bodies[1:]))
    assert program_of(signed) is not program_of(plain)
    assert program_of(system, "augmented") is not program_of(system)


def test_an_invalid_description_of_a_system_is_refused_each_time_it_is_compiled() -> None:
    system = random_system(3)
    wrong = replace(system, gravity=float("nan"))
    for _ in range(2):
        with pytest.raises(KernelError, match="gravity is nan"):
            Program(wrong)
        Program(system)
