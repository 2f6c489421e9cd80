"""Events on the path at rest of a scene are where they are, however long the steps are that find them."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "fidelity"))

from heavylift.kernel import analysis
from heavylift.nodes.plan import Plan
from heavylift.nodes.scene import bundled, load, parse
from heavylift.nodes.statics import StaticRun
from lifts_of_kinds import lift_of_kinds

SHORT_NS = 5 * 10**9  # longest steps of the path to compare with
LOCATED = 2e-6  # [s] of events on two paths
SLID = 0.1  # [s] of events after pads have slid, whose way is a chain of secants
SLIDING = {"dock", "moored"}
FIRST = ["floating", "crawler", "dock"]  # a vessel whose load once landed a minute late, for one
RANDOM = [770_074, 770_106, 770_220, 770_274]  # no equilibrium was found between guesses and an event
SCENES = [*FIRST, *sorted({*bundled()} - {*FIRST})]


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.large(beyond=len(FIRST))
def test_events_on_the_path_at_rest_do_not_depend_on_the_length_of_its_steps(
    scene: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = load(scene).plan
    if plan.lists:
        pytest.skip("the path at rest is that of one list of actions")
    compare(plan, SLID if scene in SLIDING else LOCATED, monkeypatch)


@pytest.mark.parametrize("seed", RANDOM)
def test_events_of_random_lifts_do_not_depend_on_the_length_of_the_steps(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    compare(parse(lift_of_kinds(seed).text, passing=True, followed=False).plan, LOCATED, monkeypatch)


def compare(plan: Plan, near: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Compare the events found by long and by short steps; times to `near` [s]."""
    long = events(StaticRun(plan))
    monkeypatch.setattr(f"{analysis.EquilibriumPath.__module__}.LONGEST_NS", SHORT_NS)
    short = events(StaticRun(plan))
    assert [what for _, what in long] == [what for _, what in short]
    assert [t for t, _ in long] == pytest.approx([t for t, _ in short], rel=0.0, abs=near)


def events(run: StaticRun) -> list[tuple[float, str]]:
    """Times [s] and events of a path at rest."""
    run.walk()
    return [(state.t, what) for state in run.states for what in state.event.split(", ") if what]
