"""Several blocks in one scene: slings move from block to block, and each block is lifted and landed by its name."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.kernel import SceneError
from heavylift.nodes.plan import Hookup, LiftedCondition, UnhookSling
from heavylift.nodes.scene import LoadedScene, check, parse
from heavylift.recordings import Recording

G = 9.80665
LUGS = "{A: [-2 m, 2 m, 2 m], B: [2 m, 2 m, 2 m], C: [-2 m, -2 m, 2 m], D: [2 m, -2 m, 2 m]}"
STOOLS = "{height: 0.5 m, at: [[-2 m, -2 m], [2 m, -2 m], [-2 m, 2 m], [2 m, 2 m]]}"
TEXT = f"""\
heavylift: 1
name: two
accuracy: 0.1 %
blocks:
  first: {{mass: 40 t, size: [6 m, 5 m, 4 m], at: [0 m, 8 m, 2.5 m], lugs: {LUGS}, supports: {STOOLS}}}
  second: {{mass: 60 t, size: [6 m, 5 m, 4 m], at: [8 m, 8 m, 2.5 m], lugs: {LUGS}, supports: {STOOLS}}}
cranes: {{hall: {{type: overhead-100, at: 0 m, trolley: 8 m}}}}
rigging: {{legs: {{on: hall main, to: [first.A, first.B, first.C, first.D], length: 6 m, sling: {{EA: 120 MN}}}}}}
actions:
  - hall: hoist 1 m/min until first lifted
  - hall: hoist 4 m/min by 0.5 m
  - hall traversing: traverse 15 m/min ramp one swing by 8 m
  - hall: lower 1 m/min until first landed and all slings slack
  - legs: unhook
  - hall: hoist 4 m/min by 0.4 m
  - hall traversing: traverse 15 m/min ramp one swing by -8 m
  - hall travelling: travel 20 m/min ramp one swing by 8 m
  - hall: lower 4 m/min by 0.9 m
  - legs: hook [second.A, second.B, second.C, second.D]
  - hall: hoist 1 m/min until all slings taut
  - hall: hoist 1 m/min until second lifted
  - hall: hoist 4 m/min by 0.5 m
  - wait: 5 s
"""


@pytest.mark.parametrize("given", ["touch: 0.1 m/s", "impact: 1.4"])
def test_lift_off_and_landing_limits_of_each_of_several_blocks_have_the_same_source(given: str) -> None:
    rows = parse(TEXT, "two", [f"limits={{{given}}}"], followed=False).plan.limits
    for quantity in ("lift-off speed", "landing speed", "impact"):
        own = (quantity == "impact") == given.startswith("impact")
        found = [x.source.partition(":")[0] for x in rows if x.quantity == quantity]
        assert found == ["the scene" if own else "assumed"] * 2


@pytest.fixture(scope="module")
def scene() -> LoadedScene:
    return parse(TEXT)


def test_a_sling_hooked_to_another_block_has_a_rope_and_a_limit_of_its_own_for_that_block(scene: LoadedScene) -> None:
    orders = [order for action in scene.plan.actions for order in action.orders]
    assert [o.sling for o in orders if isinstance(o, UnhookSling)] == [f"legs.sling-{i}" for i in range(1, 5)]
    hooked = [f"legs.sling-{i}.second-{lug}" for i, lug in enumerate("ABCD", 1)]
    assert [o.sling for o in orders if isinstance(o, Hookup)] == hooked
    untils = [getattr(o, "until", None) for o in orders]
    assert [u.model for u in untils if isinstance(u, LiftedCondition)] == ["first", "second"]
    limited = {limit.subject for limit in scene.plan.limits if limit.quantity == "sling tension"}
    assert limited >= {"legs.sling-1", "legs.sling-1.second-A"}


@pytest.fixture(scope="module")
def both(scene: LoadedScene, tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("two") / "two.mcap"
    run(scene, path, in_process=True)
    return Recording(path)


def test_each_of_several_blocks_hangs_from_the_hook_that_its_stage_names(scene: LoadedScene, both: Recording) -> None:
    """40 t, then 60 t below a hook block of 2.5 t, at rest as in the run; the first stays where it was set down."""
    lifted = [s for s in scene.statics.states if s.action in (2, 13)]
    carried = {s.action: s.tensions["hall.main"] for s in lifted}
    assert carried == pytest.approx({2: 42.5e3 * G, 13: 62.5e3 * G}, rel=1e-4)
    first, second = (both[f"pose/{name}"].values[-1, :3] for name in ("first", "second"))
    assert first[:2] == pytest.approx((0.0, 16.0), abs=0.15)  # swinging is over as it lands
    assert second[2] > 3.0
    assert scene.findings == ()


def test_a_block_has_no_influence_on_the_lift_before_it_is_hooked(both: Recording, tmp_path: Path) -> None:
    """The slings know both from the start; the lift of the first is that of a scene without the second, within the
    accuracy of 0.1 % of either (they share an island, whose steps look at both)."""
    lines = [x for x in TEXT.split("  - legs: hook")[0].splitlines() if not x.startswith("  second:")]
    run(parse("\n".join(lines) + "\n"), tmp_path / "one.mcap", in_process=True)
    one = Recording(tmp_path / "one.mcap")
    last = min(event.t_ns for event in both.events() if event.type == "Hook") * 1e-9
    assert last == pytest.approx(one.fact("sim_s", 0.0), abs=1e-3)
    for name, scale in (("pose/first", 1.0), ("pose/hall.main", 1.0), ("rope/tension", 4e5)):
        mine, theirs = one.signal(name), both.signal(name)
        n = int((mine.t < last - 1.0).sum())
        shared = [theirs.names.index(x) for x in mine.names]
        assert n > 300
        assert mine.values[:n] == pytest.approx(theirs.values[:n, shared], abs=2e-3 * scale), name


def test_ambiguous_or_unknown_slings_are_reported_with_a_question_to_the_user() -> None:
    for old, new, sentence in (
        ("first.A, first.B", "A, first.B", "rigging.legs.to[0]: several blocks have a lug 'A'"),
        ("until first lifted", "until lifted", "which block? write 'first lifted' or 'second lifted'"),
        ("until first lifted", "until third lifted", "there is no block 'third' that could be lifted"),
        ("hook [second.A", "hook [second.E", "no block has a lug 'second.E'"),
        ("hook [second.A, ", "hook [", "4 slings need 4 different lugs, not 3"),
        ("  second: {", "  hall: {", "the name 'hall' is given twice: another machine has it"),
        ("  second: {", "  all: {", "the name 'all' is reserved: choose another"),
    ):
        assert old in TEXT
        with pytest.raises(SceneError) as message:
            parse(TEXT.replace(old, new, 1), passing=True)
        assert sentence in str(message.value)


def test_the_report_of_several_blocks_counts_every_sling_once(scene: LoadedScene) -> None:
    assert check(scene).slings == 4
