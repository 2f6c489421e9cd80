"""Laws that a user writes in Python run as machine code; what cannot be traced is refused with its line."""

import sys
import textwrap
from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import Body, Characteristic, InputSignal, Joint, Load, Point, System, UserLaw
from heavylift.kernel.simulation import Simulation
from heavylift.kernel.simulation.native import native_state
from scipy.integrate import solve_ivp
from small_scenes import SECOND, X, cube, events, imbalance, slider, started, times

CLOSES = 1e-9  # of the energy turned over; integrated at 1e-11
AS_SCIPY = 1e-8
FINE = {"tolerance": 1e-11, "sample_ns": 20_000_000, "h_max": 0.05}
HERE = "laws_of_a_user"


def cart(law, mass=2.0, **start) -> System:
    return replace(slider(mass=mass, axis=X, **start), forces=(law,), gravity=0.0)


def own(function, **options) -> UserLaw:
    return UserLaw("own", f"{HERE}:{function}", "load-guide", **options)


def end(s, t):
    s.interrupt(round(t * SECOND))
    return float(s.row().q[0]), float(s.row().v[0])


def reference(rate, y, t):
    return solve_ivp(rate, (0.0, t), y, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]


def test_a_user_law_can_model_a_van_der_pol_oscillator():
    s = started(cart(own("van_der_pol", parameters=(3.0, 2.0)), q0=0.5), **FINE)
    expected = reference(lambda t, y: [y[1], (3.0 * (1 - y[0] ** 2) * y[1] - 4.0 * y[0]) / 2.0], [0.5, 0.0], 12.0)
    assert end(s, 12.0) == pytest.approx(tuple(expected), abs=AS_SCIPY)
    assert imbalance(s) < CLOSES


def test_a_user_law_receives_the_time_and_the_value_of_its_signal():
    """Across an interrupt, after which local time starts again."""
    law = own("shaker", signal=InputSignal(times=(0.0, 2.0), values=(0.0, 6.0)))
    s = started(cart(law), **FINE)
    s.interrupt(SECOND)
    s.settle()
    expected = reference(lambda t, y: [y[1], 3.0 * t / 2.0 * np.sin(3.0 * t + 0.5)], [0.0, 0.0], 2.0)
    assert end(s, 2.0) == pytest.approx(tuple(expected), abs=AS_SCIPY)


def test_a_user_law_on_a_free_body_gives_force_and_moment():
    ball = System(
        (Body("ball", 0.4, inertia=cube(0.4, 0.3)),),
        (Joint("f", "free", "world", "ball", v0=(20.0, 0.0, 4.0, 0.0, 9.0, 40.0)),),
        forces=(UserLaw("magnus", f"{HERE}:magnus", ends=(Point("ball"),), parameters=(0.004, 1e-4)),),
    )
    s = started(ball, **FINE)
    s.interrupt(2 * SECOND)
    I = 0.4 * 0.09 / 6.0

    def rate(t, y):
        v, w = y[3:6], y[6:]
        return [*v, *(0.004 * np.cross(w, v) / 0.4 - [0, 0, 9.80665]), *(-1e-4 * w * np.linalg.norm(w) / I)]

    expected = reference(rate, [0, 0, 0, 20.0, 0, 4.0, 0.0, 9.0, 40.0], 2.0)
    assert s.row().q[:3] == pytest.approx(expected[:3], abs=1e-7)
    assert imbalance(s) < CLOSES


def test_a_user_law_between_two_points_acts_on_both_points():
    law = UserLaw("tether", f"{HERE}:tether", ends=(Point("world"), Point("load")))
    s = started(cart(law, q0=2.0), **FINE)
    assert end(s, 0.3)[0] == pytest.approx(1.0 + np.cos(sqrt(40.0 / 2.0) * 0.3), abs=AS_SCIPY)


def test_discrete_modes_of_a_user_law_switch_at_exactly_located_events():
    """A relay at 0.1 m makes parabolas: force -2 beyond it, +2 before; quarter period sqrt(2 x m / F)."""
    s = started(cart(own("relay", guards=f"{HERE}:beyond_the_middle", modes=1), q0=0.6), **FINE)
    s.run(6 * SECOND)
    quarter = sqrt(2 * 0.5 * 2.0 / 2.0)
    crossings = [quarter * (1 + 2 * i) for i in range(3)]
    assert times(s, "own", "switched")[:3] == pytest.approx(crossings, abs=2e-8)  # a nanosecond each
    assert imbalance(s) < CLOSES


def test_the_initial_mode_of_a_user_law_follows_the_sign_of_its_guard():
    s = started(cart(own("relay", guards=f"{HERE}:beyond_the_middle", modes=1), q0=-0.4))
    assert events(s) == []
    assert s.row().shown[0] == 2.0


def test_an_edited_user_law_is_compiled_anew(tmp_path, monkeypatch):
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(native_state, "MOST_LOADED", 0)
    monkeypatch.setattr(native_state, "_loaded", {})
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # Python distinguishes edits by whole seconds and sizes
    file = tmp_path / "mine.py"
    law = UserLaw("own", f"{file}:pull", "load-guide")
    found = []
    for force in (3.0, 3.0, 5.0):
        file.write_text(
            textwrap.dedent(f"""
            SIZE = {force}
            def pull(x):
                return SIZE
            """)
        )
        s = started(cart(law))
        found.append((end(s, 1.0)[1], s.native.code.cached))
    assert [(round(v, 9), cached) for v, cached in found] == [(1.5, False), (1.5, True), (2.5, False)]


