"""A condition crossed twice within one step begins its stage: against NumPy's roots and recorded swings."""

import json
from random import Random

import numpy as np
import pytest
from heavylift.coordinator.record import Played, play
from heavylift.nodes.scene import parse

CLOSE = 2e-2  # [s] at a tolerance of 1e-2, of methods that a cubic is not exact for
METHODS = ("dopri5", "dop853", "radau5")
HOW = (
    *({"method": method, "tolerance": tolerance} for tolerance in (1e-2, 1e-3, 1e-5) for method in METHODS),
    *({"method": method, "step": "20 ms"} for method in ("rk4", "semi-implicit-euler")),
)
SHALLOW = 2e-4  # relative: a dip that need not be looked for


def stages(start: float, speed: float, force: tuple[float, float], level: float, method: str, tolerance: float):
    """When x >= level begins, of 1 kg at a force that is linear in time over 12 s."""
    cart = {"type": "prismatic", "child": "cart", "axis": [1, 0, 0], "start": f"{start} m", "speed": f"{speed} m/s"}
    push = {"type": "load", "body": "cart", "force": ["1 N", 0, 0], "history": [["0 s", force[0]], ["12 s", force[1]]]}
    scene = {
        **{
            "heavylift": 1,
            "name": "graze",
            "end": "12 s",
            "samples": "0.25 Hz",
            "method": method,
            "tolerance": tolerance,
        },
        "mechanism": {"bodies": {"cart": {"mass": "1 kg"}}, "joints": {"rail": cart}, "forces": {"push": push}},
        "actions": [{"stage": "A", "when": f"position of rail >= {level!r} m"}, "wait 20 s"],
    }
    events = play(parse(json.dumps(scene)).plan).events
    return [e.tag.t * 1e-9 for e in events if e.port == "stage" and e.value.name == "A"]


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.large(beyond=4)
def test_a_swing_crest_just_above_a_threshold_fires_the_threshold(method: str, tolerance: float) -> None:
    random = Random(f"{method} {tolerance}")
    for _ in range(3):
        roots = sorted(random.uniform(1.0, 11.0) for _ in range(3))
        x = np.poly1d(roots, r=True)
        crest = min(x.deriv().roots.real)
        level = round(float(x(crest)) - random.uniform(0.005, 0.2) * max(1.0, abs(float(x(crest)))), 6)
        first = min(r.real for r in (x - level).roots if abs(r.imag) < 1e-9 and r.real > 0.0)
        force = (float(x.deriv(2)(0.0)), float(x.deriv(2)(12.0)))
        (found,) = stages(float(x(0.0)), float(x.deriv()(0.0)), force, level, method, tolerance)
        assert found == pytest.approx(first, abs=CLOSE)


def swinging(start: float, level: float, how: dict[str, str | float]) -> Played:
    """A pendulum of 60 m from an angle [deg], which waits until it passes another one; shown at 50 Hz."""
    load = {"mass": "450 t", "com": [0, 0, "-60 m"]}
    pivot = {"type": "revolute", "child": "load", "axis": [0, 1, 0], "start": f"{start!r} deg"}
    scene = {
        **{"heavylift": 1, "name": "swing", "end": "60 s", "samples": "50 Hz"},
        "mechanism": {"bodies": {"load": load}, "joints": {"pivot": pivot}},
        "actions": [{"stage": "A", "when": f"position of pivot >= {level!r} deg"}, "wait 70 s"],
    }
    return play(parse(json.dumps(scene | how)).plan)


@pytest.mark.parametrize("how", HOW, ids=str)
@pytest.mark.large(beyond=4)
def test_a_threshold_exceeded_only_between_two_integration_steps_still_begins_its_stage(
    how: dict[str, str | float],
) -> None:
    random = Random(str(how))
    seen = 0
    for _ in range(6):
        start = -random.uniform(2.0, 60.0)
        run = swinging(start, level := -start * random.uniform(0.99, 0.9999), how)
        angle = run.rows[:, run.layout.find("joint/position").start]
        again = 0.2 * float(how.get("tolerance", 0.0))  # a step to an event is taken again, shorter, and is another one
        above = run.t[angle >= np.radians(level) * (1.0 + SHALLOW + again)]
        began = [e.tag.t * 1e-9 for e in run.events if e.port == "stage" and e.value.name == "A"]
        seen += len(above) > 0
        assert not len(above) or began[0] <= above[0], "the recorded motion meets it before"
        for t in began:
            assert np.interp(t, run.t, angle) == pytest.approx(np.radians(level), rel=SHALLOW + again)
    assert seen > 0
