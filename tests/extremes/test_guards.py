"""Guards of a run: each reports its fault in one sentence with time, law and amount, and no false alarms."""

import re
from dataclasses import replace
from math import pi, sqrt

import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import Body, Joint, JointSpring, Line, Lock, Point, Rope, Stop, System
from heavylift.kernel.simulation import Simulation
from heavylift.kernel.simulation.safeguards import CROWD, StepBudget, fastest
from small_scenes import EA, LENGTH, MASS, SECOND, G, X, Z, column, hand_over, hung, slider, started, times

STEP = {"method": "rk4", "step": 0.5}  # [s] far too long for the rope's 1.3 Hz
TOO_LONG = r"too long for method 'rk4', since 'load' on 'rope' swings at 1\.32 Hz; choose at most 0\.\d+ s"


# ---- largest frequency, at every change of topology ---------------------------------------------------------


def test_the_stability_of_a_fixed_step_is_checked_before_the_run():
    with pytest.raises(KernelError, match=r"step 0\.5 s at 0\.000 s is " + TOO_LONG):
        started(hung(LENGTH + 0.1), **STEP)


def test_the_stability_of_a_fixed_step_is_checked_when_a_rope_becomes_taut():
    s = started(hung(LENGTH - 0.1), **STEP)
    with pytest.raises(KernelError, match=r"step 0\.5 s at 0\.143 s is " + TOO_LONG):
        hand_over(s, SECOND)


def test_the_stability_of_a_fixed_step_is_checked_when_a_rope_is_hooked():
    s = started(hung(LENGTH, hooked=False), **STEP)
    hand_over(s, SECOND)
    s.hook("rope", L0=-float(s.state[0]))
    s.settle()
    with pytest.raises(KernelError, match=r"step 0\.5 s at 1\.000 s is " + TOO_LONG.replace("1\\.32", r"1\.27")):
        hand_over(s, 2 * SECOND)


def test_the_stability_of_a_fixed_step_is_checked_when_another_rope_is_unhooked():
    """The upper rope lets the load into the second one, which is shorter than its way down."""
    scene = hung(LENGTH + 0.05)
    soft = replace(scene.ropes[0], name="soft", EA=0.002 * EA, L0=LENGTH - 1.0, damping=0.0)
    s = started(replace(scene, ropes=(soft, replace(scene.ropes[0], L0=LENGTH + 0.2))), **STEP)
    s.unhook("soft")
    s.settle()
    with pytest.raises(KernelError, match=TOO_LONG):
        hand_over(s, SECOND)


def test_the_stability_of_a_fixed_time_step_is_checked_when_a_contact_closes():
    stop = Stop("ground", "load-guide", -1.0, 100.0, EA / LENGTH, 0.0)
    s = started(replace(slider(), stops=(stop,)), **STEP)
    with pytest.raises(KernelError, match=r"since 'load' on 'ground' swings at 1\.32 Hz"):
        hand_over(s, SECOND)


@pytest.mark.parametrize("first", [True, False])
def test_the_stability_of_a_fixed_step_is_checked_when_a_joint_is_locked_or_freed(first):
    """A light body on a stiff spring: locked it has no mode; freed it has, and the step is too long."""
    light = Joint("light-guide", "prismatic", "load", "light", axis=X)
    scene = slider(axis=X)
    scene = replace(
        scene, bodies=(*scene.bodies, Body("light", 1.0)), joints=(*scene.joints, light),
        springs=(JointSpring("spring", "light-guide", 1e4),), locks=(Lock("lock", "light-guide", first),),
    )  # fmt: skip
    if not first:
        with pytest.raises(KernelError, match=r"'light' on 'spring' swings at 15\.9 Hz"):
            started(scene, **STEP)
        return
    s = started(scene, **STEP)
    hand_over(s, SECOND)
    s.set_lock("lock", False)
    with pytest.raises(KernelError, match=r"step 0\.5 s at 1\.000 s is .*'light' on 'spring' swings at 15.9 Hz"):
        s.settle()


