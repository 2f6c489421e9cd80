"""Cranes of any types lift one block or several together: loads by statics, checks of each, and names mean nothing."""

from __future__ import annotations

import pytest
from heavylift.coordinator.ladder import play
from heavylift.nodes.scene import LoadedScene, parse
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
def test_the_order_and_names_of_scene_entries_do_not_change_the_checked_values(seed: int) -> None:
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
