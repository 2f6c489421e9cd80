"""A block that is lowered into water: its weight by Archimedes, and the checks of the splash zone by hand."""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.coordinator.record import play
from heavylift.kernel import SceneError
from heavylift.kernel.description import Body, Immersion, Joint, JointSpring, Point, System
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.limits import Use, uses_on_path
from heavylift.nodes.scene import LoadedScene, parse
from heavylift.nodes.scenes import bundled
from heavylift.nodes.statics import follow
from scipy.integrate import solve_ivp

G, RHO, MASS = 9.80665, 1025.0, 80e3
AREA, HIGH, LEVEL, FIRST = 10.0, 4.0, 3.0, 2.5  # [m2, m, m, m]: of the flooded box, of still water, depth at the start
AMPLITUDE = ((0.0, 40.0), (1.3, 300.0), (2.2, 120.0))  # [m, kN]
EXACT = 1e-6  # relative: tolerance of a pose at rest
SWINGS = 5e-3  # relative: what hangs swings a little
STEPS = 1e-7  # [m] of the integration


def scene(amplitude: tuple[tuple[float, float], ...] = AMPLITUDE, buoyancy: str = "") -> LoadedScene:
    """The bundled hall, flooded by 3 m of water; its block is lifted out and set down again."""
    most = RHO * G * AREA * HIGH / 1e3
    curve = buoyancy or f"[[0 m, 0 kN], [{HIGH} m, {most!r} kN]]"
    given = ", ".join(f"[{x} m, {force} kN]" for x, force in amplitude)
    text = bundled()["hall"].read_text()
    text = text.replace("  lug capacity:", f"  splash: {{level: {LEVEL} m, buoyancy: {curve}, amplitude: [{given}]}}\n"
                                           "  lug capacity:", 1)  # fmt: skip
    text = text[: text.index("  - stage: through")] + "  - stage: again\n    hall: lower 4 m/min by 1.8 m\n"
    return parse(text + "  - stage: in water\n    wait: 20 s\n")


def by_quantity(uses: list[Use]) -> dict[str, Use]:
    return {x.limit.quantity: x for x in uses if x.limit.quantity in ("slack sling", "splash load", "hook load")}


def static(depth: np.ndarray) -> np.ndarray:
    """Weight of the box in water [N]: m g - rho g A d."""
    return MASS * G - RHO * G * AREA * np.clip(depth, 0.0, HIGH)


@pytest.fixture(scope="module")
def flooded() -> LoadedScene:
    return scene()


def test_the_hook_of_a_submerged_block_carries_its_weight_less_the_displaced_water(flooded: LoadedScene) -> None:
    hook = next(x for machine in flooded.plan.machines for x in machine.hooks)
    seen = [x for x in follow(flooded.plan).states if x.stage in ("up", "again") and not x.grounded]
    depths = [LEVEL - float(x.poses["block"][0][2]) + 0.5 * HIGH for x in seen]
    assert min(depths) < 0.0 < max(depths)
    for x, depth in zip(seen, depths, strict=True):
        below = x.tensions[hook.rope] - G * hook.block_mass
        assert below == pytest.approx(float(static(np.array(depth))), rel=EXACT)


def test_static_splash_zone_checks_agree_with_maxima_of_the_load_curves(flooded: LoadedScene) -> None:
    """At rest the amplitude alone acts beside the weight in water; its corner lies between two states of the path."""
    found = by_quantity(uses_on_path(flooded.plan, list(follow(flooded.plan).states)))
    d = np.linspace(0.0, FIRST, 100_001)
    amplitude = 1e3 * np.interp(d, *zip(*AMPLITUDE, strict=True))
    share = amplitude / static(d)
    assert found["slack sling"].value == pytest.approx(share.max(), rel=SWINGS)
    block = found["hook load"].value - MASS  # what else hangs on the hook
    most = (static(d) + amplitude).max() / G
    assert found["splash load"].value == pytest.approx(most + block, rel=SWINGS)
    assert found["splash load"].limit.value == found["hook load"].limit.value


def test_a_run_through_the_splash_zone_has_at_least_the_slack_and_load_of_the_static_check(
    flooded: LoadedScene,
) -> None:
    run = play(flooded.plan)
    found, still = (
        by_quantity(run.judge.fine[1]),
        by_quantity(uses_on_path(flooded.plan, [*follow(flooded.plan).states])),
    )
    for quantity in ("slack sling", "splash load"):
        assert found[quantity].value >= (1.0 - SWINGS) * still[quantity].value


