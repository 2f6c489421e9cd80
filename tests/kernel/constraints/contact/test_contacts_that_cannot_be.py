"""Impossible contacts are refused in one sentence, before the run or where no contact force exists."""

from math import tan

import numpy as np
import pytest
from contact_scenes import brick, floating, on_slope  # fmt: skip
from heavylift.kernel import KernelError
from heavylift.kernel.description import Ball, Box, Contact, Plane, System
from scipy.spatial.transform import Rotation
from small_scenes import SECOND, G, started

REFUSED = [
    (Contact("c", Box("brick", (1.0, 1.0, 1.0)), Ball("world")), "box against ball is not possible; pairs"),
    (Contact("c", Ball("brick"), Ball("brick")), "both shapes belong to 'brick'"),
    (Contact("c", Ball("brick"), Plane(), -0.1), "mu is -0.1; it cannot be negative"),
    (Contact("c", Ball("brick"), Plane(), 0.1, 1.5), "restitution is 1.5"),
    (Contact("c", Ball("brick"), Plane(normal=(0.0, 0.0, 0.0))), "the normal of its plane is zero"),
    (Contact("c", Box("brick", (1.0, 0.0, 1.0)), Plane()), "make them positive"),
    (Contact("c", Ball("brock"), Plane()), "there is no body 'brock'"),
    (Contact("c", Ball("brick", radius=0.51), Plane()), "lies 10 mm inside 'world'"),
]


@pytest.mark.parametrize(("contact", "words"), REFUSED, ids=[w for _, w in REFUSED])
def test_invalid_contacts_are_refused_in_one_sentence(contact, words):
    scene = on_slope(0.0, 0.0)
    with pytest.raises(KernelError, match="'c'") as e:
        started(System(scene.bodies, scene.joints, contacts=(contact,), gravity=G))
    assert words in str(e.value)


def test_the_painleve_paradox_of_a_rod_is_reported_with_its_name():
    """A long rod scrapes over very rough ground, leaning into its motion: no force fits."""
    lean = np.radians(50.0)
    scene = leaning_rod(lean, mu=tan(lean) * 3.0)
    with pytest.raises(KernelError, match=r"'tip'.*Painleve"):
        started(scene).run(SECOND)


def leaning_rod(lean, mu):
    """Its lower end at the origin, sliding ahead of it."""
    R = Rotation.from_rotvec([0.0, lean, 0.0])
    body = brick("rod", (0.01, 0.01, 2.0), 1.0)
    joint = floating("rod", R.apply([0.0, 0.0, 1.0]), R.as_quat(), (*R.inv().apply([-1.0, 0.0, 0.0]), 0.0, 0.0, 0.0))
    tip = Contact("tip", Ball("rod", (0.0, 0.0, -1.0)), Plane(), mu)
    return System((body,), (joint,), contacts=(tip,), gravity=G)
