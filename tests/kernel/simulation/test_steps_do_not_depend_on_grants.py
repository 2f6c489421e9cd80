"""Steps depend on commands and state events only: the ends of time grants change no bit."""

from dataclasses import replace

import numpy as np
import pytest
from goliath import scene as goliath
from heavylift.kernel.description import Body, Joint, JointSpring, Line, Point, Rope, System, Threshold
from heavylift.kernel.simulation import Simulation
from heavylift.kernel.simulation.native import FOREVER_NS
from small_scenes import SECOND, G, cube, events, hand_over, hung, slider, started

OWN_CALLS = ("run", "status", "budget", "until")  # of the last native call; everything else must be equal
END = 8 * SECOND


def swing() -> System:
    """A block on two slings that slacken and tighten again and again while it swings."""
    slings = tuple(
        Rope(f"sling{i}", (Line(Point("world", (x, 0.0, 12.0)), Point("block", (x, 0.0, 1.0))),), 4e7, 11.0, 3e4)
        for i, x in enumerate((-3.0, 3.0))
    )
    return System(
        (Body("block", 2.0e4, (0.3, 0.0, 0.0), cube(2.0e4)), Body("tail", 2.0e3, (0.0, 0.0, -1.0), cube(2.0e3))),
        (
            Joint("float", "free", "world", "block", q0=(0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0), v0=(0.5,) + (0.1,) * 5),
            Joint("hinge", "revolute", "block", "tail", (0.0, 0.0, -1.0), axis=(1.0, 0.0, 0.0)),
        ),
        springs=(JointSpring("friction", "hinge", d=2.0e3),),
        ropes=slings,
        thresholds=(Threshold("deep", "height", point=Point("block")),),
        gravity=G,
    )


def bits(s: Simulation) -> tuple[bytes, list, list]:
    """All that later steps can depend on, the rows and the log."""
    X = s.X.copy()
    for name in OWN_CALLS:
        X[s.method.layout.at[name]] = 0.0
    return X.tobytes(), [(t, row.tobytes()) for t, row in s.rows], s.log


def story(windows, subscribed=frozenset()):
    """Two commands on the way; `windows(t)` yields the ends of grants below t."""
    s = started(swing(), sample_ns=100_000_000, subscribed=subscribed)

    def go(t_ns):
        for until in windows(t_ns):
            s.run(until)
            while s.event and s.next_ns < until:
                s.fire()
                s.settle()
                s.run(until)

    for t_ns, command in (
        (2 * SECOND + 1, lambda: s.switches.watch("deep", -0.3, False)),
        (3 * SECOND, lambda: s.unhook("sling1")),
    ):
        go(t_ns)
        hand_over(s, t_ns)
        command()
        s.settle()
    go(END)
    s.run(END)
    return s


def test_many_short_time_grants_and_one_long_grant_give_bit_identical_results():
    random = np.random.default_rng(5)
    whole = story(lambda t: [t])
    assert len(whole.log) > 10
    for n in (3, 40, 1000):
        cut = story(lambda t, n=n: sorted({*map(int, random.integers(0, t, n)), t}))
        assert bits(cut) == bits(whole)


def test_observers_of_a_run_do_not_change_a_single_bit_of_its_recording():
    names = frozenset({"sling0", "sling1", "deep"})
    assert bits(story(lambda t: [t], names)) == bits(story(lambda t: [t]))


def test_repeated_runs_are_bit_identical_also_with_cached_code():
    first = bits(story(lambda t: [t]))
    assert bits(story(lambda t: [t])) == first


def test_a_command_at_the_end_of_an_integration_step_finds_a_state_that_does_not_depend_on_earlier_grants():
    """The tag of a silent step is its end rounded up to a nanosecond: a command may come just after the step."""
    ends = []
    for asked in (False, True):
        s = started(swing(), sample_ns=SECOND)
        s.run(SECOND)
        t_ns = s.next_ns
        assert (s["t"] + s.epoch * 1e-9) * 1e9 < t_ns
        if asked:  # another node's answer came first, so the kernel was granted time up to the command
            s.run(t_ns)
        s.interrupt(t_ns)
        s.settle()
        s.run(2 * SECOND)
        ends.append(bits(s))
    assert ends[0] == ends[1]


def caught():
    s = started(hung(59.0), subscribed=frozenset({"rope"}), tolerance=1e-9)
    s.run(FOREVER_NS)
    return s, s.next_ns