def test_slings_that_become_slack_in_the_splash_zone_give_a_red_check() -> None:
    """The limit is 0.9 of the weight in water: a little less passes, a little more does not."""
    for share, beyond in ((0.88, False), (0.92, True)):
        force = share * float(static(np.array(1.0))) / 1e3
        loaded = scene(((0.0, 0.0), (1.0, force), (1.001, 0.0)))
        found = by_quantity(uses_on_path(loaded.plan, list(follow(loaded.plan).states)))["slack sling"]
        assert found.beyond is beyond
        assert found.value == pytest.approx(share, rel=SWINGS)


def test_checks_below_the_last_point_of_a_splash_zone_curve_use_the_value_at_that_point() -> None:
    """The curves end at 1 m, the block goes down to 2.5 m: it is checked there with what they have at 1 m."""
    push, force = 100.0, 240.0
    loaded = scene(((0.0, 0.0), (0.5, 0.0), (1.0, force)), buoyancy=f"[[0 m, 0 kN], [1 m, {push} kN]]")
    uses = [x for x in uses_on_path(loaded.plan, list(follow(loaded.plan).states))]
    found = by_quantity(uses)
    assert found["slack sling"].value == pytest.approx(1e3 * force / (MASS * G - 1e3 * push), rel=SWINGS)
    deep = [x for x in follow(loaded.plan).states if LEVEL - float(x.poses["block"][0][2]) + 0.5 * HIGH > 1.1]
    found = by_quantity(uses_on_path(loaded.plan, deep))
    assert found["slack sling"].value == pytest.approx(1e3 * force / (MASS * G - 1e3 * push), rel=SWINGS)
    assert "above still water is not checked" in found["slack sling"].limit.source
    assert "above still water is not checked" in found["splash load"].limit.source


@pytest.mark.parametrize("method", ["dopri5", "radau5"])
def test_a_buoy_on_a_piecewise_linear_buoyancy_curve_moves_as_in_scipy(method: str) -> None:
    x, force = (0.0, 1.0, 3.0), (0.0, 9e3, 12e3)
    water = Immersion("water", Point("buoy"), 0.5, 0.2, x, force)
    body = Body("buoy", 500.0, inertia=((100.0, 0.0, 0.0), (0.0, 100.0, 0.0), (0.0, 0.0, 100.0)))
    guide = Joint("guide", "prismatic", "world", "buoy", axis=(0.0, 0.0, 1.0), q0=(1.0,))
    spring = JointSpring("line", "guide", 300.0)
    s = Simulation(System((body,), (guide,), springs=(spring,), forces=(water,), gravity=G), 1e-10, method=method)
    s.start()

    def rate(t: float, y: np.ndarray) -> list[float]:
        return [y[1], (np.interp(0.7 - y[0], x, force) - 300.0 * y[0]) / 500.0 - G]

    want = solve_ivp(rate, (0.0, 12.0), [1.0, 0.0], rtol=1e-10, atol=1e-12, max_step=0.01, method="DOP853")
    s.interrupt(12_000_000_000)
    assert float(s.row().q[0]) == pytest.approx(want.y[0, -1], abs=STEPS)
    row = s.row()
    signs = [1.0 if what == "heat" else -1.0 for what, _ in s.program.accounts]
    energy = (
        row.kinetic + row.potential + sum(row.stored) + sum(a * b for a, b in zip(signs, row.accounts, strict=True))
    )
    assert float(energy) == pytest.approx(500.0 * G + 150.0, rel=STEPS)


@pytest.mark.parametrize(
    ("curve", "words"),
    [
        ("[[0 m, 0 kN], [2 m, 5 kN], [1 m, 6 kN]]", "depths of 'buoyancy' must be in ascending order"),
        ("[[1 m, 0 kN], [2 m, 5 kN]]", "'buoyancy' must begin at the depth 0 m with 0 kN"),
        ("[[0 m, 0 kN], [2 m, -5 kN]]", "buoyancy"),
    ],
)
def test_impossible_splash_zone_curves_are_refused_in_one_sentence(curve: str, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        scene(buoyancy=curve)
