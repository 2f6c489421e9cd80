"""Work of drives and winches = kinetic + potential + stored energy + heat of every damper, rope, support and stop.

The turned-over energy counts what every drive and winch has put in or taken out, and all heat.  A lift is stiff work:
of 892 MJ turned over in `turnover` all its dampers together make less than 1 kJ, so that 1e-6 of the whole would
pass over a single one.  Therefore the balance up to the landing is held to 5e-9 (4.5 J) as well: there every
hinge damper (8 to 23 J), hook rope (28 to 40 J) and B sling (33 J) is missed when it is not counted.
"""

from __future__ import annotations

import json

import numpy as np
import pytest
from heavylift.coordinator.record import EnergyAudit
from heavylift.recordings import SampleChannel, SampleLayout
from independent_mechanics import Mechanics
from stock_reader import Array, Reading
from the_run import Lift, Stage

CLOSES = 1e-6  # of the energy turned over
CLOSES_IN_THE_AIR = 5e-9  # of the same, before the block lands
CLOSES_ON_THE_WHOLE = 5e-8  # of the same, at the end
ROUNDED = 1e-11  # of the same: numbers in the file are rounded to 6e-5 J, forty thousand times for each account
WORK, HEAT = 1e-5, 1e-3  # own integrals of powers at 50 samples per second, relative
EXACT = 1e-9  # own sums of energies, of the energy turned over


def imbalance(reading: Reading, without: str = "") -> Array:
    """(n,) [J] of the recorded energies, perhaps with one account left out."""
    kinetic, potential, stored, work, heat = reading.values["/energy"].T
    if without:
        heat = heat - reading.column("/account", without)
    total = kinetic + potential + stored - work + heat
    return np.abs(total - total[0])


def turned_over(reading: Reading) -> float:
    """[J] ways up and down of every work account, all heat, and what went in and out of motion."""
    names, values, energy = reading.names["/account"], reading.values["/account"], reading.values["/energy"]
    works = [i for i, name in enumerate(names) if name.endswith(".work")]
    return float(np.abs(np.diff(values[:, works], axis=0)).sum() + energy[-1, 4] + np.ptp(energy[:, 0]))


def test_the_energy_balance_of_the_scene_turnover_closes(lift: Lift, reading: Reading) -> None:
    message = reading.metadata["result"]
    assert lift.result.energy_error < CLOSES
    assert json.loads(message["energy_error"]) == lift.result.energy_error
    assert lift.result.energy_turned_over == pytest.approx(turned_over(reading), rel=ROUNDED)
    assert lift.result.energy_error == pytest.approx(imbalance(reading).max() / turned_over(reading), rel=1e-9)


def test_work_and_heat_of_all_elements_of_the_scene_turnover_add_up_to_the_recorded_totals(reading: Reading) -> None:
    for what in ("work", "heat"):
        names = [name for name in reading.names["/account"] if name.endswith(f".{what}")]
        total = sum(reading.column("/account", name) for name in names)
        assert np.abs(total - reading.column("/energy", what)).max() < EXACT * turned_over(reading)


def test_energy_accounts_agree_with_sums_over_bodies_and_ropes(mechanics: Mechanics, stages: dict[str, Stage]) -> None:
    reading = mechanics.reading
    scale = EXACT * turned_over(reading)
    assert np.abs(mechanics.kinetic - reading.column("/energy", "kinetic")).max() < scale
    assert np.abs(mechanics.potential - reading.column("/energy", "potential")).max() < scale
    stored = sum(pull.stored for pull in mechanics.pulls.values())
    air = slice(stages["travel"].samples[0], stages["lower"].samples[-1])
    assert np.abs(stored - reading.column("/energy", "stored"))[air].max() < scale


def test_energy_accounts_agree_with_integrals_of_power(fine: Mechanics) -> None:
    """What winches put in and ropes lose, from tensions and rates alone, up to the free-hanging block."""
    reading = fine.reading
    for name in fine.hook_ropes:
        pull = fine.pulls[name]
        assert _integral(reading.t, pull.winding) == pytest.approx(
            reading.column("/account", f"{name}.work")[-1], rel=WORK
        )
        assert _integral(reading.t, pull.heating) == pytest.approx(
            reading.column("/account", f"{name}.heat")[-1], rel=HEAT
        )


def test_the_energy_balance_of_the_scene_turnover_closes_far_better_before_the_landing(
    reading: Reading, stages: dict[str, Stage]
) -> None:
    air = slice(0, stages["set down"].samples[0])
    assert imbalance(reading)[air].max() < CLOSES_IN_THE_AIR * turned_over(reading)


@pytest.mark.parametrize("damper", [f"loader-{i}.hinge.damper" for i in range(1, 7)])
def test_an_omitted_hinge_damper_is_detected_by_the_energy_balance(
    reading: Reading, stages: dict[str, Stage], damper: str
) -> None:
    _noticed(reading, stages, damper)


@pytest.mark.parametrize("rope", ["west.H1", "west.H2", "west.H3", "east.H1", "east.H2", "east.H3"])
def test_an_omitted_rope_damper_is_detected_by_the_energy_balance(
    reading: Reading, stages: dict[str, Stage], rope: str
) -> None:
    _noticed(reading, stages, rope)


@pytest.mark.parametrize("sling", ["loader-3.sling-1", "loader-3.sling-2", "loader-6.sling-1", "loader-6.sling-2"])
def test_an_omitted_sling_of_crane_b_is_detected_by_the_energy_balance(
    reading: Reading, stages: dict[str, Stage], sling: str
) -> None:
    _noticed(reading, stages, sling)


def test_an_omitted_heat_of_dampers_is_detected_by_the_energy_balance(reading: Reading) -> None:
    """The audit of the runner, fed with the recorded rows: with all accounts it closes, without heat it does not."""
    energy, accounts = reading.values["/energy"], reading.values["/account"]
    layout = SampleLayout([
        SampleChannel("energy", reading.names["/energy"], "J", 0, 5),
        SampleChannel("account", reading.names["/account"], "J", 5, 5 + accounts.shape[1]),
    ])  # fmt: skip
    errors = []
    for factor in (1.0, 0.0):
        rows = np.hstack([energy, accounts])
        rows[:, 4] *= factor
        audit = EnergyAudit(layout)
        for part in np.array_split(rows, 100):
            audit.add(part)
        errors.append(audit.error)
    assert errors[0] < CLOSES_ON_THE_WHOLE < errors[1]


def _noticed(reading: Reading, stages: dict[str, Stage], name: str) -> None:
    air = slice(0, stages["set down"].samples[0])
    assert imbalance(reading, without=f"{name}.heat")[air].max() > CLOSES_IN_THE_AIR * turned_over(reading)


def _integral(t: Array, power: Array) -> float:
    return float(np.sum((power[1:] + power[:-1]) / 2 * np.diff(t)))
