"""A block that meets an obstacle by its corners alone: what stands between them is red once the boxes overlap."""

from __future__ import annotations

from pathlib import Path
from random import Random

import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.coordinator.verdict import TOUCH, History, findings
from heavylift.coordinator.verdict.clearances import clearances
from heavylift.kernel import SceneError
from heavylift.nodes.scene import parse
from heavylift.recordings import Recording

MEANT = [(frozenset(("block", "plinth")), -np.inf, np.inf)]
LUGS = "lugs: {A: [-2 m, 2 m, 2 m], B: [2 m, 2 m, 2 m], C: [-2 m, -2 m, 2 m], D: [2 m, -2 m, 2 m]}"
STOOLS = "supports: {height: 0.5 m, at: [[-2 m, -2 m], [2 m, -2 m], [-2 m, 2 m], [2 m, 2 m]]}"
PLINTH = 1.5  # height [m]
LOWERED = 1.0  # by the winch after it has landed [m]
STOPS = 0.02  # [m] the gap at which it stops, what the winch still runs and the slings, which get shorter or slack
RUBS = 5e-3  # [m] of a block that stands on rigid contacts
TEXT = f"""\
heavylift: 1
name: sinks
accuracy: 0.1 %
block: {{mass: 40 t, size: [10 m, 10 m, 4 m], at: [0 m, 8 m, 2.5 m], {LUGS}, {STOOLS}}}
cranes: {{hall: {{type: overhead-100, at: 0 m, trolley: 8 m}}}}
rigging: {{legs: {{on: hall main, to: [A, B, C, D], length: 6 m, sling: {{EA: 120 MN}}}}}}
obstacles: {{plinth: {{box: [4 m, 4 m, 1.5 m], at: [0 m, 20 m, 0.75 m], friction: 0.3, meets: lower corners}}}}
actions:
  - hall: hoist 1 m/min until lifted
  - hall: hoist 4 m/min by 2 m
  - hall traversing: traverse 15 m/min ramp one swing by 12 m
  - hall: lower 1 m/min until landed on plinth
  - hall: lower 1 m/min by {LOWERED:g} m
"""


def test_contact_with_a_plinth_smaller_than_a_block_is_reported_even_if_only_corners_make_contact(
    tmp_path: Path,
) -> None:
    """Ten metres on four: it hangs on and is 1 m deep, as far as it was lowered after it had landed."""
    result = run(parse(TEXT, passing=True), tmp_path / "run.mcap", in_process=True)
    assert result.verdict is not None
    assert result.verdict.red
    (red,) = [f for f in result.verdict.findings if f.quantity == "clearance"]
    assert (red.word, red.subject) == ("red", "block and plinth")
    assert red.value == pytest.approx(-LOWERED, abs=STOPS)
    assert red.sentence.startswith("the block went ")
    assert red.sentence.endswith("write 'meets: boxes'")
    assert red.t == pytest.approx(Recording(tmp_path / "run.mcap")["pose/block"].t[-1], abs=2.0)


def test_a_block_with_box_contacts_stands_on_a_plinth_smaller_than_itself(tmp_path: Path) -> None:
    """Two metres above the plinth's top is its middle."""
    boxes = TEXT.replace("lower corners", "boxes")
    result = run(parse(boxes, passing=True), tmp_path / "run.mcap", in_process=True)
    z = Recording(tmp_path / "run.mcap")["pose/block"].values[-1, 2]
    assert z == pytest.approx(PLINTH + 2.0, abs=RUBS)
    assert result.verdict is not None
    assert not result.verdict.red


@pytest.mark.parametrize("meets", ["corners", "lower corners"])
@pytest.mark.parametrize("overlap", [0.0, 0.3])
def test_an_overlap_of_random_boxes_gives_a_red_check_exactly_if_it_is_deeper_than_allowed(
    meets: str, overlap: float
) -> None:
    """Along the axes the overlap is the least of three; it is red if it is deeper than what touches and is meant."""
    draw, reds = Random(f"{meets} {overlap}"), 0
    for _ in range(40):
        own = [draw.uniform(1.0, most) for most in (12.0, 12.0, 5.0)]
        other = [draw.uniform(0.2, 12.0) for _ in range(3)]
        at = [draw.uniform(-0.6, 0.6) * (a + b) for a, b in zip(own, other, strict=True)]
        size = f"box: [{other[0]} m, {other[1]} m, {other[2]} m], at: [0 m, 0 m, 50 m]"
        text = f"{TEXT.partition('actions')[0]}end: 1 s\n".replace(
            "[10 m, 10 m, 4 m], at: [0 m, 8 m, 2.5 m]",
            f"[{own[0]} m, {own[1]} m, {own[2]} m], at: [0 m, 8 m, {0.5 + own[2] / 2} m]",
        )
        u, v = own[0] / 4, own[1] / 4
        stools = f"[[{-u} m, {-v} m], [{u} m, {-v} m], [{-u} m, {v} m], [{u} m, {v} m]]"
        text = text.replace("[[-2 m, -2 m], [2 m, -2 m], [-2 m, 2 m], [2 m, 2 m]]", stools)
        text = text.replace("box: [4 m, 4 m, 1.5 m], at: [0 m, 20 m, 0.75 m]", f"overlap: {overlap} m, {size}")
        lugs = LUGS.replace("2 m]", f"{own[2] / 2} m]").replace("-2 m", f"{-own[0] / 9} m")
        plan = parse(text.replace("lower corners", meets).replace(LUGS, lugs), passing=True, followed=False).plan
        deep = min((a + b) / 2 - abs(x) for a, b, x in zip(own, other, at, strict=True))
        places = {"block": (at[0], at[1], 50.0 + at[2]), "plinth": (0.0, 0.0, 50.0)}
        poses = {body: np.tile([*p, 0.0, 0.0, 0.0, 1.0], (3, 1)) for body, p in places.items()}
        near = findings(clearances(plan, History(np.arange(3.0), poses, {}, {}, []), meant=MEANT), plan)
        found = [f for f in near if f.value is not None and f.value < 0.0]  # what comes near is red besides
        assert [f.value for f in found] == ([pytest.approx(-deep, abs=1e-3)] if deep > overlap + TOUCH else [])
        reds += bool(found)
    assert 0 < reds < 40, "of both kinds"


def test_stating_an_allowed_overlap_for_box_contacts_is_refused() -> None:
    with pytest.raises(SceneError, match=r"scene\.yaml:7:.*'overlap' does not apply to whole boxes"):
        parse(TEXT.replace("lower corners", "boxes, overlap: 0.1 m"), passing=True)
