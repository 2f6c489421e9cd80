"""Sample rows of lifts on every model level equal stored digests."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import msgspec
import pytest
from heavylift.coordinator.record import play
from heavylift.nodes.plan import Plan
from heavylift.nodes.scene import load

STORED = Path(__file__).parents[2] / "data" / "rows_by_level.json"
LEVELS = (
    "{ropes: rigid, slings: rigid}",
    "{slings: rigid}",
    "{girder: elastic}",
    "{rope mass: lumped}",
    "{ropes: rigid, rope mass: lumped, pads: standing}",
    "{ropes: massive, lumps: 2, girder: elastic}",
    "{ropes: massive, lumps: 3, girder: elastic, motion: across}",
    "{locked: [hinges, gantries]}",
)
SCENES = ("lift", "tandem")


def level(scene: str, fidelity: str) -> Plan:
    """The first seconds of a bundled lift on a level."""
    return msgspec.structs.replace(load(scene, [f"fidelity={fidelity}"]).plan, end=6.0)


def rows(scene: str, fidelity: str) -> str:
    run = play(level(scene, fidelity))
    return hashlib.sha256(run.times.tobytes() + run.rows.tobytes()).hexdigest()[:16]


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.large(beyond=1)
def test_each_model_level_of_a_scene_reproduces_its_stored_sample_rows(scene: str) -> None:
    stored = json.loads(STORED.read_text(encoding="utf-8"))[scene]
    assert {fidelity: rows(scene, fidelity) for fidelity in LEVELS} == stored
