"""During a turn trolleys and winches follow the lugs on their slings: the table of the scene `turnover`."""

from math import radians

import msgspec
import pytest
from heavylift.kernel import ModelError
from heavylift.nodes.models.commander import first_lugs, followers
from heavylift.nodes.plan import Follow, Plan
from yard import turnover

FIRST = [(0, 61.0, 19.4, -14.6, 12.0), (30, 53.7, 26.1, -12.64, 13.19), (60, 48.4, 32.6, -7.30, 10.85)]
FIRST += [(85, 46.5, 36.5, -1.27, 6.62), (90, 46.4, 37.0, 0.0, 5.6)]
SECOND = [(90, 46.4, 37.0, 0.0, -5.6), (120, 48.4, 32.6, 7.30, -10.85), (180, 61.0, 19.4, 14.6, -12.0)]


def laws(plan: Plan, lugs: dict[str, str]) -> dict[str, Follow]:
    return {f.actuator: f for f in followers(plan.machines, lugs)}


def way(f: Follow, a: float, b: float) -> float:
    return f.value(b) - f.value(a)


def half(lug: str) -> dict[str, str]:
    return {sling: name.replace("B", lug) for sling, name in first_lugs(turnover().machines).items()}


@pytest.mark.parametrize(("lug", "table"), [("B", FIRST), ("B'", SECOND)])
def test_the_turn_law_gives_the_tabulated_rope_lengths_and_trolley_positions(
    lug: str, table: list[tuple[float, ...]]
) -> None:
    found, first = laws(turnover(), half(lug)), table[0]
    for row in table:
        a, b = radians(first[0]), radians(row[0])
        for crane in ("west", "east"):
            names = (f"{crane}.H2", f"{crane}.H3", f"{crane}.upper-slide.drive", f"{crane}.lower-slide.drive")
            for i, name in enumerate(names, 1):
                assert first[i] + way(found[name], a, b) == pytest.approx(row[i], abs=0.06)


def test_during_a_turn_over_each_trolley_and_winch_follows_the_block_angle_and_no_crane_travels() -> None:
    names = ["upper-slide.drive", "H1", "H2", "lower-slide.drive", "H3"]
    assert list(laws(turnover(), half("B"))) == [f"{crane}.{name}" for crane in ("west", "east") for name in names]


def test_during_a_turn_a_winch_without_slings_stands_still() -> None:
    found = laws(turnover(), {sling: lug for sling, lug in half("B").items() if not sling.startswith("loader-1")})
    assert [name for name in found if name.startswith("west.H1")] == []
    assert "west.H2" in found


def test_a_turn_is_refused_if_all_slings_of_the_block_pull_along_one_line() -> None:
    with pytest.raises(
        ModelError, match=r"^the block cannot turn: all hooks pull along a single line, .* another trolley"
    ):
        laws(turnover(), first_lugs(turnover(hooked="A").machines))


def test_a_turn_over_is_refused_if_it_requires_one_trolley_at_two_places() -> None:
    lugs = half("B") | {"loader-2.sling-1": "B+16", "loader-2.sling-2": "B+20"}
    with pytest.raises(ModelError, match=r"^the hooks on west.upper hold lugs at different"):
        laws(turnover(), lugs)


def test_an_eccentric_centre_of_gravity_stays_in_place_during_a_turn() -> None:
    plan = turnover()
    *others, block = plan.machines
    (cargo,) = block.cargo
    lateral = msgspec.structs.replace(block, cargo=(msgspec.structs.replace(cargo, com=(0.0, 0.5, 0.25)),))
    moved = msgspec.structs.replace(plan, machines=(*others, lateral))
    assert laws(moved, half("B"))["west.H1"] == Follow(
        model="west", actuator="west.H1", master="turn", law=(0.0, 0.25, -15.1)
    )


def test_a_block_without_slings_cannot_turn() -> None:
    with pytest.raises(ModelError, match=r"^the block cannot turn: no sling is hooked"):
        laws(turnover(), {})
