"""Simulations of variants of a scene leave the memory when nobody uses them: only the last programs are kept."""

import gc
import weakref

from heavylift.kernel.model.program import MOST
from heavylift.kernel.simulation.native import channels, published
from small_scenes import hung, started

KEPT = MOST + 1  # the last programs, and that whose machine code others share


def test_programs_of_simulations_whose_samples_were_read_do_not_stay():
    programs = []
    for n in range(2 * KEPT):
        simulation = started(hung(1.0 + 0.01 * n))
        rows = published(simulation.method, simulation.native.raw()[None])
        assert rows.shape == (1, channels(simulation.method)[-1].stop)
        programs.append(weakref.ref(simulation.program))
    del simulation
    gc.collect()
    assert len(programs) > sum(program() is not None for program in programs) <= KEPT
