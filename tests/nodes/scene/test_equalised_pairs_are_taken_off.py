"""An equaliser over its sheave parts in the air, or is unhooked when it is slack, and hooked again."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import bundled, parse
from heavylift.recordings import Recording

G = 9.80665
HALL = bundled()["hall"].read_text(encoding="utf-8")
LUGS = "lugs: {A: [-2 m, 2 m, 2 m], "
PAIR = "  pair: {type: equaliser, on: hall main, to: [E, F], length: 12.39 m, radius: 0.3 m, sling: {EA: 120 MN}}\n"


def scene(*orders: str) -> str:
    """The hall's machine under its four slings and an equalised pair, lifted; then these orders."""
    text = HALL.replace(LUGS, f"{LUGS}E: [-2.5 m, 0 m, 2 m], F: [2.5 m, 0 m, 2 m], ", 1)
    text = text.split("  - stage: up")[0].replace("\nactions:", f"{PAIR}\nactions:", 1)
    return text.replace("until all slings taut", "until lifted", 1) + "".join(f"  - {x}\n" for x in orders)


def test_when_a_sling_pair_parts_its_load_goes_to_the_neighbouring_slings(tmp_path: Path) -> None:
    """Each of four slings of 6 m to lugs 2.83 m aside carries a quarter at its slant; of the pair nothing is left."""
    lift = parse(scene("hall: hoist 4 m/min by 0.3 m", "pair: release", "wait: 2 s"), passing=True)
    before, after = (next(s for s in reversed(lift.statics.states) if s.action == n) for n in (3, 4))
    slant = (1.0 - (8.0**0.5 / 6.0) ** 2) ** 0.5
    assert before.tensions["pair.sling-1"] > 1e4
    assert after.tensions["pair.sling-1"] == 0.0
    for i in range(1, 5):
        assert after.tensions[f"legs.sling-{i}"] == pytest.approx(80e3 * G / 4 / slant, rel=2e-3)
    run(lift, tmp_path / "run.mcap", in_process=True)
    done = Recording(tmp_path / "run.mcap")
    last = dict(zip(done.signal("rope/tension").names, done.signal("rope/tension").values[-1], strict=True))
    assert last["legs.sling-1"] == pytest.approx(after.tensions["legs.sling-1"], rel=0.2)
    assert (done.signal("reeving/tension").values[-1] == 0.0).all()


def test_a_parted_sling_pair_can_be_hooked_again() -> None:
    down = "hall: lower 0.5 m/min until landed and all slings slack"
    up = "hall: hoist 0.5 m/min until lifted"
    lift = parse(scene(down, "pair: unhook", "pair: hook", up), passing=True)
    states = lift.statics.states
    first, again = (next(s.tensions for s in reversed(states) if s.action == n) for n in (1, 6))
    assert again == pytest.approx(first, rel=1e-6)
    assert again["pair.sling-1"] > 1e5
