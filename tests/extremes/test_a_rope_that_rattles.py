"""A rope that alternates between slack and taut faster than events can resolve continues with damping and a note."""

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from heavylift.kernel.description import Body, Joint, Line, Point, Rope, Stop, System
from heavylift.kernel.simulation.safeguards import MANY, RESOLVED, critical, moved_mass
from small_scenes import EA, LENGTH, MASS, SECOND, G, X, column, hand_over, hung, imbalance, started, times

LIGHT = 5e-3  # [kg] a loader as light as a bolt


def rattling_scene(mass: float = LIGHT) -> System:
    """A light body bounces on a rope far too stiff for it, pressed by its weight alone."""
    scene = hung(LENGTH, v0=-1e-5)
    return replace(scene, bodies=(replace(scene.bodies[0], mass=mass),), ropes=(replace(scene.ropes[0], EA=EA * 1e2),))


@pytest.mark.parametrize("method", [{}, {"method": "dop853"}])
def test_a_rope_that_rattles_between_slack_and_taut_continues_without_events_and_is_reported(method):
    s = started(rattling_scene(), sample_ns=SECOND // 100, **method)
    hand_over(s, SECOND // 10)
    chatter = [e for _, e in s.log if e.what == "chatter"]
    assert [e.name for e in chatter] == ["rope"]
    assert len(s.log) <= 2 * MANY + 3, "and no event after it"
    assert chatter[0].value > 0.5 / RESOLVED
    assert any("rope 'rope' at" in x and "faster than events can resolve" in x for _, x in s.notes)
    assert float(s.row().tension[0]) == pytest.approx(LIGHT * G, rel=1e-2), "at rest in the end"


def test_repeating_a_run_with_a_rattling_rope_gives_bit_identical_results():
    one, two = (started(rattling_scene(), sample_ns=SECOND // 100) for _ in range(2))
    for s in (one, two):
        hand_over(s, SECOND // 20)
    assert one.state.tobytes() == two.state.tobytes()
    assert one.log == two.log
    assert one.notes == two.notes


def test_a_snapshot_keeps_the_damping_of_a_rattling_rope():
    whole = started(rattling_scene(), sample_ns=SECOND // 100)
    hand_over(whole, SECOND // 20)
    whole.settle()
    kept = whole.snapshot()
    other = started(rattling_scene(), sample_ns=SECOND // 100)
    other.restore(kept)
    for s in (whole, other):
        hand_over(s, SECOND // 10)
    assert whole.state.tobytes() == other.state.tobytes()


def test_a_rattling_rope_that_is_hooked_again_has_events_and_its_stated_damping_again():
    s = started(rattling_scene(), sample_ns=SECOND // 100)
    hand_over(s, SECOND // 10)
    assert s.switches.rope_numbers("rope")[1] > 0.0
    s.unhook("rope")
    s.hook("rope", L0=-float(s.state[0]) + 1e-3)
    s.settle()
    assert s.switches.rope_numbers("rope")[1] == 0.0
    before = len(s.log)
    hand_over(s, SECOND // 10 + SECOND // 50)
    assert ("rope", "taut") in [(e.name, e.what) for _, e in s.log[before:]]


def test_a_load_that_bounces_to_rest_is_not_taken_for_rattling():
    """Creep speed, a damped rope, hundreds of milliseconds between the bounces."""
    s = started(hung(LENGTH - 0.05, damping=2e6), tolerance=1e-9)
    hand_over(s, 20 * SECOND)
    assert not [e for _, e in s.log if e.what == "chatter"]
    assert times(s, "rope", "taut")


def test_a_rope_that_changes_slowly_between_taut_and_slack_is_not_reported_as_rattling():
    """A drum at creep speed, 0.1 mm/s, takes up and gives way: one event each, and the balance closes."""
    stop = Stop("ground", "load-guide", -LENGTH, 100.0, 1e9, 1e7)
    z = LENGTH + MASS * G / 1e9
    s = started(replace(hung(z, z + 1e-5, winch=True), stops=(stop,)), tolerance=1e-10, sample_ns=SECOND // 10)
    s.references.set_profile("rope", 0, 1e-4, 1e-2, -1e-4)
    s.settle()
    hand_over(s, 2 * SECOND)
    s.references.set_profile("rope", 2 * SECOND, 1e-4, 1e-2, 2e-4)
    s.settle()
    hand_over(s, 5 * SECOND)
    assert [e.what for _, e in s.log if e.name == "rope"] == ["taut", "slack"]
    assert imbalance(s) < 1e-6


def test_a_rattling_rope_without_events_conserves_the_energy_balance():
    s = started(hung(LENGTH - 0.5, damping=1e5), tolerance=1e-10, sample_ns=SECOND // 50)
    s.native.calm = frozenset({"rope"})
    s.native.use(s.program.locked)
    s.switches.rope_numbers("rope")[3] = 1.0
    s.settle()
    hand_over(s, 4 * SECOND)
    assert float(column(s, "rope/tension")[1].min()) == 0.0
    assert imbalance(s) < 1e-6


def test_the_effective_mass_at_a_rope_is_that_of_two_bodies_in_series():
    line = Line(Point("a"), Point("b"))
    scene = System(
        (Body("a", 300.0), Body("b", 600.0)),
        (
            Joint("ga", "prismatic", "world", "a", axis=X, q0=(-1.0,), v0=(-1.0,)),
            Joint("gb", "prismatic", "world", "b", axis=X, q0=(1.0,)),
        ),
        ropes=(Rope("rope", (line,), 1e6, 2.0),),
        gravity=G,
    )
    s = started(scene)
    p = s.switches.rope_numbers("rope")
    before = p.copy()
    assert moved_mass(p, 0, slice(2, 4), s.state.copy(), s.native.rate) == pytest.approx(200.0, rel=1e-9)
    assert np.array_equal(p, before)
    assert critical(1e6, 2.0, 200.0) == pytest.approx(2.0 * sqrt(5e5 * 200.0))
    assert critical(1e6, 2.0, np.inf) == 0.0