def test_the_stability_of_a_fixed_step_is_checked_when_a_winch_has_shortened_the_rope():
    """No event tells of it: 60 m of rope become 33 m, and nearly twice as stiff against the step."""
    s = started(hung(LENGTH * (1 + MASS * G / EA), winch=True), method="rk4", step=0.1, sample_ns=SECOND // 10)
    s.references.set_profile("rope", 0, -1.0, 0.1, None)
    s.settle()
    with pytest.raises(KernelError, match=r"at 2\d\.\d+ s: .* does not follow 100 % .* 'rope' swings at 1\.\d+ Hz"):
        hand_over(s, 70 * SECOND)


def test_an_oscillation_that_a_stable_time_step_distorts_is_reported_as_a_note():
    at_rest = hung(LENGTH * (1.0 + MASS * G / EA))
    s = started(at_rest, method="radau5", step=0.5)
    assert [note.sentence for note in s.notes] == [
        "step 0.5 s at 0.000 s: method 'radau5' is out of step by a tenth of a swing after 2 swings with oscillations "
        "from 1.32 Hz upwards, 'load' on 'rope' swings at 1.32 Hz: do not trust what depends on those; choose a "
        "shorter step to see them"
    ]
    assert started(at_rest, method="radau5", step=0.05).notes == []
    assert started(at_rest).notes == []


@pytest.mark.parametrize(("method", "step"), [("radau5", 0.5), ("rk4", 0.25)])
def test_a_fixed_step_too_long_for_an_excited_mode_is_refused(method, step):
    """The same load let go 10 cm too high: all that moves would be wrong within two swings."""
    with pytest.raises(KernelError) as e:
        started(hung(LENGTH + 0.1), method=method, step=step)
    assert re.fullmatch(
        rf"step {step} s at 0\.000 s: method '{method}' does not follow 100 % of the energy of the motion, 'load' on "
        r"'rope' swings at 1\.3\d Hz; choose at most 0\.\d+ s, or give no step",
        str(e.value),
    )
    advised = float(str(e.value).split("at most ")[1].split(" s")[0])
    started(hung(LENGTH + 0.1), method=method, step=advised)


def test_a_small_oscillation_too_fast_for_a_fixed_step_is_only_reported_as_a_note():
    """The hook between rope and sling trembles; what is asked of the load does not suffer."""
    line = [(Line(Point("world"), Point("hook")),), (Line(Point("hook"), Point("load")),)]
    rest = LENGTH + (MASS + 450.0) * G * LENGTH / EA
    low = rest + 0.005, rest + 0.1 * LENGTH + MASS * G * LENGTH / EA + 0.01
    scene = System(
        (Body("hook", 450.0), Body("load", MASS)),
        tuple(Joint(n, "prismatic", "world", n, axis=Z, q0=(-z,)) for n, z in zip(("hook", "load"), low, strict=True)),
        ropes=(Rope("rope", line[0], EA, LENGTH), Rope("sling", line[1], EA / 10.0, LENGTH / 10.0)),
        gravity=G,
    )
    s = started(scene, method="radau5", step=0.05)
    assert "do not trust what depends on those" in s.notes[0].sentence
    hand_over(s, SECOND)


def test_a_run_that_needs_too_many_steps_for_one_simulated_second_ends_with_an_error():
    """A gram on a stiff spring, by an explicit method to a tight tolerance."""
    scene = replace(slider(mass=1e-3, axis=X, q0=1e-3), springs=(JointSpring("spring", "load-guide", 3e7),))
    with pytest.raises(KernelError) as e:
        hand_over(started(scene, method="dopri5", tolerance=1e-12), SECOND)
    assert "a million steps of method 'dopri5' were not enough for one second" in str(e.value)
    assert "'load' on 'spring' swings at 2.76e+04 Hz; soften that law, or choose method radau5" in str(e.value)


def test_endless_events_at_one_instant_end_the_run_with_an_error():
    patience = StepBudget(50_000)
    assert not any(patience.crowded(t) for t in range(0, CROWD * 50_000, 50_000))
    assert not patience.crowded(CROWD * 50_000 + 60_000), "a pause, and the count begins anew"
    assert [patience.crowded(CROWD * 50_000 + 60_001 + t) for t in range(CROWD + 1)][-1]


# ---- energy --------------------------------------------------------------------------------------------------


def bit_by_bit(s: Simulation, start: int, end: int) -> None:
    """As grants let a kernel run."""
    for t in range(20 * start, 20 * end):
        s.run(t * SECOND // 20)


def test_a_gain_of_energy_by_integration_errors_ends_a_run_with_any_integration_method():
    """A spring that becomes stiffer behind the back of the balance: most of what moves has come out of nothing."""
    guide = Joint("guide", "prismatic", "world", "load", axis=X, q0=(1.0,))
    scene = System((Body("load", 1e3),), (guide,), springs=(JointSpring("spring", "guide", 1e5),), gravity=0.0)
    for method in ("dopri5", "dop853", "radau5"):
        s = started(scene, method=method, sample_ns=SECOND // 20)
        hand_over(s, 4 * SECOND)
        s.settle()
        s.P[s.program.parameters.at["spring", "spring"].start] *= 40.0
        s.native.call("refresh")
        with pytest.raises(KernelError, match=rf"method '{method}' at \d\.\d+ s: the energy balance is broken, .* J"):
            bit_by_bit(s, 4, 9)


def test_a_loss_of_energy_by_integration_errors_ends_a_run_with_error_control():
    guide = Joint("guide", "prismatic", "world", "load", axis=X, q0=(1.0,))
    scene = System((Body("load", 1e3),), (guide,), springs=(JointSpring("spring", "guide", 1e5),), gravity=0.0)
    s = started(scene, sample_ns=SECOND // 20)
    s.run(4 * SECOND)
    s.P[s.program.parameters.at["spring", "spring"].start] *= 0.5
    with pytest.raises(
        KernelError, match=r"J were lost without heat, more than 5 % of the largest energy exchanged so far"
    ):
        bit_by_bit(s, 4, 9)


def test_numerical_damping_of_an_oscillation_by_an_implicit_method_is_reported():
    guide = Joint("guide", "prismatic", "world", "load", axis=X, q0=(0.0,))
    scene = System((Body("load", 1e3),), (guide,), springs=(JointSpring("spring", "guide", 1e5),), gravity=0.0)
    s = started(scene, method="radau5", step=1.0, sample_ns=SECOND)
    s.state[0] = 1.0  # behind the back of the guard that looks before the run
    s.native.call("refresh")
    s.recorder.energy.begin(s.native.raw())
    hand_over(s, 60 * SECOND)
    assert any("J, more than half of what was turned over, are gone with motions too fast" in x for _, x in s.notes)


def test_a_bounce_between_two_energy_checks_is_not_mistaken_for_created_energy():
    """Euler's energy errs by w h / 2 of what swings; where the load is back at the top, nothing swings any more."""
    scene = hung(0.1)
    rope = replace(scene.ropes[0], EA=1000.0 * EA / LENGTH * 0.1, L0=0.1)
    s = started(replace(scene, ropes=(rope,)), method="semi-implicit-euler", step=1e-3, sample_ns=SECOND)
    hand_over(s, SECOND // 5)
    assert len(times(s, "rope", "slack")) >= 4
    assert column(s, "rope/peak")[1].max() == pytest.approx(2.0 * MASS * G, rel=0.05)


def test_a_tolerance_too_loose_for_a_stiff_rope_is_reported():
    """A thousandth of 60 m are 6 cm, and the rope stretches by less: dopri5 swings up at its limit of stability."""
    scene = hung(LENGTH)
    scene = replace(scene, ropes=(replace(scene.ropes[0], EA=100.0 * EA),))
    s = started(scene, tolerance=1e-3, sample_ns=SECOND // 20)
    hand_over(s, 2 * SECOND)
    assert any("with the errors that its tolerance allows; do not trust tensions" in x for _, x in s.notes)
    fine = started(scene, tolerance=1e-7, sample_ns=SECOND // 20)
    hand_over(fine, 2 * SECOND)
    assert fine.notes == []


# ---- steps that collapse ------------------------------------------------------------------------------------


def test_a_step_size_that_shrinks_to_nothing_is_reported_with_the_mode_the_body_and_the_force_law():
    """1 g on a spring of 1e25 N/m, which starts 1 m away: no step follows that."""
    scene = slider(mass=1e-3, axis=Z, q0=1.0)
    scene = replace(scene, springs=(JointSpring("spring", "load-guide", 1e25),))
    with pytest.raises(KernelError) as e:
        hand_over(started(scene), SECOND)
    hertz = sqrt(1e25 / 1e-3) / (2.0 * pi)
    assert str(e.value) == (
        f"body 'load' at 0.000000 s: the step became too small (below 1e-12 s); 'load' on 'spring' swings at "
        f"{hertz:.3g} Hz, or a law near it jumps; soften it, or choose method radau5"
    )


def test_an_error_about_the_step_size_names_the_fastest_mode_of_the_system():
    """Of two bodies on ropes the lighter one, and the rope that holds it."""
    one, other = hung(LENGTH + 0.1), slider("hook", 500.0, q0=-6.1)
    line = Line(Point("world"), Point("hook"))
    scene = replace(
        one, bodies=one.bodies + other.bodies, joints=one.joints + other.joints,
        ropes=(*one.ropes, Rope("tackle", (line,), EA, 6.0)),
    )  # fmt: skip
    s = Simulation(scene)
    s.start()
    mode = fastest(s.native, s.native.jacobian())
    assert (mode.body, mode.law) == ("hook", "tackle")
    assert mode.frequency == pytest.approx(sqrt(EA / 6.0 / 500.0) / (2.0 * pi), rel=1e-3)
