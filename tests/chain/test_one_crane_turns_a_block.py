"""One crane turns a block over: shares at every angle from lever arms alone, as in the turn by two cranes."""

from __future__ import annotations

from math import acos, cos, degrees, sin

import pytest
from heavylift.nodes.scene import LoadedScene, load

LOAD, A, B_V, B_W = 400e3 * 9.80665, -14.6, 12.0, 5.6  # [N]; lugs from the centre of mass [m]
SHARE = 0.002  # of the load


@pytest.fixture(scope="module")
def turned() -> LoadedScene:
    return load("single-turn")


def test_load_shares_of_a_block_turned_by_one_crane_follow_its_lever_arms(turned: LoadedScene) -> None:
    """The lug of H3 stands b = v cos + w sin from the centre of mass, those of H1 and H2 a: H3 carries a / (a - b)."""
    seen = []
    for state in turned.statics.states:
        if not state.stage.startswith("turn to") or state.grounded:
            continue
        R = state.poses["block"][1]
        angle = acos(max(-1.0, min(1.0, R[2][2])))  # 0 to 180 degrees, as written in the plan
        w = B_W if angle < acos(0.0) else -B_W
        a, b = A * cos(angle), B_V * cos(angle) + w * sin(angle)
        on_b = sum(T for name, T in state.tensions.items() if name.startswith("loader-3."))
        assert on_b / LOAD == pytest.approx(-a / (b - a), abs=SHARE)
        seen.append(degrees(angle))
    assert min(seen) < 1.0
    assert max(seen) > 179.0
    assert any(80.0 < angle < 90.0 for angle in seen)


def test_a_block_turned_over_by_one_crane_lies_on_its_former_top_face_at_the_end(turned: LoadedScene) -> None:
    assert turned.statics.known
    last = turned.statics.states[-1]
    assert last.grounded
    assert last.poses["block"][1][2][2] == pytest.approx(-1.0, abs=1e-6)
    assert all(T == 0.0 for name, T in last.tensions.items() if ".sling-" in name)
