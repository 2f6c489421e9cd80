"""Random commands to a scene with every law: energy balance, bits for any time grants, and error sentences."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "kernel"))

from every_law import yard
from heavylift.kernel import KernelError
from small_scenes import SECOND, hand_over, imbalance, started

CLOSES = 1e-7  # at tolerance 1e-9
END = 30


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
def test_any_sequence_of_commands_to_the_kernel_conserves_energy_and_is_reproducible_bit_for_bit(seed):
    s, refused = play(seed, 0)
    assert np.isfinite(s.state).all()
    assert not any("\n" in sentence for sentence in refused)
    assert imbalance(s) < CLOSES
    again, same = play(seed, 20)
    assert same == refused
    assert bits(again) == bits(s)