def test_an_event_is_predicted_before_it_occurs_and_the_prediction_can_be_repeated():
    s, t_ns = caught()
    before = s.P.tobytes()
    assert s.event
    assert [(e.name, e.what) for e in s.preview()] == [("rope", "taut")]
    assert s.preview() == s.preview()
    assert s.P.tobytes() == before
    s.run(FOREVER_NS)
    assert s.next_ns == t_ns, "more time granted does not pass an event that somebody waits for"


def test_an_input_one_nanosecond_before_an_event_does_not_move_the_event():
    s, t_ns = caught()
    s.interrupt(t_ns - 1)
    s.settle()
    assert s.next_ns == t_ns - 1, "a new tentative step has not begun"
    assert not s.event
    s.run(FOREVER_NS)
    assert s.event
    assert s.next_ns in (t_ns, t_ns + 1)


def test_an_input_one_nanosecond_before_an_event_can_prevent_it():
    s, t_ns = caught()
    s.interrupt(t_ns - 1)
    s.unhook("rope")
    s.settle()
    s.run(t_ns + SECOND)
    assert events(s) == []
    assert not s.events.fallen


def test_an_input_at_the_time_of_an_event_acts_after_the_event_has_switched_its_discrete_state():
    s, t_ns = caught()
    assert s.fire()[0].what == "taut"
    s.unhook("rope")
    s.settle()
    assert s.epoch == t_ns
    assert not s.events.fallen, "nothing is left to fire"
    s.run(t_ns + SECOND)
    assert events(s) == [("rope", "taut")]


def test_a_threshold_that_is_already_crossed_when_it_is_set_fires_in_the_next_microstep():
    scene = replace(hung(59.0), thresholds=(Threshold("low", "joint", of="load-guide"),))
    s = started(scene, subscribed=frozenset({"rope", "low"}))
    s.run(FOREVER_NS)
    t_ns = s.next_ns
    s.fire()
    s.switches.watch("low", -10.0, False)
    s.settle()
    assert (s.event, s.next_ns) == (True, t_ns)
    assert [e.name for e in s.fire()] == ["low"]
    s.settle()
    assert not s.events.fallen
    assert [t for t, _ in s.log] == [t_ns, t_ns]


def test_an_input_one_nanosecond_after_a_rope_becomes_taut_finds_the_rope_taut():
    s, t_ns = caught()
    s.fire()
    s.settle()
    s.run(t_ns + 1)
    s.interrupt(t_ns + 1)
    s.settle()
    assert events(s) == [("rope", "taut")]
    assert s.row().tension[0] > 0.0
    assert not s.events.fallen, "one that fired is disarmed until it leaves its surface"


@pytest.mark.parametrize("period", [0.25, 1.0])
def test_a_scene_at_rest_takes_no_steps_but_continues_its_samples(period):
    scene = replace(slider(axis=(1.0, 0.0, 0.0)), springs=(JointSpring("spring", "load-guide", 1e6, 1e6),))
    s = started(scene, sample_ns=round(period * SECOND))
    s.run(3600 * SECOND)
    assert s.next_ns == FOREVER_NS
    hand_over(s, 3600 * SECOND)
    s.settle()
    s.run(3601 * SECOND)
    hand_over(s, 3602 * SECOND)
    periodic = [t for t, _ in s.rows if t % round(period * SECOND) == 0]
    assert sorted(set(periodic)) == [round(i * period * SECOND) for i in range(round(3602 / period) + 1)]
    assert max(np.abs(row[:2]).max() for _, row in s.rows) < 1e-12
    times = [t for t, _ in s.rows]
    assert times == sorted(times), "rows come in the order of time"


def test_no_sample_is_missing_if_the_sample_interval_is_shorter_than_the_integration_steps():
    s = started(hung(60.2), sample_ns=200_000)
    s.run(2 * SECOND)
    hand_over(s, 2 * SECOND)
    times = [t for t, _ in s.rows]
    assert set(range(0, 2 * SECOND + 1, 200_000)) <= set(times)
    assert times == sorted(times)


def test_densely_spaced_samples_lie_on_the_exact_trajectory():
    """A free fall is of second order: every sample is exact whatever the steps were."""
    s = started(slider(v0=3.0), sample_ns=1_000_000)
    s.run(3 * SECOND)
    for t_ns, row in s.rows:
        t = t_ns * 1e-9
        assert row[0] == pytest.approx(3.0 * t - G * t * t / 2, abs=1e-11)


def test_the_reference_scene_gives_bit_identical_results_with_short_time_grants():
    ends = []
    for cuts in (1, 30):
        s = started(goliath())
        for i in range(cuts):
            s.run(2 * SECOND * (i + 1) // cuts)
        ends.append(bits(s))
    assert ends[0] == ends[1]
