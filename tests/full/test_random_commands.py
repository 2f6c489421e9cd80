"""Random commands to a scene with every law: energy closes, bits do not depend on grants, errors are sentences."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "kernel"))

from heavylift.kernel.describe import (
    Body,
    Brake,
    Drive,
    Joint,
    JointSpring,
    Line,
    Master,
    Measured,
    Point,
    Rope,
    Stop,
    Support,
    System,
    Threshold,
)  # fmt: skip
from heavylift.kernel.errors import KernelError
from small_scenes import SECOND, G, X, Y, Z, cube, hand_over, imbalance, started

CLOSES = 1e-7  # at tolerance 1e-9
END = 30


def yard() -> System:
    """A trolley and a winch that carry a block over pads; a hinged arm with spring, stop and brake; one loose sling."""
    m = 5.0e4
    bodies = (
        Body("trolley", 2.0e4),
        Body("cat", 1.0e4),
        Body("block", m, (0.2, -0.1, 0.1), cube(m, 4.0)),
        Body("arm", 5.0e3, (0.8, 0.0, 0.0), cube(5.0e3)),
    )
    joints = (
        Joint("rail", "prismatic", "world", "trolley", (0.0, 0.0, 30.0), axis=X),
        Joint("girder", "prismatic", "trolley", "cat", axis=Y),
        Joint("float", "free", "world", "block", q0=(0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0)),
        Joint("hinge", "revolute", "block", "arm", (0.0, 0.0, 2.0), axis=Z),
    )
    rope = tuple(Line(Point("cat", (x, 0.0, 0.0)), Point("block", (x, 0.0, 2.0)), 0.5) for x in (-1.0, 1.0))
    sling = Line(Point("trolley", (3.0, 0.0, 0.0)), Point("block", (2.0, 0.0, 2.0)))
    k, d = m * G / 4 / 5e-3, 4e5
    return System(
        bodies,
        joints,
        springs=(JointSpring("closer", "hinge", 2.0e4, 2.0e3),),
        stops=(Stop("hinge-stop", "hinge", -0.3, 0.4, 5.0e6, 2.0e4),),
        brakes=(Brake("hinge-brake", "hinge", 5.0e3, 1.0e6, 1.0e4, True),),
        drives=(Drive("travel", "rail", "servo", 1.0e6, 2.0e5), Drive("traverse", "girder", "prescribed")),
        ropes=(
            Rope("hoist", rope, 4.0e8, 26.1, 1.0e5, winch=True),
            Rope("sling", (sling,), 2.0e8, 26.5, 5.0e4, hooked=False),
        ),
        supports=tuple(
            Support(f"pad{x}{y}", Point("block", (2.0 * x, 2.0 * y, -2.0)), 0.0, k, d, 0.3, k, d)
            for x in (-1, 1)
            for y in (-1, 1)
        ),
        masters=(Master("theta"),),
        measured=(Measured("lean", "angle", "block"), Measured("swing", "joint", "hinge")),
        thresholds=(
            Threshold("high", "height", point=Point("block")),
            Threshold("heavy", "tension", ropes=("hoist", "sling")),
        ),
        gravity=G,
    )


def command(s, random) -> str:
    """One command; returns the sentence of a refusal."""
    t, u = s.epoch, random.uniform
    choices = [
        lambda: s.references.set_profile("hoist", t, u(0.05, 0.5), u(0.05, 1.0), u(-2.0, 1.5)),
        lambda: s.references.set_profile("hoist", t, 0.0, u(0.05, 1.0), None),
        lambda: s.references.set_profile("travel", t, u(0.1, 0.6), u(0.05, 0.5), u(-2.0, 2.0)),
        lambda: s.references.set_profile("traverse", t, u(-0.4, 0.4), u(0.05, 0.5), None),
        lambda: s.references.set_profile("theta", t, u(0.01, 0.1), u(0.01, 0.1), u(-0.5, 0.5)),
        lambda: s.set_follow("travel", "theta", (u(-1, 1), u(-2, 2), u(-2, 2))),
        lambda: s.set_follow("hoist", random.choice(["theta", "lean", "swing", ""]), (u(-0.2, 0.2), u(-1, 1), 0.0)),
        lambda: s.set_brake("hinge-brake", bool(random.integers(2))),
        lambda: s.hook("sling", L0=u(24.0, 30.0)),
        lambda: s.unhook("sling"),
        lambda: s.switches.watch("high", u(1.5, 4.0), bool(random.integers(2))),
        lambda: s.switches.watch("heavy", u(0.0, 6e5), bool(random.integers(2))),
    ]
    try:
        choices[int(random.integers(len(choices)))]()
    except KernelError as e:
        return str(e)
    return ""


def play(seed, windows):
    """Fifteen commands at random nanoseconds; `windows` further grants between two of them."""
    random, cuts = np.random.default_rng(seed), np.random.default_rng(seed + 1)
    s = started(yard(), tolerance=1e-9, sample_ns=50_000_000, h_max=0.02)
    refused = []
    for t_ns in sorted({*map(int, random.integers(0, END * SECOND, 15))}):
        for until in sorted(map(int, cuts.integers(s.epoch, t_ns + 1, windows))):
            s.run(until)
        hand_over(s, t_ns)
        refused.append(command(s, random))
        s.settle()
    s.run(END * SECOND)
    hand_over(s, END * SECOND)
    return s, refused


def bits(s):
    n = s.program.ny
    return s.state[:n].tobytes(), [(t, row.tobytes()) for t, row in s.rows], s.log


@pytest.mark.parametrize("seed", range(60))
def test_any_story_closes_its_energy_and_has_the_same_bits_whatever_was_granted(seed):
    s, refused = play(seed, 0)
    assert np.isfinite(s.state).all()
    assert not any("\n" in sentence for sentence in refused)
    assert imbalance(s) < CLOSES
    again, same = play(seed, 20)
    assert same == refused
    assert bits(again) == bits(s)
