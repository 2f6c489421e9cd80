"""The energy balance of a block of samples equals that of its single samples."""

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.methods import Balance

READINGS, PARTS = 40, 5


def one_by_one(balance, readings):
    """The sentence with which it ends, and the reading at which."""
    for k, reading in enumerate(zip(*readings, strict=True)):
        try:
            balance.check("here", *reading)
        except KernelError as error:
            return str(error), k
    return "", READINGS


@pytest.mark.parametrize("implicit", [False, True])
@pytest.mark.parametrize("seed", range(40))
def test_the_energy_balance_checked_on_blocks_of_samples_equals_that_of_single_samples(seed, implicit):
    rng = np.random.default_rng(seed)
    kinetic = rng.exponential(1e3, READINGS)
    parts = rng.normal(0.0, 1e3, (READINGS, PARTS))
    parts[:, 0] -= (kinetic + parts.sum(axis=1)) * (1.0 - rng.normal(0.0, 10.0 ** rng.uniform(-12, 0.5), READINGS))
    held = rng.exponential(1.0, READINGS)
    readings = kinetic, parts, np.full(READINGS, 1e-9), held
    block, single = Balance(1e-6, implicit), Balance(1e-6, implicit)
    for balance in (block, single):
        balance.begin(float(kinetic[0]), parts[0])
    fine = block.fine(*readings)
    text, _ = one_by_one(single, readings)
    assert fine == (not text and not single.lost)
    if fine:
        assert block._turned == single._turned
