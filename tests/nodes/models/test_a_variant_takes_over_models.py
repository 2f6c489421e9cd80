"""Models that a plan of equal structure takes over declare what new ones declare, and do what new ones do."""

from __future__ import annotations

import random

import msgspec
import pytest
from heavylift.nodes.models import build, subscriptions, system, taken_over
from heavylift.nodes.plan import plan
from heavylift.nodes.scene import load, parse
from heavylift.nodes.statics import Models, StaticRun

NUMBERS = {  # of a scene: what may be varied, between which values
    "lift": {"block.mass": (250.0, 320.0, "t"), "block.com.x": (0.1, 0.5, "m")},
    "tandem": {"block.mass": (200.0, 300.0, "t"), "block.com.y": (-0.5, -0.1, "m")},
    "hall": {"block.mass": (10.0, 20.0, "t")},
}


def variant(name: str, settings: list[str]) -> plan.Plan:
    return parse(load(name).text, name, settings, passing=True, followed=False).plan


def drawn(name: str, draw: random.Random) -> list[str]:
    return [f"{key}={draw.uniform(a, b):.6f} {unit}" for key, (a, b, unit) in NUMBERS[name].items()]


def walked(given: plan.Plan) -> list[object]:
    run = StaticRun(given)
    run.walk()
    run.models.give_back()
    return [run.states, run.acted, run.why, run.cut]


@pytest.mark.parametrize("name", NUMBERS)
def test_models_taken_over_declare_the_mechanics_of_their_new_plan(name: str) -> None:
    draw = random.Random(name)
    old = variant(name, drawn(name, draw))
    models = build(old)
    for _ in range(3):
        new = variant(name, drawn(name, draw))
        assert system(old, models) != system(new)
        assert taken_over(models, old, new)
        assert system(new, models) == system(new)
        assert subscriptions(new, models) == subscriptions(new)
        old = new


@pytest.mark.parametrize("name", NUMBERS)
def test_a_static_run_with_models_taken_over_is_that_with_new_models(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    draw = random.Random(name)
    plans = [variant(name, drawn(name, draw)) for _ in range(3)]
    found = [walked(x) for x in (*plans, plans[0])]
    monkeypatch.setattr(Models, "of", Models)
    assert found == [walked(x) for x in (*plans, plans[0])]


@pytest.mark.parametrize(
    "setting",
    [
        "actions[1].all hooks=hoist 0.3 m/min until height of block >= 6.01 m",
        "cranes.crane.hook capacity=200 t",
        "rig.loaders.loader-1.sling=10.3 m",  # at which the winch of its hook starts
        "fidelity={slings: rigid}",
        "interlocks={low: {on: crane, when: tension of H1 >= 100 kN, stops: [hoist]}}",
    ],
)
def test_models_are_not_taken_over_where_more_than_numbers_of_mechanics_differs(setting: str) -> None:
    old, new = (variant("lift", [*more]) for more in ((), (setting,)))
    models = build(old)
    assert not taken_over(models, old, new)
    assert system(old, models) == system(old)


def test_models_of_several_lifts_are_not_taken_over() -> None:
    yard = load("yard").plan
    assert not taken_over(build(yard), yard, msgspec.structs.replace(yard, limits=()))
