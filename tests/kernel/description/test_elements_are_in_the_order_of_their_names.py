"""Systems are equal for any order in which their elements are declared."""

from dataclasses import fields, replace
from random import Random

from heavylift.kernel.description import Body, Joint, System, assembled, natural
from heavylift.nodes.models import build
from heavylift.nodes.scene import load

G = 9.81


def test_elements_are_sorted_by_the_numbers_in_their_names() -> None:
    wanted = ["H1", "H2", "H10", "H10a", "loader-2.sling-1", "loader-2.sling-10", "loader-10.sling-1", "x", "x01", "x1"]
    wanted += ["y" + "8" * 5000, "y" + "9" * 5000, "y1" + "0" * 5000]
    for seed in range(10):
        assert sorted(Random(seed).sample(wanted, len(wanted)), key=natural) == wanted


def test_a_compiled_system_does_not_depend_on_the_order_in_which_its_parts_are_declared() -> None:
    parts = [model.declare() for model in build(load("turnover").plan).values()]
    whole = assembled(parts, G)
    assert [rope.name for rope in whole.ropes[:4]] == ["east.H1", "east.H2", "east.H3", "loader-1.sling-1"]
    for seed in range(5):
        random = Random(seed)
        mixed = [shuffled(part, random) for part in random.sample(parts, len(parts))]
        assert assembled(mixed, G) == whole


def shuffled(system: System, random: Random) -> System:
    groups = [f.name for f in fields(System) if f.name != "gravity"]
    return replace(system, **{g: tuple(random.sample(x, len(x))) for g in groups if (x := getattr(system, g))})


def test_sorting_elements_by_name_does_not_change_the_order_of_their_coordinates() -> None:
    """Only elements are put in order, never what stands in them."""
    joints = (Joint("b", "spherical", "world", "load", q0=(0.0, 0.0, 0.0, 1.0), v0=(3.0, 2.0, 1.0)),)
    whole = assembled([System((Body("load", 1.0),), joints)], G)
    assert whole == System((Body("load", 1.0),), joints, gravity=G)
