"""Each user error ends in one sentence that names its cause."""

from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest
from bad_commands import COMMANDS, driven
from bad_descriptions import DESCRIPTIONS, GUIDE, ONE, diagonal, with_
from heavylift.kernel import KernelError
from heavylift.kernel.description import (  # fmt: skip
    Ball,
    Body,
    Brake,
    Contact,
    Drive,
    Joint,
    JointSpring,
    Plane,
    System,
)
from heavylift.kernel.model import Program, Switches
from heavylift.kernel.simulation import Simulation
from small_scenes import SECOND, X, Z, hand_over, hung, slider, started


@pytest.mark.parametrize(("system", "sentence"), DESCRIPTIONS, ids=[s[:60] for _, s in DESCRIPTIONS])
def test_invalid_descriptions_of_systems_are_refused(system, sentence):
    with pytest.raises(KernelError) as e:
        Program(system)
    assert str(e.value) == sentence


@pytest.mark.parametrize(
    ("system", "options", "sentence"),
    [
        (
            System((Body("a", 1.0),), (Joint("weld", "fixed", "world", "a"),)),
            {},
            "nothing in this scene can move: all joints are fixed; free a joint",
        ),
        (
            with_(bodies=(Body("a", 0.0),)),
            {},
            "body 'a': it can move without inertia; give it, or the bodies that it carries, mass or inertia",
        ),
        (
            with_(bodies=(Body("a", 1.0, (0.0, 0.6, 0.8)),), joints=(Joint("ball", "spherical", "world", "a"),)),
            {},
            "body 'a': it can move without inertia in joint 'ball'; give it, "
            "or the bodies that it carries, mass or inertia",
        ),
        (
            System(
                (Body("a", 1.0, inertia=diagonal(1.0, 1.0, 1.0)), Body("b", 2.0, (0.0, 0.3, 0.4))),
                (Joint("j", "spherical", "world", "a"), Joint("k", "revolute", "a", "b", X, axis=(0.0, 0.6, 0.8))),
            ),
            {},
            "body 'b': it can move without inertia in joint 'k'; give it, or "
            "the bodies that it carries, mass or inertia",
        ),
        (ONE, {"tolerance": 0.0}, "tolerance 0: it must lie between 1e-14 and 1"),
        (ONE, {"tolerance": nan}, "tolerance nan: it must lie between 1e-14 and 1"),
        (ONE, {"sample_ns": 0}, "samples every 0 ns: they must be at least 100000 ns apart"),
        (
            ONE,
            {"method": "euler"},
            "method 'euler': there is no method with this name; choose one of "
            "semi-implicit-euler, rk4, dopri5, dop853, "
            "radau5",
        ),
        (ONE, {"method": "rk4"}, "method 'rk4': it has no error estimate and needs a fixed step, such as 0.001 s"),
        (ONE, {"tolerance": 1e-30}, "tolerance 1e-30: it must lie between 1e-14 and 1"),
        (ONE, {"tolerance": "a"}, "tolerance is 'a'; it must be a number"),
        (ONE, {"h_max": nan}, "h_max nan s: the longest step must be positive and finite"),
        (ONE, {"h_max": 0.0}, "h_max 0 s: the longest step must be positive and finite"),
        (ONE, {"h_max": -1.0}, "h_max -1 s: the longest step must be positive and finite"),
        (ONE, {"h_max": 1e9}, "a step of 1e+09 s has more than 1000000 samples; make the step shorter"),
        (ONE, {"opt": 9}, "opt 9: choose an optimisation level of the compiler, 0, 1, 2 or 3"),
        (ONE, {"step": 0.0}, "step 0 s: a fixed step must be at least 1e-09 s and finite"),
        (ONE, {"step": nan}, "step nan s: a fixed step must be at least 1e-09 s and finite"),
    ],
)
def test_a_system_that_cannot_be_simulated_is_refused_with_a_one_sentence_error(system, options, sentence):
    with pytest.raises(KernelError) as e:
        Simulation(system, cache=False, **options)
    assert str(e.value) == sentence


@pytest.fixture(scope="module")
def simulation():
    return started(driven())


@pytest.mark.parametrize(("command", "sentence"), COMMANDS, ids=[s[:60] for _, s in COMMANDS])
def test_impossible_commands_to_a_kernel_simulation_are_refused(simulation, command, sentence):
    before = simulation.P.tobytes()
    with pytest.raises(KernelError) as e:
        command(simulation)
    assert str(e.value) == sentence
    simulation.references.write(simulation.epoch)
    assert simulation.P.tobytes() == before, "a refused command changes nothing"


