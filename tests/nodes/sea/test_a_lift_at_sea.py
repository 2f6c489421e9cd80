"""A lift by a crane on a barge in an irregular sea: one digest wherever it runs; one seed is never green."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.coordinator.ladder import play
from heavylift.coordinator.run import Beginning, run
from heavylift.coordinator.run.resume import resume
from heavylift.nodes.limits import checks_of
from heavylift.nodes.scene import LoadedScene, load, parse
from heavylift.nodes.scenes import bundled

SEA = """\
seed: %d
accuracy: 5%%
end: 60 s
waves: {heading: 150 deg, ramp: 20 s, seas: {wind: {Hs: 0.8 m, Tp: 7 s, spreading: 4, components: 50},
                                             swell: {Hs: 0.3 m, Tp: 12 s, heading: 90 deg, components: 20}}}
vessels:
  barge:
    mass: 13716 t
    size: [110 m, 32 m, 8 m]
    draught: 4 m
    com: [0 m, 0 m, 1 m]
    motion: forces
    floating: {hydrodynamics: barge-110, mooring: {surge: 400 kN/m, sway: 400 kN/m, yaw: 400 MN m/rad}}

"""


def lift(seed: int = 1) -> LoadedScene:
    """The bundled lift from a barge, in an irregular sea."""
    text = bundled()["floating"].read_text()
    return parse(text[: text.index("waves:")] + SEA % seed + text[text.index("practice:") :])


@pytest.fixture(scope="module")
def digest() -> str:
    return play(lift().plan).digest


def test_another_seed_of_the_sea_gives_another_run(digest: str) -> None:
    assert play(lift(2).plan).digest != digest


def test_the_digest_of_a_lift_at_sea_is_equal_in_one_process_and_in_several(digest: str, tmp_path: Path) -> None:
    for name, in_process in (("one", True), ("many", False)):
        assert run(lift(), tmp_path / f"{name}.mcap", in_process=in_process).digest == digest


def test_an_interrupted_run_at_sea_is_resumed(digest: str, tmp_path: Path) -> None:
    """It repeats the part that was recorded, with the states of the water, and continues."""
    whole = tmp_path / "whole.mcap"
    run(lift(), whole, in_process=True)
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole.read_bytes()[: whole.stat().st_size * 3 // 4])
    assert resume(cut, Beginning.of(cut), in_process=True).digest == digest


def test_a_single_seed_of_a_sea_does_not_make_a_verdict_green() -> None:
    (row,) = [x for x in checks_of(lift().plan, [], [], None, []) if x.quantity == "sea state"]
    assert (row.state, row.why) == ("amber", "not checked")
    assert not [x for x in checks_of(load("floating").plan, [], [], None, []) if x.quantity == "sea state"]
