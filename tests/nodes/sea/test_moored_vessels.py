"""A barge on catenary lines: it rests where its lines balance, they are checked and drawn, and one is cast off."""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.coordinator.record import RopeLines
from heavylift.nodes.limits import uses_on_path
from heavylift.nodes.models import system
from heavylift.nodes.scene import LoadedScene, parse
from heavylift.nodes.statics import StaticState, follow

BREAKING = 6e6
SCENE = """
heavylift: 1
name: moored
end: 60 s
vessels:
  barge:
    mass: 14432 t
    type: barge-110
    com: [0 m, 0 m, 2 m]
mechanism:
  name: mooring
  forces:
"""
ACTIONS = """
actions:
  - stage: moored
    wait: 10 s
  - stage: cast off
    fore-port: release
"""
LINE = (
    "    %s-%s: {type: mooring line, start: {body: world, at: [%d m, %d m, -60 m]},"
    " end: {body: barge, at: [%d m, %d m, 2 m]}, length: 500 m, EA: 600 MN, mass: 130 kg/m, breaking: 6 MN}\n"
)


@pytest.fixture(scope="module")
def moored() -> LoadedScene:
    """Four lines, each to one corner."""
    ends = [(f, p, x, y) for f, x in (("fore", 1), ("aft", -1)) for p, y in (("port", 1), ("starboard", -1))]
    return parse(SCENE + "".join(LINE % (f, p, 455 * x, 300 * y, 55 * x, 14 * y) for f, p, x, y in ends) + ACTIONS)


@pytest.fixture(scope="module")
def states(moored: LoadedScene) -> list[StaticState]:
    return list(follow(moored.plan).states)


def test_equal_mooring_lines_carry_equal_loads_at_rest_and_a_line_that_is_cast_off_carries_none(
    states: list[StaticState],
) -> None:
    names = [f"{f}-{p}" for f in ("fore", "aft") for p in ("port", "starboard")]
    first = [states[0].tensions[name] for name in names]
    assert first == pytest.approx([first[0]] * 4, rel=1e-6)
    assert states[-1].tensions["fore-port"] == 0.0
    assert min(states[-1].tensions[name] for name in names[1:]) > 0.0


def test_each_mooring_line_has_a_limit_of_half_its_breaking_load(
    moored: LoadedScene, states: list[StaticState]
) -> None:
    uses = uses_on_path(moored.plan, states)
    rows = [x for x in uses if x.limit.quantity == "rope tension"]
    assert len(rows) == 4
    for row in rows:
        assert row.use == pytest.approx(row.value / (BREAKING / 2.0))


def test_a_mooring_line_is_drawn_as_its_catenary_from_anchor_to_fairlead(moored: LoadedScene) -> None:
    drawn = [x for x in RopeLines([system(moored.plan)]).drawn() if x.rope == "fore-port"]
    assert drawn[0].a == (455.0, 300.0, -60.0)
    assert (drawn[-1].b_body, drawn[-1].b) == ("barge", (55.0, 14.0, 2.0))
    points = np.array([x.a for x in drawn])
    assert (np.diff(points[:, 2]) >= -1e-9).all(), "it rises from the anchor to the fairlead"
    assert points[1, 2] == pytest.approx(-60.0, abs=1e-9), "its first part lies"
