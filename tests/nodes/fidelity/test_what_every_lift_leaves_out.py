"""What is left out of every lift is told with its numbers: held bodies, sheaves, wind, pairs, islands."""

from heavylift.coordinator.participants import configured
from heavylift.kernel.description import Body, Joint, Point, System, Wind
from heavylift.kernel.description.forces import Signal
from heavylift.nodes.fidelity import always, lift_of
from heavylift.nodes.models import build, system
from heavylift.nodes.scene import check, load

TURNOVER = load("turnover").plan
LIFT = load("lift").plan
ALWAYS = ["merged bodies", "sheaves", "wind", "contact pairs", "islands"]


def test_the_report_names_all():
    text = str(check(load("lift", ["ask=[rope tension]", "accuracy=1 %"])))
    assert all(name in text for name in ALWAYS)
    told = load("lift", ["ask=[rope tension]", "accuracy=1 %"]).verdict.data()["always"]
    assert [c["rule"] for c in told] == ALWAYS


def test_the_lead_part_of_twenty_falls_carries_fifteen_percent_more():
    """n (1 - eta) / (1 - eta^n) of 0.985 is 1.150."""
    choice = always.reeving(LIFT, system(LIFT))
    assert "20 falls are one spring" in choice.reason
    assert "15% more" in choice.reason
    assert choice.saved == 2 * 19 * len(lift_of(LIFT).rig.hook_ropes)


def test_a_locked_joint_makes_one_body_of_two():
    free = always.merged(LIFT, system(LIFT)).saved
    locked = load("lift", ["fidelity.locked=[hinges]"]).plan
    assert always.merged(locked, system(locked)).saved == free + 12 * len(lift_of(LIFT).loaders)


def test_pads_of_other_faces_are_pairs_that_nobody_tests():
    every = always.contact(TURNOVER, system(TURNOVER))
    pads = len(lift_of(TURNOVER).block.pads)
    standing = sum(pad.closed for pad in lift_of(TURNOVER).block.pads)
    assert every.reason.startswith(f"{pads} of {pads * standing} pairs of {pads} pads and {standing} stools")


def test_no_wind_is_said_aloud_and_one_that_blows_is_told_with_its_size():
    assert always.wind(LIFT, system(LIFT)).reason == "no wind: none is named"
    gust = load("gust").plan
    told = always.wind(gust, system(gust))
    assert not told.allowed
    assert told.reason == "'wind' pushes with 14.3 kN at 15 m/s"  # 1.225 * 1.3 * 80 * 15^2 / 2
    calm = System(forces=(Wind("w", Point("b"), 1.0, 1.0, (1.0, 0.0, 0.0), Signal(2.0)),))
    assert always.wind(LIFT, calm).reason == "'w' pushes with 0.00245 kN at 2 m/s"


def test_what_nothing_ties_together_is_an_island():
    bodies = tuple(Body(name, 1.0) for name in ("a", "b"))
    rails = tuple(Joint(f"{b}-rail", "prismatic", "world", b, q0=(0.0,), v0=(0.0,)) for b in ("a", "b"))
    assert always.islands(LIFT, System(bodies, rails)).reason == "2 groups of machines, each by itself"


def test_islands_are_solved_together_if_the_scene_says_so():
    together = load("turnover", ["fidelity={islands: together}"]).plan
    assert configured(TURNOVER, build(TURNOVER)).apart
    assert not configured(together, build(together)).apart


def test_machines_of_a_lift_are_one_island():
    assert always.islands(TURNOVER, system(TURNOVER)).reason == "all machines are tied together"
