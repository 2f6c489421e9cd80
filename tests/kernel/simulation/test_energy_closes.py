"""Energy accounts of work, heat and stored energy are integrated from their powers and sum to zero."""

from dataclasses import replace

import numpy as np
import pytest
from heavylift.kernel.description import (
    Body,
    Brake,
    Drive,
    Joint,
    JointSpring,
    Line,
    Point,
    Rope,
    Stop,
    Support,
    System,
)
from heavylift.kernel.forces import RopeLaw
from small_scenes import EA, MASS, SECOND, G, X, Y, Z, column, cube, events, hand_over, hung, imbalance, slider, started

CLOSES = 1e-10  # of the energy turned over
CLOSES_BOUNCING = 1e-9  # with some twenty events, each rounded to a nanosecond
FINE = {"tolerance": 1e-11, "sample_ns": 20_000_000, "h_max": 0.01}
STRETCH = MASS * G / EA  # strain under the load's weight


def hoist(damping, **options):
    """Ten seconds of hoisting a swinging-free load with ramps, then ten of lowering."""
    s = started(hung(60.0 * (1 + STRETCH), damping=damping, winch=True), **{**FINE, **options})
    s.references.set_profile("rope", 0, -0.5, 0.2, -4.0)
    s.settle()
    hand_over(s, 12 * SECOND)
    s.references.set_profile("rope", 12 * SECOND, 0.5, 0.1, 2.0)
    s.settle()
    s.run(20 * SECOND)
    return s


def test_the_energy_balance_of_a_winch_includes_the_strain_wound_up_on_the_drum():
    s = hoist(2.0e5)
    assert events(s) == []
    assert imbalance(s) < CLOSES
    t, e = column(s, "energy")
    raised = e[t <= 12.0][-1, 1] - e[0, 1]
    assert raised == pytest.approx(MASS * G * 4.0, rel=1e-2)


def test_the_energy_balance_of_a_winch_fails_without_the_strain_wound_up(monkeypatch):
    whole = RopeLaw.answer

    def tension_only(law, f, p, ends, signal, joint, t):
        x = whole(law, f, p, ends, signal, joint, t)
        return replace(x, work=-x.shown[0] * signal[1])

    monkeypatch.setattr(RopeLaw, "answer", tension_only)
    monkeypatch.setattr("heavylift.kernel.model.program._made", [])  # programs that were traced with the law as it is
    assert imbalance(hoist(2.0e5, cache=False)) > 1e-4


def test_a_damper_omitted_from_the_energy_balance_is_detected(monkeypatch):
    whole = RopeLaw.answer

    def uncounted(*given):
        x = whole(*given)
        return replace(x, heat=0.0 * x.heat)

    monkeypatch.setattr(RopeLaw, "answer", uncounted)
    monkeypatch.setattr("heavylift.kernel.model.program._made", [])  # programs that were traced with the law as it is
    assert imbalance(hoist(2.0e5, cache=False)) > 1e3 * CLOSES


@pytest.mark.parametrize("damping", [0.0, 3.0e5, 2.0e7])
def test_a_load_bouncing_on_its_rope_conserves_the_energy_balance(damping):
    """Slack under damping leaves strain in the rope, which counts as heat; taut again, it is not for free."""
    s = started(hung(59.0, damping=damping), **FINE)
    s.run(6 * SECOND)
    bounces = [("rope", "taut"), ("rope", "slack"), ("rope", "taut")] if damping < 1e6 else [("rope", "taut")]
    assert events(s)[: len(bounces)] == bounces
    assert imbalance(s) < CLOSES_BOUNCING


def test_the_energy_balance_closes_when_a_slack_rope_becomes_taut_in_a_stretched_state():
    """A drum that pays out fast makes a stretched rope slack; when it stops, the rope is taut and stretched at once."""
    s = started(hung(60.0 * (1 + STRETCH), damping=3.0e7, winch=True), **FINE)
    s.references.set_profile("rope", 0, 0.5, 50.0, 0.02)
    s.settle()
    s.run(3 * SECOND)
    assert events(s)[:2] == [("rope", "slack"), ("rope", "taut")]
    assert [e.value > 1e-3 for _, e in s.log[:2]] == [True, True], "elongated at both"
    assert imbalance(s) < CLOSES


