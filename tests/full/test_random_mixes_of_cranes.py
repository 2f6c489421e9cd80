"""Cranes of any types lift one block or several together: static loads, checks of each, independence of names."""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.coordinator.record import play
from heavylift.kernel import SceneError
from heavylift.nodes.scene import LoadedScene, parse
from heavylift.nodes.statics import follow
from random_mixes import back, random_mix, renamed, reversed_entries

PLAYED = range(0, 100, 10)
STATIC = 1e-6  # relative: of the sum of all hook loads
AGAIN = 1e-5  # relative: of values found again with other names, which are solved in another order
DYNAMIC = (0.98, 1.6)  # of the largest tension at rest: the peak in a run


def scene(text: str) -> LoadedScene:
    return parse(text, "mix.yaml", passing=True)


def values(found: LoadedScene) -> dict[tuple[str, str], float]:
    uses = [use for use in found.uses if use.value is not None]
    return {(use.limit.quantity, back(use.limit.subject)): float(use.value or 0.0) for use in uses}


@pytest.mark.parametrize("seed", range(100))
def test_the_hooks_of_a_random_crane_mix_carry_the_total_weight_and_each_hook_is_checked(seed: int) -> None:
    mix = random_mix(seed)
    found = scene(mix.text)
    assert found.statics.known
    hooks = {hook.rope: hook for machine in found.plan.machines for hook in machine.hooks}
    last = found.statics.states[-1]
    blocks = sum(hooks[name].block_mass for name in mix.hooks)
    weight = sum(last.tensions[name] for name in mix.hooks) / found.plan.gravity
    assert weight == pytest.approx(mix.mass * 1e3 + blocks, rel=STATIC)
    rows = {(limit.quantity.removesuffix(" along"), limit.subject) for limit in found.plan.limits}
    slings = {tie.rope for machine in found.plan.machines for tie in machine.ties}
    assert {(kind, name) for kind in ("hook load", "off-lead") for name in mix.hooks} <= rows
    assert {(kind, name) for kind in ("sling tension", "sling peak", "bridle angle") for name in slings} <= rows
    assert {("sling tension", name) for name in slings} <= {*values(found)}


@pytest.mark.parametrize("seed", range(100))
def test_order_and_names_of_scene_entries_do_not_change_the_checked_values(seed: int) -> None:
    text = random_mix(seed).text
    one = values(scene(text))
    for other in (reversed_entries(text), renamed(text)):
        assert values(scene(other)) == {key: pytest.approx(x, rel=AGAIN, abs=AGAIN) for key, x in one.items()}


@pytest.mark.parametrize("seed", PLAYED)
def test_simulated_peaks_of_a_random_crane_mix_are_near_its_static_tensions(seed: int) -> None:
    mix = random_mix(seed)
    found = scene(mix.text)
    run = play(found.plan)
    assert [name for *_, name in run.conduct.stages][-1] == "up"
    for name in mix.hooks:
        most = max(state.tensions[name] for state in found.statics.states)
        low, high = DYNAMIC
        assert low * most <= run.peaks[name].tension <= high * most


@pytest.mark.parametrize("seed", [196, 247])
def test_a_light_block_with_slack_slings_is_not_reported_as_off_centre(seed: int) -> None:
    """All hooks rise alike, and those that came first carry the block: the waiting for the others' slings ends where
    winches end, and the block tips. Until then the loads of three hooks are those of a lever in plan."""
    text = random_mix(seed).text
    with pytest.raises(SceneError, match=r"is lifted while .* is slack, and tips by .* hoist the hook"):
        parse(text, "mix.yaml")
    plan = parse(text, "mix.yaml", passing=True, followed=False).plan
    body = next(b for m in plan.machines for b in m.system.bodies if b.name == "b0")
    lugs = {name: p for m in plan.machines for cargo in m.cargo for name, p in cargo.lugs.items()}
    state = next(x for x in follow(plan, keep=False).states if not any(x.supports.values()) and x.t > 30.0)
    held = {tie.rope: tie.lug for m in plan.machines for tie in m.ties if state.tensions.get(tie.rope, 0.0) > 0.0}
    hooks = {
        name: np.mean([lugs[lug] for x, lug in held.items() if x.startswith(name)], axis=0)
        for name in {x.split(".")[0] for x in held}
    }
    if len(hooks) == 3:
        rows = np.array([[1.0, p[0] - body.com[0], p[1] - body.com[1]] for p in hooks.values()]).T
        loads = dict(zip(hooks, np.linalg.solve(rows, [body.mass * plan.gravity, 0.0, 0.0]), strict=True))
        for name, load in loads.items():
            assert 0.999 * load < sum(state.tensions[x] for x in held if x.startswith(name)) < 1.05 * load
    assert any(state.tensions[tie.rope] == 0.0 for m in plan.machines for tie in m.ties), "and wait for it in vain"
