"""A trajectory that Drake, Exudyn and MuJoCo converge to: two cranes, six loaders, one swinging block, ten seconds."""

import json
from pathlib import Path

import numpy as np
import pytest
from goliath import scene
from heavylift.kernel.compiler import llvm_function
from heavylift.kernel.simulation import Simulation

REFERENCE = json.loads((Path(__file__).parents[2] / "data" / "goliath_reference.json").read_text())
TENSION_ERROR = 1e-6  # of 550 kN: two orders above the reference's own error (rtol 1e-12)
SAME = 1e-12  # the same text on floats and in machine code: round-off of some thousand operations


def test_tensions_of_the_first_ten_seconds_agree_with_the_stored_goliath_reference():
    simulation = Simulation(scene(), tolerance=1e-10, sample_ns=100_000_000)
    simulation.start()
    simulation.run(10_050_000_000)
    columns = simulation.method.row_layout.at["tension"]
    rows = {t: row[columns] for t, row in simulation.rows}
    error = max(
        np.abs(rows[round(t * 1e9)] - want).max()
        for t, want in zip(REFERENCE["t"], np.array(REFERENCE["tension"]), strict=True)
    )
    assert error / 550e3 < TENSION_ERROR


@pytest.mark.parametrize("opt", [0, 3])
@pytest.mark.large(beyond=1)
def test_the_goliath_reference_agrees_in_interpreted_python_and_in_machine_code_at_every_optimisation_level(opt):
    native, oracle = (Simulation(scene(), native=n, opt=opt, cache=False) for n in (True, False))
    random = np.random.default_rng(1)
    for _ in range(5):
        state = native.program.initial_state()
        n = native.program.nq + native.program.nv
        state[:n] += 0.05 * random.standard_normal(n)
        for simulation in (native, oracle):
            simulation.state[:] = state
            simulation.start()
        f, want = (s.X[s.method.layout.at["f"]] for s in (native, oracle))
        assert np.abs(f - want).max() < SAME * np.abs(want).max()


@pytest.mark.large
def test_strict_arithmetic_gives_bit_identical_results_at_every_optimisation_level():
    ends = []
    for opt in (0, 1, 2, 3):
        simulation = Simulation(scene(), opt=opt, cache=False)
        simulation.start()
        simulation.run(2_000_000_000)
        ends.append(simulation.X.tobytes())
    assert len(set(ends)) == 1


@pytest.mark.parametrize("method", ["dopri5", "dop853", "radau5"])
def test_seldom_called_functions_give_the_same_bits_optimised_or_not(method, monkeypatch):
    ends, unoptimised = [], []
    for instructions in (0, llvm_function.RARE, 10**9):
        monkeypatch.setattr(llvm_function, "RARE", instructions)
        simulation = Simulation(scene(), method=method, cache=False, sample_ns=50_000_000)
        simulation.start()
        simulation.run(1_000_000_000)
        ends.append((simulation.X.tobytes(), [(t, row.tobytes()) for t, row in simulation.rows]))
        unoptimised.append(simulation.method.ir().count(" optnone"))
    assert ends[0] == ends[1] == ends[2]
    assert unoptimised[0] > unoptimised[1] > unoptimised[2] == 0