def test_unhooking_a_rope_turns_its_strain_energy_into_heat():
    s = started(hung(60.0 * (1 + STRETCH)), **FINE)
    s.run(SECOND)
    hand_over(s, SECOND + SECOND // 2)
    before = s.row()
    s.unhook("rope")
    s.settle()
    _, accounts = column(s, "account")
    strain_energy = 0.5 * EA * STRETCH**2 * 60.0
    assert float(before.stored[0]) == pytest.approx(strain_energy, rel=1e-9)
    assert accounts[-1, 0] == pytest.approx(strain_energy, rel=1e-9)
    assert s.row().tension[0] == 0.0
    s.run(3 * SECOND)
    assert s.state[1] == pytest.approx(-G * 1.5, rel=1e-9) or s.state[1] < 0.0
    assert imbalance(s) < CLOSES


@pytest.mark.parametrize("kind", ["prescribed", "servo", "speed"])
def test_the_work_of_a_drive_equals_the_energy_gained(kind):
    """A trolley with a spring on its joint carries a pendulum along."""
    system = System(
        (Body("trolley", 3.0e5), Body("bob", 1.0e5, (0.0, 0.0, -30.0), cube(1.0e5))),
        (
            Joint("rail", "prismatic", "world", "trolley", axis=Y),
            Joint("hinge", "revolute", "trolley", "bob", axis=X),
        ),
        springs=(JointSpring("buffer", "rail", 2.0e4, 1.0e4, 0.3), JointSpring("friction", "hinge", d=1.0e6)),
        drives=(Drive("drive", "rail", kind, 1.0e7, 4.0e6),),
        gravity=G,
    )
    s = started(system, **FINE)
    s.references.set_profile("drive", 0, 0.5, 0.1, 3.0)
    s.settle()
    s.run(30 * SECOND)
    _, x = column(s, "joint/position")
    assert x[-1, 0] == pytest.approx(3.0, abs=0.5)  # the speed drive gives way to the spring
    assert imbalance(s) < CLOSES


def test_the_energy_balance_of_a_system_with_every_kind_of_element_closes():
    """Supports with friction, stops, a brake that slips, hinge springs, a sling that slackens."""
    bodies = (
        Body("block", 5.0e4, (0.3, 0.1, 0.0), cube(5.0e4, 4.0)),
        Body("arm", 2.0e4, (1.0, 0.0, 0.0), cube(2.0e4)),
    )
    q0, v0 = (0.0, 0.0, 2.3, 0.0, 0.0, 0.0, 1.0), (0.8, 0.3, 0.0, 0.0, 0.1, 0.0)
    joints = (
        Joint("float", "free", "world", "block", q0=q0, v0=v0),
        Joint("hinge", "revolute", "block", "arm", (0.0, 0.0, 1.0), axis=Y, v0=(1.0,)),
    )
    sling = Line(Point("world", (0.0, 0.0, 9.0)), Point("block", (0.0, 0.0, 2.0)))
    pads = tuple(
        Support(f"pad{x}{y}", Point("block", (2.0 * x, 2.0 * y, -2.0)), 0.0, 3.0e7, 3.0e5, 0.3, 3.0e7, 3.0e5)
        for x in (-1, 1)
        for y in (-1, 1)
    )
    system = System(
        bodies,
        joints,
        springs=(JointSpring("hinge-spring", "hinge", 1.0e4, 1.0e3),),
        stops=(Stop("hinge-stop", "hinge", -0.2, 0.3, 5.0e6, 3.0e4),),
        brakes=(Brake("hinge-brake", "hinge", 3.0e4, 1.0e7, 1.0e5, True),),
        ropes=(Rope("sling", (sling,), 1e8, 6.0, 1e5),),
        supports=pads,
        gravity=G,
    )
    s = started(system, **FINE)
    s.run(6 * SECOND)
    seen = set(events(s))
    assert {("hinge-brake", "slip"), ("hinge-stop", "closed"), ("pad11", "closed"), ("pad11", "slip")} <= seen
    assert imbalance(s) < CLOSES


def test_engaging_an_already_engaged_brake_changes_nothing():
    """Its elastic deflection would else vanish without heat."""
    system = replace(slider(axis=Z, mass=1.0e3), brakes=(Brake("brake", "load-guide", 5.0e4, 1.0e6, 1.0e4, True),))
    s = started(system, **FINE)
    hand_over(s, 2 * SECOND)
    s.set_brake("brake", True)
    s.settle()
    s.run(4 * SECOND)
    assert imbalance(s) < CLOSES
    assert s.state[0] == pytest.approx(-1.0e3 * G / 1.0e6, rel=1e-4)


@pytest.mark.parametrize("engaged", [True, False])
def test_releasing_a_brake_releases_its_elastic_energy(engaged):
    system = replace(slider(axis=Z, mass=1.0e3), brakes=(Brake("brake", "load-guide", 5.0e4, 1.0e6, 1.0e4, engaged),))
    s = started(system, **FINE)
    hand_over(s, SECOND)
    s.set_brake("brake", not engaged)
    s.settle()
    s.run(2 * SECOND)
    assert imbalance(s) < CLOSES
    assert np.isfinite(s.state).all()
