"""A run that asks nothing tells its rung and a bound of its error; the richest rung stays within that bound."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.fidelity import lift_of, modelled_as
from heavylift.nodes.scene import load
from heavylift.recordings import Recording
from heavylift.recordings.format.settings import settings


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ([], "girder rigid, ropes without mass"),
        (["fidelity.girder=elastic"], "ropes without mass"),
        (["fidelity.girder=elastic", "fidelity.rope_mass=lumped"], "rope mass lumped at the ends"),
        (["fidelity.girder=elastic", "fidelity.ropes=massive"], "each rope of 4 lumps"),
    ],
)
def test_a_richer_rung_has_a_smaller_bound(given: list[str], told: str) -> None:
    scene, plain = load("lift", given), load("lift")
    found, default = modelled_as(scene.plan, scene.followed), modelled_as(plain.plan, plain.followed)
    assert str(found).endswith(f": {told}")
    assert found.errors["rope tension"] <= default.errors["rope tension"]


def test_where_nothing_can_be_predicted_it_says_so() -> None:
    for name in ("pendulum", "arm"):
        scene = load(name)
        assert str(modelled_as(scene.plan, scene.followed)).endswith(
            "a mechanism is modelled as it is written, no rule looks at it"
        )
    rigid = load("lift", ["fidelity.slings=rigid"])
    assert "error not predicted: no rule looks at rigid slings" in str(modelled_as(rigid.plan, rigid.followed))


def test_the_bound_holds_against_the_richest_rung(tmp_path: Path) -> None:
    plain, rich = load("lift"), load("lift", ["fidelity.girder=elastic", "fidelity.ropes=massive"])
    peaks = [run(s, tmp_path / f"{i}.mcap", in_process=True).peaks for i, s in enumerate((plain, rich))]
    bound = modelled_as(plain.plan, plain.followed).errors["rope tension"]
    for rope in lift_of(plain.plan).rig.hook_ropes:
        (tension, _), (true, _) = (p[rope.name] for p in peaks)
        assert abs(tension / true - 1.0) < bound
    told = settings(Recording(tmp_path / "0.mcap").run)
    assert told == {
        "modelled": str(modelled_as(plain.plan, plain.followed)),
        "steps": "dopri5, integrator's tolerance 1e-06",
    }
