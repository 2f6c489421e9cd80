"""A run that cannot continue names the cause: contradictory drives, or masses too far apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import WORLD, Body, Drive, Joint, JointSpring, Line, Point, RigidRope, System
from heavylift.kernel.model import Program
from heavylift.kernel.simulation.safeguards import too_slow, too_small
from small_scenes import SECOND, G, X, Z, hand_over, slider, started

ACROSS = (0.0, -1.0, 0.0)


def rod(name: str, length: float, mass: float) -> Body:
    i = mass * length**2 / 12.0
    return Body(name, mass, (0.5 * length, 0.0, 0.0), ((0.0, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, i)))


def four_bar(kind: str) -> System:
    """A parallelogram with a drive at each of its cranks."""
    a = 0.9
    joints = (
        Joint("left", "revolute", WORLD, "a", axis=ACROSS, q0=(a,)),
        Joint("top", "revolute", "a", "coupler", X, axis=ACROSS, q0=(-a,)),
        Joint("right", "revolute", WORLD, "b", (2.0, 0.0, 0.0), axis=ACROSS, q0=(a,)),
        Joint("close", "revolute", "coupler", "b", (2.0, 0.0, 0.0), axis=ACROSS, p_CJ=X),
    )
    bodies = (rod("a", 1.0, 1.0), rod("coupler", 2.0, 2.0), rod("b", 1.0, 1.0))
    return System(bodies, joints, drives=(Drive("one", "left", kind), Drive("two", "right", kind)), gravity=G)


def slider_crank(mass: float) -> System:
    a = 0.9
    b = float(np.arcsin(np.sin(a) / 3.0))
    joints = (
        Joint("crank", "revolute", WORLD, "arm", axis=ACROSS, q0=(a,), v0=(4.0,)),
        Joint("pin", "revolute", "arm", "rod", X, axis=ACROSS, q0=(-a - b,)),
        Joint("guide", "prismatic", WORLD, "piston", axis=X, q0=(np.cos(a) + 3.0 * np.cos(b),)),
        Joint("wrist", "revolute", "rod", "piston", (3.0, 0.0, 0.0), axis=ACROSS),
    )
    return System((rod("arm", 1.0, 1.0), rod("rod", 3.0, mass), Body("piston", 1.0)), joints, gravity=G)


def sentence(s, t: int) -> str:
    with pytest.raises(KernelError) as e:
        hand_over(s, t)
    return str(e.value)


@pytest.mark.parametrize(("one", "two"), [(1.0, -1.0), (0.5, 1.0), (-0.3, -0.1)])
def test_drives_that_prescribe_incompatible_motions_in_a_closed_loop_are_reported_by_name(
    one: float, two: float
) -> None:
    s = started(four_bar("prescribed"))
    s.set_profile("one", 0, one, 1.0, None)
    s.set_profile("two", 0, two, 1.0, None)
    s.settle()
    message = sentence(s, 2 * SECOND)
    assert "drives 'one' and 'two' move the same loop and contradict each other; stop one" in message


def test_drives_that_prescribe_compatible_motions_in_a_closed_loop_are_accepted() -> None:
    s = started(four_bar("servo"))
    s.set_profile("one", 0, 0.3, 1.0, 0.1)
    s.set_profile("two", 0, 0.3, 1.0, 0.1)
    s.settle()
    hand_over(s, SECOND)


@pytest.mark.parametrize("mass", [1e-12, 1e-14])
def test_a_run_stops_with_an_error_that_names_the_body_too_light_for_its_closed_loop(mass: float) -> None:
    """Its rows drown in the rounding of those of the heavy ones."""
    with pytest.raises(KernelError) as e:
        hand_over(started(slider_crank(mass)), SECOND)
    message = str(e.value)
    assert f"body 'rod' with {mass:.3g} kg is tied into a loop with 'piston' of 1 kg, too far apart" in message


def test_the_motion_of_a_loop_with_a_very_light_body_does_not_depend_on_the_mass_of_that_body() -> None:
    ends = []
    for mass in (1e-6, 1e-9):
        s = started(slider_crank(mass), tolerance=1e-9)
        hand_over(s, SECOND // 10)
        ends.append(s.state[0])
    assert ends[0] == pytest.approx(ends[1], abs=1e-6)


@pytest.mark.parametrize("slack", [0.0, 0.3])
def test_a_run_stops_with_an_error_that_names_the_drive_that_pulls_a_rigid_rope_apart(slack: float) -> None:
    rope = RigidRope("rope", (Line(Point(WORLD), Point("load")),), 10.0 + slack)
    scene = replace(slider("load", 1.0, axis=Z, q0=-10.0), rigid_ropes=(rope,))
    scene = replace(
        scene,
        bodies=(*scene.bodies, Body("weight", 1.0)),
        joints=(*scene.joints, Joint("rail", "prismatic", "load", "weight", axis=X)),
        drives=(Drive("hoist", "load-guide", "prescribed"),),
    )
    s = started(scene)
    s.set_profile("hoist", 0, -1.0, 1.0, None)
    s.settle()
    message = sentence(s, 2 * SECOND)
    assert message.startswith("rope 'rope' at ")
    assert message.endswith(
        "drive 'hoist' moves all that it could move, and a rigid rope does not stretch; stop the drive before, make it "
        "a servo, or give 'rope' EA"
    )


@pytest.mark.parametrize("method", ["dopri5", "dop853", "radau5"])
def test_an_error_about_a_too_small_step_size_suggests_radau5_unless_the_run_already_uses_radau5(method: str) -> None:
    """A spring that swings faster than any step, and the sentences of both ways to fail."""
    scene = replace(slider("cart", 1.0, axis=X), springs=(JointSpring("spring", "cart-guide", 1e30),))
    program = Program(scene)
    for error in (
        too_small(program, 1.0, np.ones(1), "'cart' swings at 1 Hz", method),
        too_slow(method, 1.0, 1e-9, "'cart' swings at 1 Hz"),
    ):
        assert ("choose method radau5" in str(error)) == (method != "radau5")
        assert ("choose a larger tolerance" in str(error)) == (method == "radau5")
