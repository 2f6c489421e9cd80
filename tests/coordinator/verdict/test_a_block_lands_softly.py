"""What supports bear as a block lands is known between samples: the same as samples a thousand times a second show."""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.coordinator.record import play
from heavylift.coordinator.verdict import landing_force
from heavylift.nodes.limits import SignalColumns, uses_of
from heavylift.nodes.scene import load

UP = '{{{who}: "hoist 1 m/min until all slings taut"}}, {{{who}: "hoist 1 m/min until lifted"}}'
CASES = {"jib": ("jib main", "legs"), "hall": ("hall main", "legs"), "crawler": ("crawler main", "legs")}


@pytest.mark.parametrize("name", sorted(CASES))
@pytest.mark.large(beyond=1)
def test_the_impact_force_of_a_dropped_block_is_the_largest_sampled_support_force_and_gives_a_red_check(
    name: str,
) -> None:
    who, slings = CASES[name]
    drop = f'{{{who}: "hoist 1 m/min by 20 mm"}}, {{wait: 5 s}}, {{{slings}: release}}, {{wait: 2 s}}'
    given = [f"actions=[{UP.format(who=who)}, {drop}]", "end=120 s", "block.supports.capacity=100 t"]
    found, loads = [], []
    for hz in ("2 Hz", "1000 Hz"):
        run = play(load(name, [*given, f"samples={hz}"]).plan)
        (use,) = (x for x in run.uses if x.limit.quantity == "impact")
        (one,) = (x for x in run.uses if x.limit.quantity == "support load")
        found.append((use.value, use.use))
        loads.append(one.value)
        tensions = run.past.part(0, len(run.t)).tensions
        pads = [tensions[x] for x in use.limit.elements if x in tensions]
        shown = float(np.sum(pads, axis=0).max())
        red = {f.quantity: f.sentence for f in run.verdict.findings if f.state == "red"}
        assert {*red} == {"impact", "landing", "landing speed"}
        assert ": 1.5 times its weight)" in red["impact"]
    assert found[0][0] == pytest.approx(found[1][0], rel=2e-3)
    assert found[0][0] == pytest.approx(shown, rel=5e-3)
    assert loads[0] == pytest.approx(loads[1], rel=2e-3)
    assert use.use > 1.0


def test_the_impact_force_of_a_block_set_down_at_creep_speed_is_less_than_its_weight() -> None:
    for name in ("hall", "jib"):
        (use,) = (x for x in play(load(name).plan).uses if x.limit.quantity == "impact")
        assert 0.0 < use.value < 1.05 * use.limit.value / 1.5


@pytest.mark.parametrize("name", [*sorted(CASES), "lift"])
def test_supports_loaded_beyond_their_impact_limit_give_a_red_check_even_if_the_limit_is_close_to_the_weight(
    name: str,
) -> None:
    """A block that only stands has no impact, except where it stands with more than the scene allows."""
    plan = load(name, ["limits.impact=1.01"]).plan
    (limit,) = (x for x in plan.limits if x.quantity == "impact")
    weight, pads = limit.value / limit.factor, len(limit.elements)
    for times, seen in ((1.005, None), (1.03, True), (1.06, True)):
        forces = {x: np.full(3, times * weight / pads) for x in limit.elements}
        (use,) = (x for x in uses_of(plan, [SignalColumns(np.arange(3.0), forces, dynamic=True)]) if x.limit == limit)
        assert (use.value is None, use.use is not None and use.beyond) == (seen is None, bool(seen))


def test_the_force_of_landing_without_damping_agrees_with_the_closed_form() -> None:
    """m g (1 + sqrt(1 + v^2 k / (m g^2))), and without what ropes hold v sqrt(k m)."""
    rng = np.random.default_rng(4)
    for m, k, v in zip(rng.uniform(1e3, 1e6, 50), rng.uniform(1e6, 1e9, 50), rng.uniform(0.0, 2.0, 50), strict=True):
        weight = m * 9.80665
        whole = weight * (1.0 + np.sqrt(1.0 + v * v * k / (m * 9.80665**2)))
        assert landing_force(m, weight, k, 0.0, v) == pytest.approx(whole, rel=1e-9)
        assert landing_force(m, 0.0, k, 0.0, v) == pytest.approx(v * np.sqrt(k * m), rel=1e-9)


def test_the_force_of_landing_with_damping_agrees_with_numerical_integration() -> None:
    rng = np.random.default_rng(5)
    for m, k, v, share, free in rng.uniform([1e3, 1e6, 0, 0.01, 0], [1e6, 1e9, 2, 0.9, 1], (30, 5)):
        d, weight = 2.0 * share * np.sqrt(k * m), free * m * 9.80665
        h, x, u, most = 1e-3 * np.sqrt(m / k), 0.0, v, d * v
        for _ in range(7000):  # of the midpoint rule, over one period
            a = (weight - k * x - d * u) / m
            um, xm = u + h / 2 * a, x + h / 2 * u
            x, u = x + h * um, u + h * (weight - k * xm - d * um) / m
            most = max(most, k * x + d * u)
        assert landing_force(m, weight, k, d, v) == pytest.approx(most, rel=1e-4)
