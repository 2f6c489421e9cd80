"""Lugs, slings, supports and wheels in the planner's document: each from statics."""

from __future__ import annotations

from math import degrees, radians
from pathlib import Path

import msgspec
import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from heavylift.recordings import Recorder, Recording, RopeLine, SampleChannel, SampleLayout
from heavylift.recordings.documents import Facts, block_rows, facts, tables_of
from small_run import POSE, SECOND

G = 9.80665


@pytest.fixture(scope="module")
def lift(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("lift") / "lift.mcap"
    run(load("lift", ["end=60 s"]), path, in_process=True)
    return path


@pytest.fixture(scope="module")
def found(lift: Path) -> Facts:
    return facts(Recording(lift))


def test_a_lug_carries_the_force_of_its_sling(found: Facts) -> None:
    peaks = {name: peak.tension for name, peak in found.peaks.items()}
    hooked = {lug: sling.name for sling in found.loads.slings for lug in sling.lugs}
    assert hooked == {f"{lug}{i}": f"loader-{n}.sling-{i}" for n, lug in ((1, "P"), (2, "Q"), (3, "R")) for i in (1, 2)}
    for lug in found.loads.lugs:
        assert lug.force == pytest.approx(peaks[hooked[lug.name]], rel=1e-9)
        assert lug.parts is not None
        assert np.linalg.norm(lug.parts) == pytest.approx(lug.force)
        assert lug.parts[2] > 0.999 * lug.force, "upwards"


def test_supports_carry_the_block(found: Facts) -> None:
    supports = {x.name: x.force for x in found.loads.supports}
    weight = 300e3 * G
    assert supports["all together"] == pytest.approx(weight, rel=1e-3), "before the ropes are taut"
    assert supports["block.lower-1"] == pytest.approx(weight / 4, rel=1e-3)


def test_each_stage_reports_the_position_of_the_block(found: Facts) -> None:
    first, *_, last = found.stages
    assert first.com == pytest.approx((40.0, 75.0, 5.995), abs=0.01)
    assert last.com is not None
    assert last.com[2] == pytest.approx(7.03, abs=0.02)
    assert last.tilt is not None
    assert 0.0 < degrees(last.tilt[1]) < 0.2
    assert ("centre of gravity at u, v, w", [0.0, 0.0, 0.0], "m") in block_rows(found.plan)


def turned_block(folder: Path, angle: float) -> Path:
    """A block that is turned about x by an angle and hangs on one sling at 30 degrees to the vertical; no peak between
    its samples is recorded."""
    names = ["sling"]
    layout = SampleLayout(
        [SampleChannel("rope/tension", names, "N", 0, 1), SampleChannel("rope/peak", names, "N", 1, 2)]
        + [SampleChannel(f"pose/{body}", POSE, "m", 2 + 7 * i, 9 + 7 * i) for i, body in enumerate(("block", "beam"))]
    )
    c, s = np.cos(angle / 2), np.sin(angle / 2)
    lug = np.array([0.0, -np.sin(angle) * 2.0, np.cos(angle) * 2.0])  # (0, 0, 2) in the block
    beam = lug + 10.0 * np.array([0.5, 0.0, np.cos(radians(30))])
    row = np.array([1e5, 0, 0, 0, 0, s, 0, 0, c, *beam, 0, 0, 0, 1])
    plan = {
        "gravity": G,
        "machines": [
            {"name": "block", "ties": [{"rope": "sling", "lug": "L"}],
             "cargo": [{"body": "block", "mass": 9e3, "com": [0, 0, 1], "lugs": {"L": [0.0, 0.0, 2.0]}}],
             "system": {"joints": [{"child": "block", "q0": [0, 0, 0, 0, 0, 0, 1]}]}},
        ],
    }  # fmt: skip
    with Recorder(folder / "turned.mcap", {"scene": "turned"}, {"resolved.json": msgspec.json.encode(plan)}) as rec:
        rec.layout(layout)
        rec.ropes(0, [RopeLine("sling", "beam", (0, 0, 0), "block", (0.0, 0.0, 2.0))])
        rec.samples(msgspec.msgpack.encode([0, [0, SECOND], np.stack([row, row]).tobytes()]))
        return rec.close()


@pytest.mark.parametrize("turn", [0, 40, 90, 180])
def test_the_force_on_a_lug_is_reported_along_the_axes_of_a_turned_block(tmp_path: Path, turn: int) -> None:
    found = facts(Recording(turned_block(tmp_path, radians(turn))))
    (lug,), (sling,) = found.loads.lugs, found.loads.slings
    up = 1e5 * np.cos(radians(30))
    assert lug.parts == pytest.approx((5e4, up * np.sin(radians(turn)), up * np.cos(radians(turn))), abs=1.0)
    assert degrees(sling.angle) == degrees(sling.widest) == pytest.approx(30.0, abs=1e-6)


def test_a_force_that_rounds_to_nothing_has_no_sign(tmp_path: Path) -> None:
    """Turned a little further than half round, the block's v axis points down by a millionth."""
    rec = Recording(turned_block(tmp_path, radians(180.0 + 1e-4)))
    assert -1.0 < facts(rec).loads.lugs[0].parts[1] < 0.0
    (lugs,) = (table for table in tables_of(facts(rec)) if table.title == "Loads on lugs")
    shown = [column.text(cell) for column, cell in zip(lugs.columns, lugs.rows[0], strict=True)]
    assert shown[-3:] == ["50.0", "0.0", "-86.6"]
