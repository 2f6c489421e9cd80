"""Clearances to the ground: what is carried, lifted off, set down, or hangs empty; between samples, too."""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.coordinator.verdict import History, findings
from heavylift.coordinator.verdict.clearances import clearances
from heavylift.nodes.scene import bundled, parse
from heavylift.recordings.read import Clearance
from lifting import machine, slings, unstated
from numpy.typing import NDArray

Floats = NDArray[np.float64]
STOOL, HALF = 0.2, 4.0  # [m]
LOW = (
    unstated(bundled()["lift"].read_text()).replace("at: [40 m, 75 m, 6 m]", "at: [40 m, 75 m, 4.2 m]")
    .replace("height: 2 m", "height: 0.2 m")
)  # fmt: skip
PLAN = parse(LOW).plan
TAUT, SLACK = 1e5, 0.0
EXACT = 1e-3
FINE = 20  # samples per second


def went(z: list[float], y: list[float] | None = None, roll: list[float] | None = None) -> dict[str, Floats]:
    """The block's middle at its samples, turned by `roll` [rad] about x; the trolleys go with it."""
    n = FINE * (len(z) - 1) + 1
    y, z, roll = (np.interp(np.arange(n), FINE * np.arange(len(z)), x or [0.0] * len(z)) for x in (y, z, roll))
    block = np.zeros((n, 7))
    block[:, 1], block[:, 2], block[:, 3], block[:, 6] = y, z, np.sin(roll / 2), np.cos(roll / 2)
    trolley = np.zeros((n, 7))
    trolley[:, 1], trolley[:, 2], trolley[:, 6] = block[:, 1], 80.0, 1.0
    return {"block": block, "crane.upper": trolley, "crane.lower": trolley}


def near(poses: dict[str, Floats], sling: float = TAUT, **more: list[tuple[float, float]]) -> list[Clearance]:
    n = len(next(iter(poses.values())))
    t = np.arange(n) / FINE
    history = History(t, poses, {name: np.full(n, sling) for name in slings(PLAN)}, {}, [])
    return [c for c in clearances(PLAN, history, **more) if c.b == "ground"]


def told(*args: object, **more: object) -> list[str]:
    return [f.sentence.partition(" (")[0] for f in findings(near(*args, **more))]  # type: ignore[arg-type]


STANDS = HALF + STOOL
UP = [STANDS, STANDS, STANDS + 0.1, STANDS + 0.4, STANDS + 1.0, STANDS + 2.0]


def test_a_block_gives_no_ground_clearance_finding_while_it_is_lifted_off_or_set_down() -> None:
    there = UP + UP[::-1]
    assert told(went(there)) == []
    assert told(went(there, [0.0] * 6 + [9.0] * 6)) == [], "it is set down elsewhere"
    swings = {**went(UP), "block": went(UP, [0.0, 0.0, 1.2, 1.2, 0.0, 0.0])["block"]}
    assert told(swings) == [], "it swings as it leaves its supports, nobody carries it"


def test_a_load_carried_too_close_to_the_ground_gives_a_red_check_with_its_place() -> None:
    (red,) = findings(near(went([*UP, STANDS + 0.1, *UP[4:]], [0.0] * 3 + [3.0 * i for i in range(6)])))
    assert (red.subject, red.t, red.value) == ("block and ground", 6.0, pytest.approx(STOOL + 0.1, abs=0.05))
    assert "of the ground, 0.5 m are to be kept (block at u, v, w = " in red.sentence
    low = [STANDS] * 2 + [STANDS + 0.15] * 9 + [STANDS] * 2
    assert told(went(low, [0.0] * 3 + [1.5 * i for i in range(8)] + [10.5] * 2)) != [], "all the way at 0.35 m"
    assert told(went(low)) == [], "up and down in its place"


def test_ground_clearance_is_checked_along_the_path_but_not_at_pick_up_and_set_down() -> None:
    """Not that of the last sample before it counts as being set down."""
    y = [0.0] * 6 + [3.0 * i for i in range(1, 5)] + [12.0] * 6
    (found,) = (c for c in near(went([*UP, *[STANDS + 2.0] * 4, *UP[::-1]], y)) if c.a == "block")
    assert (found.distance, found.limit) == (pytest.approx(STOOL + 2.0, abs=EXACT), 0.5)


def test_low_ground_clearance_gives_no_finding_during_an_order_to_land() -> None:
    down = [STANDS + 2.0 - 0.2 * i for i in range(10)]
    assert len(told(went(down))) == 1
    assert told(went(down), landing=[(4.0, 9.0)]) == []


def test_penetration_of_the_ground_gives_a_red_check_for_every_body() -> None:
    tips = went([STANDS] * 9, roll=[0.02 * i for i in range(9)])
    edge = (8.0 - 6.0) * np.sin(0.16) - STOOL  # below the pad at 6 m, which stands on its support
    assert told(tips) == [f"the block went {edge:.2f} m into the ground"]
    assert told(went([STANDS - 0.05] * 3)) == [], "the supports yield"


def test_the_lower_bound_of_the_ground_clearance_between_samples_accounts_for_rotation() -> None:
    """A box of 16 m by 8 m that rolls is lowest with its diagonal upright, here between two samples."""
    upright, step, height = np.arctan2(8.0, HALF), np.radians(8.0), 10.0
    rolls = np.array([upright + (i - 4.5) * step for i in range(10)])
    pose = np.zeros((10, 7))
    pose[:, 2], pose[:, 3], pose[:, 6] = height, np.sin(rolls / 2), np.cos(rolls / 2)
    (found,) = near({"block": pose})
    lowest = height - np.hypot(8.0, HALF)
    seen = height - np.hypot(8.0, HALF) * np.cos(step / 2)
    assert lowest - 0.1 < found.distance <= lowest < seen


def hook(z: float, sling: float) -> list[Clearance]:
    pose = np.tile([0.0, 0.0, z, 0.0, 0.0, 0.0, 1.0], (3, 1))
    return near({"loader-1.upper": pose}, sling)


def test_an_empty_hook_may_be_near_the_ground_but_not_below_the_ground() -> None:
    below = -machine(PLAN, "loader-1").system.joints[1].p_PJ[2]  # of the hook block
    assert hook(below + 0.2, SLACK) == []
    (loaded,) = hook(below + 0.2, TAUT)
    assert (loaded.a, loaded.limit) == ("loader-1", 0.5)
    assert loaded.distance == pytest.approx(0.2, abs=EXACT)
    (through,) = hook(below - 0.3, SLACK)
    assert (through.limit, through.distance) == (0.0, pytest.approx(-0.3, abs=EXACT))
    assert findings([through])[0].state == "red"
