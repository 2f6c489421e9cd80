"""A certified run tells each figure with three bars, and what has none; its recording has them, its digest stays."""

from __future__ import annotations

import json
from pathlib import Path

import msgspec
import pytest
from heavylift.coordinator.measured.validation import accuracy
from heavylift.coordinator.run import run
from heavylift.coordinator.tradeoff.playing import play
from heavylift.coordinator.ladder.certificate import Certificate, certifying, richer, tighter
from heavylift.coordinator.uncertainty.figures import figures, recorded
from heavylift.nodes.plan.plan import Fidelity
from heavylift.nodes.scene import load, parse
from heavylift.recordings import Recording
from heavylift.recordings.read.info import info

MASS = "mechanism.bodies.load.mass"


def certified(scene: str, sets: list[str], folder: Path) -> tuple[Certificate, Path, str]:
    """The certificate of a run, its recording, and the digest that the run had before."""
    loaded = load(scene, sets)
    with certifying(loaded, at_once=0) as runs:
        result = run(loaded, folder / "run.mcap", in_process=True)
        return runs.written(result.recording), result.recording, result.digest


def test_a_snatch_has_bars_of_its_steps_and_inputs(tmp_path: Path) -> None:
    found, path, digest = certified("snatch", ["end=2 s", "tolerance=1e-4", f"{MASS}=10 t +- 6 %"], tmp_path)
    peak = found.bars[0]
    exact = play(msgspec.structs.replace(load("snatch", ["end=2 s"]).plan, tolerance=1e-11), 60.0).shown.peaks[0]
    assert (peak.name, peak.unit, peak.model) == ("peak tension fall", "N", None)
    assert peak.numerical is not None
    assert abs(peak.value - exact) <= peak.numerical < 1e-2 * exact
    assert peak.inputs == pytest.approx(0.036 * exact, rel=0.1)
    assert found.missing == {"model": "a mechanism is modelled as it is written, there is no richer rung"}
    line = found.told[0]
    assert line.startswith("peak tension fall: ")
    assert line.endswith(" kN (inputs: mechanism.bodies.load.mass 6 %), no bar (model)")
    rec = Recording(path)
    assert rec.result["digest"] == digest
    assert rec.told("certified") == found.told
    assert json.loads(rec.result["certified"])["bars"][0]["whole"] == peak.whole
    assert f"certified {line}" in info(path)
    assert accuracy(rec) == peak.numerical / peak.value


def test_a_scene_that_states_nothing_says_so(tmp_path: Path) -> None:
    found, _, _ = certified("snatch", ["end=1 s"], tmp_path)
    assert found.told[0].endswith(" kN (numerical), no bar (model, inputs)")
    assert "no uncertainty is stated; write one behind a value" in found.missing["inputs"]
    assert MASS in found.unstated


def test_a_recording_shows_what_a_run_without_one_does(tmp_path: Path) -> None:
    scene = load("tackle", ["end=12 s"])
    path = run(scene, tmp_path / "run.mcap", in_process=True).recording
    seen, right = figures(recorded(scene.plan, Recording(path)), "m"), figures(play(scene.plan, 60.0).shown, "m")
    assert [f.name for f in seen] == [f.name for f in right]
    assert [f.value for f in seen] == pytest.approx([f.value for f in right], rel=1e-7)  # samples are rounded


def test_every_rung_is_judged_by_a_spatial_one() -> None:
    plan = load("lift").plan
    for given, lumps in (
        (Fidelity(ropes="rigid", slings="rigid"), 2),
        (Fidelity(motion="across", locked=("crane.gantry",), pads="standing"), 2),
        (Fidelity(ropes="massive", lumps=2, girder="elastic"), 4),
    ):
        rich = richer(msgspec.structs.replace(plan, fidelity=given, method="radau5"))
        assert rich is not None
        at = rich.fidelity
        assert (at.ropes, at.lumps, at.slings, at.girder) == ("massive", lumps, "elastic", "elastic")
        assert (at.motion, at.locked, at.pads) == ("spatial", (), "all")
        assert rich.method == "dopri5"
    assert richer(load("tackle").plan) is None


def test_steps_are_judged_by_a_method_that_damps_nothing() -> None:
    plan = load("lift", ["method=radau5", "tolerance=1e-3"]).plan
    (tight,) = tighter(plan)
    assert (tight.method, tight.tolerance, tight.step) == ("dop853", 1e-10, None)
    rigid = msgspec.structs.replace(plan, fidelity=Fidelity(ropes="rigid", slings="rigid"))
    assert [x.tolerance for x in tighter(rigid)] == [1e-9, 1e-10]
    assert tighter(load("lift", ["tolerance=1e-11"]).plan) == []
    assert [x.step for x in tighter(load("lift", ["method=rk4", "step=5 ms", "tolerance=1e-11"]).plan)] == [None]


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


def test_rigid_ropes_are_judged_by_two_runs_that_must_agree() -> None:
    scene = parse(RIGID)
    assert [plan.tolerance for plan in tighter(scene.plan)] == [1e-9, 1e-10]
    with certifying(scene, at_once=0) as runs:
        own = figures(play(scene.plan, 60.0).shown, "m")
        assert all(bar.numerical is not None for bar in runs.certificate(own).bars)
        runs._begun[0][0].result()[0][0] = own[0]._replace(value=own[0].value + 0.01 * own[0].scale)
        forked = runs.certificate(own)
    assert forked.bars[0].numerical is None
    assert "two runs with tight steps differ by" in forked.missing["numerical"]


def test_the_price_is_told_with_the_richer_rung() -> None:
    with certifying(load("lift", ["block.mass=300 t +- 3 %"]), at_once=0) as runs:
        told = runs.price
    assert "the same rung at 1e-10 (about " in told
    assert "the next richer rung, 2 lumps a rope (about " in told
    assert "2 runs for 1 uncertain input (about " in told