BAD = [
    ("branching", "at laws_of_a_user.py:", "use select(condition, a, b)"),
    ("looping", "at laws_of_a_user.py:", "use select(condition, a, b)"),
    ("by_the_library", "at laws_of_a_user.py:", "call sin(), sqrt() and others of heavylift.kernel.forces.mathematics"),
    ("by_a_root", "at laws_of_a_user.py:", "call power() of heavylift.kernel.forces.mathematics"),
    ("by_numpy", "at laws_of_a_user.py:", "use those of heavylift.kernel.forces.mathematics"),
    ("misspelt", "at laws_of_a_user.py:", "no attribute 'position'"),
    ("too_many", "must return one number, the effort along its joint", ""),
    ("a_word", "must return one number, the effort along its joint", ""),
    ("nothing", "must return one number, the effort along its joint", ""),
    ("counting", "a condition is not a number", "use select(condition, a, b)"),
    ("answering", "a condition is not a number", "use select(condition, a, b)"),
    ("choosing", "a number is not a condition", "with > or >="),
    ("gambling", "gives different results when it is called again", "a law may depend only on its arguments"),
    ("undefined", "'laws_of_a_user:undefined' computes with nan", "give it finite numbers"),
    ("absent", "there is no function 'absent' in 'laws_of_a_user'", ""),
]


@pytest.mark.parametrize(("function", "told", "do"), BAD)
@pytest.mark.parametrize("native", [True, False])
def test_a_user_law_that_cannot_be_traced_is_refused_with_its_line_of_code(function, told, do, native):
    with pytest.raises(KernelError) as e:
        Simulation(cart(own(function)), native=native)
    sentence = str(e.value)
    assert sentence.startswith("law 'own': ")
    assert told in sentence
    assert do in sentence
    assert "\n" not in sentence


@pytest.mark.parametrize(
    ("law", "told"),
    [
        (UserLaw("own", "no_such_module:f", "load-guide"), "'no_such_module' cannot be imported: No module"),
        (UserLaw("own", "van_der_pol", "load-guide"), "write 'package.module:function'"),
        (UserLaw("own", f"{HERE}:relay"), "it must act on either of them"),
        (own("relay", guards=f"{HERE}:beyond_the_middle", modes=2), "must return a list of 2 numbers"),
        (
            UserLaw("own", f"{HERE}:relay", ends=(Point("load"),), modes=0),
            "laws_of_a_user.py:36: index 0 is out of bounds",
        ),
        (UserLaw("own", f"{HERE}:too_many", ends=(Point("load"),)), "a force of 3 numbers, or force and moment of 6"),
        (UserLaw("own", f"{HERE}:shaker", "guide"), "there is no joint 'guide'"),
    ],
)
def test_invalid_user_laws_are_refused(law, told):
    with pytest.raises(KernelError) as e:
        Simulation(cart(law))
    assert told in str(e.value)


def test_a_motor_runs_up_along_its_torque_speed_characteristic():
    """Constant torque to 10 rad/s, then falling to zero at 20: an exact line, then an exact exponential."""
    rotor = Body("rotor", 1.0, inertia=((2.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 4.0)))
    motor = Characteristic("motor", "shaft", "speed", (10.0, 20.0), (8.0, 0.0))
    system = System((rotor,), (Joint("shaft", "revolute", "world", "rotor"),), forces=(motor,))
    s = started(system, tolerance=1e-11)
    s.interrupt(12 * SECOND)
    assert times(s, "motor", "piece") == [pytest.approx(5.0, abs=2e-9)]
    assert s.row().v[0] == pytest.approx(20.0 - 10.0 * np.exp(-0.8 / 4.0 * 7.0), rel=1e-9)
    assert imbalance(s) < CLOSES


def test_a_buffer_with_a_kinked_characteristic_conserves_energy():
    """Force over travel; no step crosses a kink, so a coarse tolerance returns the speed as well."""
    curve = Characteristic("buffer", "load-guide", "position", (0.0, 0.1, 0.3), (0.0, -40.0, -50.0))
    s = started(cart(curve, mass=2.0, q0=-0.1, v0=1.7), tolerance=1e-7)
    s.run(2 * SECOND)
    s.interrupt(2 * SECOND)
    assert s.row().v[0] == pytest.approx(-1.7, abs=1e-5)
    assert len(events(s)) == 4, "in over two kinks, out over two"


@pytest.mark.parametrize(
    ("x", "effort", "told"),
    [
        ((), (), "at least one"),
        ((0.0, 1.0), (1.0,), "has 1 values at 2 places"),
        ((0.0, 0.0), (1.0, 2.0), "does not rise at 0.0"),
    ],
)
def test_invalid_force_characteristics_are_refused(x, effort, told):
    with pytest.raises(KernelError, match="characteristic 'c': ") as e:
        Simulation(cart(Characteristic("c", "load-guide", "speed", x, effort)))
    assert told in str(e.value)


def test_two_force_elements_with_the_same_name_are_refused():
    loads = (Load("f", Point("load"), X), Load("f", Point("load"), X))
    with pytest.raises(KernelError, match="'f': this name is used twice"):
        Simulation(replace(slider(), forces=loads))


def test_a_pendulum_with_a_user_law_has_the_expected_period():
    """Half a period of the small pendulum, as a check that q is the joint's own coordinate."""
    s = started(cart(own("van_der_pol", parameters=(0.0, 3.0)), mass=1.0, q0=0.2), **FINE)
    assert end(s, pi / 3.0)[0] == pytest.approx(-0.2, abs=AS_SCIPY)
