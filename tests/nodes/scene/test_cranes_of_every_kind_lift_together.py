"""Several blocks below a crane, rigging beside lifting beams, cranes of different types: shares by statics alone."""

import pytest
from heavylift import simulate
from heavylift.kernel import SceneError
from heavylift.nodes.scene import LoadedScene, check, parse

STANDS = "supports: {height: 1 m, at: [[-3 m, -3 m], [3 m, -3 m], [-3 m, 3 m], [3 m, 3 m]]}"
LUGS = "lugs: {P: [-2 m, 0 m, 2.3 m], Q: [2 m, 0 m, 2.3 m]}"
TWO = f"""
heavylift: 1
name: two
blocks:
  a: {{mass: 150 t, size: [10 m, 8 m, 4 m], at: [34 m, 70 m, 3 m], {LUGS}, {STANDS}}}
  b: {{mass: 120 t, size: [10 m, 8 m, 4 m], at: [46 m, 70 m, 3 m], {LUGS}, {STANDS}}}
cranes: {{west: {{type: goliath-900, at: 40 m}}}}
rig:
  slack: 0.1 m
  loaders:
    one: {{hook: west H1, sling: 8 m, lugs: [a.P, a.Q]}}
    two: {{hook: west H2, sling: 8 m, lugs: [b.P, b.Q]}}
actions:
  - all hooks: hoist 0.3 m/min until all slings taut
  - one: hoist 0.3 m/min until a lifted
  - two: hoist 0.3 m/min until b lifted
  - all hooks: hoist 1 m/min by 1 m
  - west: travel 10 m/min by 2 m
"""
BEAM = "    two: {hook: west H2, sling: 8 m, lugs: [b.P, b.Q]}\n"
MIXED = TWO.replace(BEAM, "rigging: {legs: {on: west H2, to: [b.P, b.Q], length: 9 m, slack: 0.1 m}}\n").replace(
    "two: hoist", "west H2: hoist"
)
BESIDE = f"""
heavylift: 1
name: beside
block:
  {{mass: 120 t, size: [30 m, 8 m, 4 m], at: [40 m, 70 m, 3 m],
   lugs: {{P: [-12 m, 0 m, 2.3 m], Q: [-8 m, 0 m, 2.3 m], R: [14 m, 0 m, 2.3 m]}}, {STANDS}}}
cranes:
  west: {{type: goliath-900, at: 36 m, upper trolley: 70 m}}
  hall: {{type: overhead-100, at: 54 m, span: 150 m, trolley: 70 m, reach: [2 m, 140 m], runway: [0 m, 90 m]}}
rig:
  slack: 0.1 m
  loaders: {{one: {{hook: west H1, sling: 8 m, lugs: [P, Q]}}}}
rigging: {{tail: {{on: hall main, to: [R], length: 5 m, slack: 0.1 m}}}}
actions:
  - all hooks: hoist 0.3 m/min until all slings taut
  - all hooks: hoist 0.3 m/min until lifted
  - all hooks: hoist 1 m/min by 1 m
"""


def scene(text: str) -> LoadedScene:
    return parse(text, "scene.yaml", passing=True)


def carried(text: str) -> dict[str, float]:
    """What each hook carries of blocks at the end [t]."""
    found = scene(text)
    assert found.statics.known
    last = found.statics.states[-1].stage
    return {row.hook: row.sling_load / 1e3 for row in check(found).rows if row.stage == last}


def test_each_lifting_beam_of_a_crane_can_lift_its_own_block() -> None:
    assert carried(TWO) == pytest.approx({"west.H1": 150.0, "west.H2": 120.0}, rel=1e-6)


def test_a_crane_can_carry_slings_next_to_a_lifting_beam() -> None:
    assert carried(MIXED) == pytest.approx({"west.H1": 150.0, "west.H2": 120.0}, rel=1e-6)
    rows = {(x.limit.quantity, x.limit.subject): x for x in scene(MIXED).uses}
    whole = rows["crane load", "west"].value
    assert whole == pytest.approx(150e3 + 120e3 + 20e3, rel=1e-3), "with the beam, which weighs 20 t"
    assert ("bridle angle", "legs.sling-1") in rows


