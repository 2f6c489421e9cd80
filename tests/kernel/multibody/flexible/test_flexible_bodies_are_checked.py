"""Impossible flexible bodies are refused in one sentence with their names."""

from dataclasses import replace

import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import (
    Beam,
    Body,
    Flexible,
    Joint,
    Line,
    Nodal,
    Point,
    RigidRope,
    Rope,
    Support,
    System,
)
from heavylift.kernel.model import Program
from small_scenes import started

BEAM = Beam(10.0, 100.0, EI_y=1e6, elements=8)
GOOD = Flexible(2, BEAM)
DIAGONAL = ((2.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 2.0))
NODAL = Nodal(((1.0, 0.0, 0.0),), DIAGONAL, DIAGONAL)


def system(flexible: Flexible, at: tuple[float, float, float] = (5.0, 0.0, 0.0)) -> System:
    support = Support("pad", Point("beam", at), -1.0, 1e6, 1e3)
    joint = Joint("root", "fixed", "world", "beam")
    return System((Body("beam", 0.0, flexible=flexible),), (joint,), supports=(support,))


BAD = [
    (replace(GOOD, nodal=NODAL), "a flexible body has either a beam or nodal matrices"),
    (replace(GOOD, modes=-1), "-1 modes of damping ratio 0; neither can be negative"),
    (replace(GOOD, beam=replace(BEAM, length=0.0)), "length of its beam is 0; it must be positive"),
    (replace(GOOD, beam=replace(BEAM, EA=-1.0)), "EA of its beam is -1; it cannot be negative"),
    (
        replace(GOOD, beam=replace(BEAM, GJ=1.0)),
        "its beam twists (GJ), but nothing resists that: give the moment of inertia 'polar'",
    ),
    (replace(GOOD, beam=replace(BEAM, EI_y=0.0)), "2 modes are requested, but its model has only 0"),
    (replace(GOOD, modes=17), "17 modes are requested, but its model has only 16"),
    (replace(GOOD, loads=(11.0,)), "a load at 11 m lies beyond its ends at 0 and 10 m"),
    (replace(GOOD, start=(0.1,)), "1 start coordinates are given for 2 modes"),
    (Flexible(1, nodal=replace(NODAL, mass=DIAGONAL[:2])), "a mass matrix of 2 rows for 1 nodes"),
    (Flexible(1, nodal=replace(NODAL, stiffness=DIAGONAL[:2])), "its stiffness matrix is not one of 3 rows"),
    (
        Flexible(1, nodal=replace(NODAL, mass=((2.0, 1.0, 0.0), *DIAGONAL[1:]))),
        "its mass matrix is not symmetric",
    ),
    (
        Flexible(1, nodal=replace(NODAL, mass=((-2.0, 0.0, 0.0), *DIAGONAL[1:]), held=(1, 2))),
        "its mass matrix must be positive definite wherever the frame does not hold it",
    ),
    (Flexible(1, nodal=replace(NODAL, held=(3,))), "held degree of freedom 3; there are 0 to 2"),
]


@pytest.mark.parametrize(("flexible", "told"), BAD, ids=[told[:40] for _, told in BAD])
def test_invalid_flexible_bodies_are_refused(flexible, told):
    with pytest.raises(KernelError) as e:
        Program(system(flexible))
    assert str(e.value).startswith(f"body 'beam': {told}")
    assert "\n" not in str(e.value)


def test_points_outside_a_flexible_body_are_refused():
    with pytest.raises(KernelError, match=r"body 'beam': x = 10.5 m lies beyond its ends at 0 and 10 m"):
        Program(system(GOOD, (10.5, 0.0, 0.0)))
    held = replace(NODAL, held=(0, 1))
    with pytest.raises(KernelError, match=r"body 'beam': \(5, 0, 0\) is not a node; the nearest one is \(1, 0, 0\)"):
        Program(system(Flexible(1, nodal=held)))


def test_of_the_formulations_of_the_equations_of_motion_only_the_recursive_one_supports_flexible_bodies():
    with pytest.raises(
        KernelError, match="body 'beam' is flexible, but formulation 'augmented' supports only rigid bodies"
    ):
        Program(system(GOOD), "augmented")


@pytest.mark.parametrize("EA", [1e6, 0.0])
def test_a_rope_hooked_to_a_beam_stays_attached_at_the_same_place_along_the_beam(EA):
    """The new end is given in the body's frame: 2 m above the axis at x = 5 m, 1 m from the rope's other end."""
    line = Line(Point("beam", (5.0, 0.0, 0.5)), Point("world", (5.0, 0.0, 3.0)))
    rope = Rope("rope", (line,), EA, 4.0, hooked=False) if EA else RigidRope("rope", (line,), 4.0, hooked=False)
    ropes = {"ropes": (rope,)} if EA else {"rigid_ropes": (rope,)}
    s = started(replace(system(GOOD), supports=(), **ropes))
    message = r"its end is fixed to the station \(5, 0, 0\) of the flexible body 'beam'; use one rope"
    with pytest.raises(KernelError, match=message):
        s.hook("rope", a=(6.0, 0.0, 0.5))
    with pytest.raises(KernelError, match="100 mm too short"):
        s.hook("rope", a=(5.0, 0.0, 2.0), L0=0.9)
    s.hook("rope", a=(5.0, 0.0, 2.0), L0=1.1)
    row = s.row()
    assert [-row.elongation[0] if EA else row.slack[0]] == pytest.approx([0.1], abs=1e-12)
