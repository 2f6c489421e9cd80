"""Random joints, loops, ropes and inertias give a finite run with a closed energy balance, or one error sentence."""

import numpy as np
import pytest
from heavylift.kernel.description import WORLD, Body, Joint, Line, Point, RigidRope, System
from hypothesis import HealthCheck, Phase, given, settings, strategies as st
from random_mechanisms import CLOSES, LOOPS, has_loops, mechanism, outcome
from small_scenes import SECOND, G, hand_over, imbalance, started

SOME = settings(
    max_examples=5,
    deadline=None,
    derandomize=True,
    suppress_health_check=list(HealthCheck),
    phases=(Phase.generate,),  # a smaller seed is no simpler mechanism
)
SEEDS = given(st.integers(0, 2**31))


@SOME
@SEEDS
def test_random_mechanisms_with_loops_and_masses_over_two_decades_run(seed):
    sentence, error = outcome(mechanism(seed, 2.0), SECOND // 20)
    assert "\n" not in sentence
    assert not sentence.startswith(":"), "it names what is wrong"
    assert error < CLOSES


@SOME
@SEEDS
@pytest.mark.large
def test_random_mechanisms_with_loops_and_masses_over_twelve_decades_run_or_end_in_an_error(seed):
    system = mechanism(seed, 12.0)
    sentence, error = outcome(system, SECOND // 200)
    assert "\n" not in sentence
    assert not sentence.startswith(":")
    assert error < CLOSES or has_loops(system), "rows of loops share rounding that is relative to the heaviest body"


def test_the_random_mechanisms_contain_every_type_of_loop():
    drawn = [j.kind for seed in range(60) for j in mechanism(seed, 2.0).joints if j.name.startswith("loop")]
    assert set(drawn) == set(LOOPS)


def test_a_rigid_rope_between_points_that_cannot_move_is_no_constraint():
    """One body is welded to the ground, another hangs by a hinge at the very point that the rope holds."""
    bodies = (Body("post", 10.0), Body("arm", 5.0, (0.0, 0.0, -1.0)))
    joints = (
        Joint("weld", "fixed", WORLD, "post", (3.0, 0.0, 0.0)),
        Joint("hinge", "revolute", WORLD, "arm", axis=(0.0, 1.0, 0.0), q0=(0.5,)),
    )
    ropes = tuple(
        RigidRope(n, (Line(Point(WORLD, (x, 0.0, 2.0)), Point(n)),), 2.0) for n, x in (("post", 3.0), ("arm", 0.0))
    )
    s = started(System(bodies, joints, rigid_ropes=ropes, gravity=G), tolerance=1e-9, sample_ns=SECOND // 50)
    hand_over(s, SECOND)
    s.settle()
    assert np.abs(s.row().pull).max() == 0.0
    assert imbalance(s) < CLOSES


@pytest.mark.large
def test_a_rope_catches_a_heavy_body_while_a_light_body_closes_a_loop():
    """8e11 kg on the rope, 1e4 kg in the loop: the impulse of each is found in its own size."""
    s = started(mechanism(105, 12.0), tolerance=1e-9, sample_ns=SECOND // 100)
    hand_over(s, SECOND // 25)
    s.settle()
    assert [(e.name, e.what) for _, e in s.log] == [("rigid-b3", "taut")]
    assert imbalance(s) < 1e-5
