"""Impossible reevings are refused before the run, or when a load runs into its sheave."""

from dataclasses import replace

import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import Body, InputSignal, Joint, Line, Point, Reeving, Rope, Sheave, System
from heavylift.kernel.simulation import Simulation
from small_scenes import SECOND, Y, Z, cube, slider, started

WORLD, LOAD = Point("world"), Point("load")


BAD = [
    ({"EA": 0.0}, "reeving 'r': EA is 0; it must be positive"),
    ({"signal": InputSignal(0.0)}, "reeving 'r': length is 0; it must be positive"),
    ({"sheaves": ()}, "sheaves are missing"),
    ({"sheaves": (Sheave(WORLD, (0.0, 2.0, 0.0)),)}, "sheave 1 has an axis of length 2"),
    ({"sheaves": (Sheave(WORLD, efficiency=0.0),)}, "sheave 1 has an efficiency outside (0, 1]"),
    ({"sheaves": (Sheave(WORLD, Y, -0.1),)}, "has a negative radius or friction"),
    ({"sheaves": (Sheave(WORLD, (0.0, -1.0, 0.0), 0.3),)}, "degrees; turn its axis round"),
    ({"sheaves": (Sheave(WORLD, Y, 20.0),)}, "part 1 has no length; keep its ends apart"),
    ({"sheaves": (Sheave(Point("world", (-5.0, 0.0, 0.0))),)}, "part 1 has no length; keep its ends apart"),
    ({"sheaves": (Sheave(WORLD, Y, 0.3), Sheave(Point("world", (2.0, 0.0, 0.0)), Z, 0.3))}, "axes are not parallel"),
    ({"sheaves": (Sheave(Point("hook")),)}, "there is no body 'hook'"),
]


@pytest.mark.parametrize(("changes", "told"), BAD)
def test_impossible_reevings_of_ropes_are_refused(changes, told):
    made = {"a": Point("world", (-5.0, 0.0, 0.0)), "sheaves": (Sheave(WORLD, Y, 0.3),), "b": LOAD, "EA": 1e6}
    made |= {"signal": InputSignal(10.0), **changes}
    with pytest.raises(KernelError) as e:
        Simulation(replace(slider(q0=-5.0, axis=Z), forces=(Reeving("r", **made),)))
    assert told in str(e.value)


def test_a_rope_line_that_begins_and_ends_at_one_point_is_refused():
    rope = Rope("r", (Line(WORLD, LOAD), Line(LOAD, Point("load"))), 1e6, 10.0)
    with pytest.raises(KernelError, match="rope 'r': line 2 begins and ends at the same point, so its length is zero"):
        Simulation(replace(slider(), ropes=(rope,)))


def flung(axis) -> System:
    """A load that a long rope over a sheave at the origin throws up against it."""
    load = Joint("float", "free", "world", "load", q0=(1.0, 0.1, -3.0, 0.0, 0.0, 0.0, 1.0))
    rope = Reeving("rope", Point("world", (-1.0, 0.0, -3.0)), (Sheave(WORLD, axis, 0.3),), LOAD, 1e4, InputSignal(6.3))
    return System((Body("load", 10.0, inertia=cube(10.0)),), (load,), forces=(rope,))


def test_a_rope_along_the_axis_of_its_sheave_is_refused():
    with pytest.raises(KernelError) as e:
        Simulation(flung(Z))
    assert str(e.value) == "reeving 'rope': part 1 runs along the axis of its sheave; turn the axis across the rope"


def test_a_load_that_runs_into_its_sheave_ends_the_run_with_the_name_of_the_rope():
    s = started(flung(Y))
    with pytest.raises(KernelError) as e:
        s.run(SECOND)
    assert str(e.value) == "reeving 'rope' at 0.387 s: part 2 comes within its sheave; keep its ends apart"
