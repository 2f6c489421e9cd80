"""Each wrong mass or inertia of a scene is one sentence at its line, with the cause and what to write instead."""

import pytest
from heavylift.kernel import KernelError, SceneError
from heavylift.kernel.description import Body
from heavylift.kernel.model import check_inertia
from heavylift.nodes.scene import parse

SCENE = """\
heavylift: 1
name: body
end: 1 s
mechanism:
  bodies:
    bar:
      mass: {mass}
      inertia: {inertia}
  joints:
    pin: {{{joint}, child: bar}}
"""
PIN = "type: revolute, axis: [0, 0, 1]"
FLAT = (
    "none can be larger than the sum of the other two (for a flat plate Ixx + Iyy = Izz): where the other two "
    "do not matter, as in plane motion, write"
)
COUNT = "Ixx, Iyy, Izz or Ixx, Iyy, Izz, Ixy, Ixz, Iyz are needed here, not"
INERTIA = "mechanism.bodies.bar.inertia"


def faults(inertia, mass="1 kg", joint=PIN):
    """What is reported, without the lines that show the text."""
    try:
        parse(SCENE.format(mass=mass, inertia=inertia, joint=joint))
    except SceneError as error:
        return [line for line in str(error).splitlines() if ": error: " in line]
    return []


@pytest.mark.parametrize(
    ("inertia", "told"),
    [
        (
            "[0, 0, 1 kg m2]",
            f"8:7: error: {INERTIA}: body 'bar': its principal moments of inertia are 0, 0, 1 kg m2; {FLAT} "
            "[0.5, 0.5, 1] kg m2",
        ),
        (
            "[1 t m2, 5 t m2, 2 t m2]",
            f"8:7: error: {INERTIA}: body 'bar': its principal moments of inertia are 1000, 2000, 5000 kg m2; {FLAT} "
            "[2000, 5000, 3000] kg m2",
        ),
        (
            "[-1 kg m2, 1 kg m2, 1 kg m2]",
            f"8:17: error: {INERTIA}[0]: a moment of inertia must be zero or more here, not -1 kg m2",
        ),
        (
            "[1 kg m2, 1 kg m2, -3 t m2, 0, 0, 0]",
            f"8:35: error: {INERTIA}[2]: a moment of inertia must be zero or more here, not -3 t m2",
        ),
        ("[.nan, 1 kg m2, 1 kg m2]", f"8:17: error: {INERTIA}[0]: 'nan' is not a finite number"),
        (
            "[1 kg m2, 1 kg m2, 1 kg m2, 0, .nan, 0]",
            f"8:47: error: {INERTIA}[4]: 'nan' is not a finite number",
        ),
        (
            "[1 kg, 1 kg m2, 1 kg m2]",
            f"8:17: error: {INERTIA}[0]: '1 kg' is not a valid moment of inertia: 'kg' is a unit of mass; use "
            "kg m2, t m2",
        ),
        ("[1 kg m2, 1 kg m2]", f"8:16: error: {INERTIA}: {COUNT} 2 values"),
        ("[1 kg m2, 1 kg m2, 1 kg m2, 0]", f"8:16: error: {INERTIA}: {COUNT} 4 values"),
        ("[0, 0, 0, 0, 0, 0, 0]", f"8:16: error: {INERTIA}: {COUNT} 7 values"),
        (
            "[1 kg m2, 1 kg m2, 1 kg m2, 5 kg m2, 0, 0]",
            f"8:7: error: {INERTIA}: body 'bar': its principal moments of inertia are -4, 1, 6 kg m2, but a principal "
            "moment cannot be negative: the products of inertia Ixy 5, Ixz 0, Iyz 0 are too large for the "
            "moments; reduce them",
        ),
        (
            "[1 kg m2, 1 kg m2, 0]",
            "6:5: error: mechanism.bodies.bar: body 'bar': it can move without inertia; give it, or the bodies that it "
            "carries, mass or inertia",
        ),
    ],
)  # fmt: skip
def test_an_impossible_inertia_is_reported_in_one_sentence_with_cause_and_remedy(inertia, told):
    assert faults(inertia) == [f"scene.yaml:{told}"]


def test_an_impossible_inertia_of_a_free_body_is_reported_once():
    free = "type: free"
    (message,) = faults("[0, 0, 1 kg m2]", joint=free)
    assert FLAT in message
    (message,) = faults("[0, 1 kg m2, 1 kg m2]", joint=free)
    assert message.endswith(
        "the body 'bar' moves freely and nothing resists its turning: give it moments with 'inertia'"
    )


@pytest.mark.parametrize("mass", ["-1 kg", ".nan", "1 m"])
def test_an_invalid_mass_is_reported_at_the_line_of_the_mass(mass):
    (message,) = faults("[1 kg m2, 1 kg m2, 1 kg m2]", mass=mass)
    assert message.startswith("scene.yaml:7:13: error: mechanism.bodies.bar.mass: ")


@pytest.mark.parametrize(
    "inertia",
    [
        "[0.333 kg m2, 0.667 kg m2, 1.001 kg m2]",  # a thin plate to three digits
        "[1.24 t m2, 3.51 t m2, 4.76 t m2]",
        "[1 kg m2, 1 kg m2, 2 kg m2, 0.001 kg m2, 0, 0]",
        "[0.5 kg m2, 0.5 kg m2, 1 kg m2]",
    ],
)
def test_an_inertia_with_rounded_digits_is_accepted(inertia):
    assert faults(inertia) == []


def test_the_inertia_that_an_error_message_proposes_is_accepted():
    """For random moments beyond the sum: the sentence ends with some that are possible."""
    import numpy as np

    random = np.random.default_rng(3)
    for _ in range(20):
        a, b = random.uniform(0.0, 1.0, 2)
        x = random.permutation([a, b, (a + b) * random.uniform(1.1, 5.0)])
        with pytest.raises(KernelError) as e:
            check_inertia(Body("b", 1.0, inertia=_diagonal(x)))
        proposed = str(e.value).rpartition("[")[2].partition("]")[0]
        check_inertia(Body("b", 1.0, inertia=_diagonal([float(part) for part in proposed.split(",")])))


def _diagonal(x):
    return ((float(x[0]), 0.0, 0.0), (0.0, float(x[1]), 0.0), (0.0, 0.0, float(x[2])))


def test_an_impossible_inertia_of_a_lifted_block_is_reported_at_its_line_in_the_scene():
    with pytest.raises(SceneError) as e:
        parse("heavylift: 1\nname: l\nextends: lift\nblock: {inertia: [0, 0, 1 t m2]}\n")
    assert str(e.value).startswith("scene.yaml:4:18: error: block.inertia: body 'block': its principal moments")