@pytest.mark.parametrize("fidelity", ["{}", "{ropes: massive, lumps: 2}", "{ropes: rigid, slings: rigid}"])
def test_a_crane_with_a_beam_and_slings_runs_on_every_model_level(fidelity: str) -> None:
    result = simulate(scene(f"{MIXED}fidelity: {fidelity}\nend: 60 s\n"))
    tension = result["rope/tension"]["west.H2"]
    assert max(tension) == pytest.approx((120e3 + 25e3) * 9.80665, rel=0.1)


def test_a_crane_on_rails_lifts_next_to_one_of_another_type() -> None:
    assert carried(BESIDE) == pytest.approx({"west.H1": 70.0, "hall.main": 50.0}, rel=2e-2)
    rows = {(x.limit.quantity, x.limit.subject): x.limit for x in scene(BESIDE).uses}
    assert rows["tandem load", "west"].value == 0.75 * 900e3
    assert rows["tandem load", "hall.main"].value == pytest.approx(100e3 / 1.2)


def test_two_rail_cranes_of_different_types_share_a_block_and_are_derated() -> None:
    hall = "hall: {type: overhead-100, at: 54 m, span: 150 m, trolley: 70 m, reach: [2 m, 140 m], runway: [0 m, 90 m]}"
    text = BESIDE.replace(hall, "east: {type: goliath-1200, at: 76 m, upper trolley: 70 m}")
    text = (
        text.replace("rigging: {tail: {on: hall main, to: [R], length: 5 m, slack: 0.1 m}}\n", "")
        .replace("R: [14 m, 0 m, 2.3 m]", "R: [28 m, 0 m, 2.3 m], S: [32 m, 0 m, 2.3 m]")
        .replace("[30 m, 8 m", "[70 m, 8 m")
    )
    text = text.replace("lugs: [P, Q]}", "lugs: [P, Q]}, two: {hook: east H1, sling: 8 m, lugs: [R, S]}")
    uses = {x.limit.subject: x.limit.value for x in scene(text).uses if x.limit.quantity == "tandem load"}
    assert uses == {"west": 0.75 * 900e3, "east": 0.75 * 1200e3}


def test_a_sling_can_be_hooked_to_one_block_only() -> None:
    with pytest.raises(SceneError, match=r"one.sling-1 can be hooked to lugs of a only, b.P is one of another block"):
        parse(TWO + "  - one: unhook\n  - one: hook [b.P, b.Q]\n")
    with pytest.raises(SceneError, match="all slings of one hook must hang on the same block"):
        parse(TWO.replace("lugs: [a.P, a.Q]", "lugs: [a.P, b.Q]").replace("lugs: [b.P, b.Q]", "lugs: [b.P, a.Q]"))


def test_an_order_in_a_scene_with_one_block_may_omit_the_name_of_the_block() -> None:
    one = "\n".join(line for line in TWO.splitlines() if not line.startswith(("  b:", "    two:", "  - two:")))
    assert carried(one.replace("until a lifted", "until lifted")) == pytest.approx({"west.H1": 150.0}, rel=1e-6)


def test_the_order_phrase_for_all_slings_includes_those_next_to_a_lifting_beam() -> None:
    plan = scene(MIXED).plan
    first = plan.actions[0].orders[0].until
    assert {*first.names} == {"one.sling-1", "one.sling-2", "legs.sling-1", "legs.sling-2"}


DOWN = """\
  - all hooks: lower 1 m/min by 0.9 m
  - one: lower 0.3 m/min until a landed
  - west H2: lower 0.3 m/min until b landed
  - all hooks: lower 0.3 m/min until all slings slack
"""


@pytest.mark.parametrize("order", ["all hooks: unhook", "all hooks: unhook\n    legs: unhook"])
def test_unhooking_removes_the_slings_of_a_hook_with_or_without_a_lifting_frame(order: str) -> None:
    text = MIXED.replace("  - west: travel 10 m/min by 2 m\n", DOWN)
    for given, left in ((order, set()), ("west H2: unhook", {"one.sling-1", "one.sling-2"})):
        assert {*scene(f"{text}  - {given}\n").statics.states[-1].hooked} == left
    with pytest.raises(SceneError, match=r"nothing hangs on west\.H2 that could be unhooked"):
        scene(f"{text}  - {order}\n  - west H2: unhook\n")


def test_a_lug_to_which_a_lifting_beam_is_attached_accepts_no_other_sling() -> None:
    with pytest.raises(SceneError, match=r"the lug a\.P already carries a sling of one"):
        scene(MIXED.replace("to: [b.P, b.Q]", "to: [a.P, b.Q]"))
