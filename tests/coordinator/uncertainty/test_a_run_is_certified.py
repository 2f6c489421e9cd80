"""A certified run tells each figure with three bars, and what has none; its recording has them, its digest stays."""

from __future__ import annotations

import json
from pathlib import Path

import msgspec
import pytest
from heavylift.coordinator.ladder import Ladder, ModelLevel, tighter
from heavylift.coordinator.measured import accuracy
from heavylift.coordinator.record import play
from heavylift.coordinator.run import run
from heavylift.coordinator.uncertainty import Certificate, certifying
from heavylift.nodes.plan import ASKABLE, Fidelity
from heavylift.nodes.scene import load, parse
from heavylift.recordings import Recording
from heavylift.recordings.read import info

MASS = "mechanism.bodies.load.mass"


def certified(scene: str, sets: list[str], folder: Path) -> tuple[Certificate, Path, str]:
    """The certificate of a run, its recording, and the digest that the run had before."""
    loaded = load(scene, sets)
    with certifying(loaded, at_once=0) as runs:
        result = run(loaded, folder / "run.mcap", in_process=True)
        return runs.written(result.recording), result.recording, result.digest


def test_the_certificate_of_a_snatched_load_estimates_the_errors_due_to_time_steps_and_inputs(tmp_path: Path) -> None:
    found, path, digest = certified("snatch", ["end=2 s", "tolerance=1e-4", f"{MASS}=10 t +- 6 %"], tmp_path)
    peak = found.bars[0]
    exact = play(msgspec.structs.replace(load("snatch", ["end=2 s"]).plan, tolerance=1e-11)).peaks["fall"].tension
    assert (peak.name, peak.unit, peak.model) == ("peak tension fall", "N", None)
    assert peak.numerical is not None
    assert abs(peak.value - exact) <= peak.numerical < 1e-2 * exact
    assert peak.inputs == pytest.approx(0.036 * exact, rel=0.1)
    assert found.missing == {"model": "it is modelled as it is written, there is no finer level"}
    line = found.message[0]
    assert line.startswith("peak tension fall: ")
    assert line.endswith(" kN (inputs: mechanism.bodies.load.mass 6 %), no error estimate (model)")
    rec = Recording(path)
    assert rec.result["digest"] == digest
    assert rec.message("certified") == found.message
    assert json.loads(rec.result["certified"])["bars"][0]["whole"] == peak.whole
    assert f"certified {line}" in info(path)
    assert accuracy(rec) == peak.numerical / peak.value


def test_the_certificate_of_a_lift_estimates_the_errors_of_forces_and_positions_and_stage_times(
    tmp_path: Path,
) -> None:
    found, _, _ = certified("lift", ["end=40 s"], tmp_path)
    assert {bar.quantity for bar in found.bars} >= {*ASKABLE} - {"swing"}
    assert all(bar.numerical is not None and bar.model is not None for bar in found.bars)
    assert sum(line.startswith("use of ") for line in found.message) == 1  # the largest; all are in its data


def test_a_certificate_of_errors_states_that_the_scene_gives_no_uncertainties(tmp_path: Path) -> None:
    found, _, _ = certified("snatch", ["end=1 s"], tmp_path)
    assert found.message[0].endswith(" kN (numerical), no error estimate (model, inputs)")
    assert "no uncertainty is stated; write one behind a value" in found.missing["inputs"]
    assert MASS in found.unstated


def test_a_model_level_is_compared_with_levels_that_model_every_effect_it_omits() -> None:
    ladder = Ladder(load("lift").plan)
    for given, lumps in (
        (Fidelity(ropes="rigid", slings="rigid"), 2),
        (Fidelity(motion="across", locked=("crane.gantry",), pads="standing"), 2),
        (Fidelity(ropes="massive", lumps=2, rope_mass="lumped", girder="elastic"), 4),
    ):
        at = ladder.witnesses(given)[0]
        assert (at.ropes, at.lumps, at.slings, at.girder) == ("massive", lumps, "elastic", "elastic")
        assert (at.motion, at.locked, at.pads) == ("spatial", (), "all")
    assert not Ladder(load("tackle").plan).witnesses(load("tackle").plan.fidelity)


def test_model_level_errors_are_measured_with_radau5_whatever_method_the_scene_sets() -> None:
    for named in ["method=dopri5", "method=rk4"]:
        candidate = ModelLevel(load("lift", [named, *["step=5 ms"] * ("rk4" in named)]).plan)
        own = Ladder(candidate.plan).in_own_steps(candidate)
        assert (own.plan.fidelity, own.plan.method, own.plan.step) == (candidate.plan.fidelity, "radau5", None)
        assert Ladder(own.plan).in_own_steps(own) == own


def test_the_error_of_a_tolerance_is_measured_against_a_tighter_one_of_the_same_method() -> None:
    plan = load("lift", ["method=radau5", "tolerance=1e-3"]).plan
    (tight,) = tighter(ModelLevel(plan))
    assert (tight.plan.method, tight.plan.tolerance, tight.plan.step) == ("radau5", pytest.approx(1e-4), None)
    rigid = msgspec.structs.replace(plan, fidelity=Fidelity(ropes="rigid", slings="rigid"))
    assert [x.plan.tolerance for x in tighter(ModelLevel(rigid))] == pytest.approx([1e-4, 1e-5])
    halved = tighter(ModelLevel(load("lift", ["method=rk4", "step=5 ms"]).plan))
    assert [x.plan.step for x in halved] == [0.0025]


RIGID = """
heavylift: 1
name: snatched
end: 2 s
samples: 50 Hz
mechanism:
  bodies:
    load: {mass: 10 t}
  joints:
    guide: {type: prismatic, child: load, axis: [0, 0, 1], start: -29.5 m}
  ropes:
    fall: {start: {body: world}, end: {body: load}, length: 30 m, rigid: true}
"""


def test_time_step_errors_of_rigid_ropes_are_measured_by_two_runs_with_tighter_steps() -> None:
    scene = parse(RIGID)
    assert len(tighter(ModelLevel(scene.plan))) == 2
    with certifying(scene, at_once=0) as runs:
        assert all(bar.numerical is not None for bar in runs.certificate().bars)


def test_the_option_certify_announces_the_number_of_runs_and_the_finer_model_levels() -> None:
    with certifying(load("lift", ["block.mass=300 t +- 3 %", "ask=[]"]), at_once=0) as runs:
        message = runs.price
    assert "2 for the steps, 2 for the model, one with ropes of 2 lumps, elastic girder" in message
    assert "2 for 1 uncertain input" in message