@pytest.mark.parametrize(
    "command",
    [
        lambda s: s.run(SECOND),
        lambda s: s.interrupt(SECOND // 10),
        lambda s: s.fire(),
        lambda s: s.preview(),
        lambda s: s.settle(),
        lambda s: s.set_follow("rope", "theta", (1.0, 0.0, 0.0)),
        lambda s: s.set_brake("brake", True),
        lambda s: s.set_lock("lock", True),
        lambda s: s.unhook("rope"),
        lambda s: s.hook("rope"),
    ],
)
def test_no_command_is_accepted_before_a_simulation_is_started(command):
    with pytest.raises(KernelError) as e:
        command(Simulation(driven()))
    assert str(e.value) == "the simulation has no state yet; start it first"


def test_a_rope_can_be_hooked_at_points_given_as_arrays():
    s = started(driven())
    s.unhook("sling")
    s.hook("sling", a=np.array([1.0, 0.0, 0.0]))
    assert s.switches.rope_numbers("sling")[4:7] == pytest.approx([1.0, 0.0, 0.0])


def test_commands_to_unknown_ropes_thresholds_and_brakes_are_refused():
    switches = Switches(Program(ONE), Program(ONE).parameters.initial)
    for what, call in (
        ("rope", switches.rope_numbers),
        ("threshold", switches.unwatch),
        ("brake", lambda name: switches.set_brake(name, True, None)),
    ):
        with pytest.raises(KernelError, match=f"'x': there is no {what} with this name; there are none"):
            call("x")


def test_a_winch_that_winds_up_more_rope_than_there_is_ends_the_run():
    s = started(hung(60.1, winch=True))
    s.references.set_profile("rope", 0, -9.0, 10.0, None)
    s.settle()
    with pytest.raises(KernelError) as e:
        s.run(60 * SECOND)
    assert str(e.value) == "rope 'rope' at 7.117 s: it is completely wound up; stop its winch earlier"


def test_motion_that_becomes_infinite_is_reported_with_its_body():
    scene = System(
        (Body("a", 1.0), Body("b", 1e-300)),
        (Joint("j", "prismatic", "world", "a", axis=X), Joint("k", "prismatic", "a", "b", axis=Z)),
        springs=(JointSpring("s", "k", 1e99, q_rest=1e99),),
    )
    s = started(scene)
    with pytest.raises(KernelError) as e:
        hand_over(s, SECOND)
    assert str(e.value).startswith("body '")
    assert "\n" not in str(e.value)


def test_a_discontinuous_force_law_is_named_with_its_body():
    """A brake as stiff as numbers allow: the step shrinks below a picosecond and the run ends."""
    brake = Brake("brake", "a-guide", 1e30, 1e36, 0.0, True)
    s = started(replace(slider("a", 1.0, v0=1.0), brakes=(brake,)))
    with pytest.raises(KernelError) as e:
        s.run(SECOND)
    assert str(e.value) == (
        "body 'a' at 0.000000 s: the step became too small (below 1e-12 s); 'a' on 'brake' swings at "
        "1.59e+17 Hz, or a law near it jumps; soften it, or choose method radau5"
    )


def test_a_drive_that_pushes_a_body_into_the_ground_is_reported_with_the_contact():
    ground = Contact("ground", Ball("a", radius=0.1), Plane(p=(0.0, 0.0, -0.2)))
    s = started(replace(slider("a", 1.0), drives=(Drive("press", "a-guide", "prescribed"),), contacts=(ground,)))
    s.references.set_profile("press", 0, -0.5, 0.5, None)
    s.settle()
    with pytest.raises(KernelError) as e:
        s.run(2 * SECOND)
    assert str(e.value) == (
        "contact 'ground' at 0.632456 s: drives or locks hold everything that it could move; stop the drive earlier, "
        "make it a servo, or free a joint"
    )


def test_a_guard_that_fires_again_and_again_at_one_instant_ends_the_run_with_its_name():
    """A guard that falls again at the same instant, whatever its law does, for ever."""
    s = started(hung(59.0))

    def chatter():
        for _ in range(300):
            s.events.fallen, s.events.t_ns = [0], s.epoch
            s.fire()

    with pytest.raises(KernelError) as e:
        chatter()
    assert str(e.value) == "rope at 0.000000000 s: states switch without end; soften or damp the law"


@pytest.mark.parametrize("value", [nan, inf, -inf])
@pytest.mark.parametrize("place", ["q0", "v0"])
def test_start_positions_and_speeds_that_are_not_finite_are_refused(value, place):
    with pytest.raises(KernelError, match=f"joint 'a-guide': {place} is {value}; it must be a finite number"):
        Simulation(with_(joints=(replace(GUIDE, **{place: (value,)}),)))


def test_a_rope_whose_ends_coincide_is_refused_for_lack_of_direction():
    s = started(hung(0.0))
    with pytest.raises(KernelError) as e:
        s.run(SECOND)
    assert str(e.value) == "rope 'rope' at 0.000 s: its ends meet, so that it has no direction; keep them apart"
