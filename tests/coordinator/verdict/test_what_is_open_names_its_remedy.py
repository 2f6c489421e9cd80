"""What is not checked or assumed says what to write so that it is checked, in bundled scenes and on every type."""

from __future__ import annotations

import re

import pytest
from heavylift.coordinator.record import play
from heavylift.kernel.description import ASSUMED, NOT_CHECKED, NOTED, Check
from heavylift.nodes.limits import open_checks, state_of
from heavylift.nodes.scene import bundled, load
from lift_of_a_type import Lift
from lifting import unstated

REMEDY = re.compile(r"(?:write|give) [^:]*'[^']+'|give it under '[^']+'|`heavylift [^`]+`|look at it")


def without_remedy(checks: list[Check]) -> list[str]:
    found = [x for x in checks if x.state in ("amber", "undecided") and x.why in (NOT_CHECKED, ASSUMED)]
    return [x.sentence for x in found if not REMEDY.search(x.sentence)]


@pytest.mark.parametrize("name", sorted({*bundled()} - {"yard"}))
def test_every_unchecked_or_assumed_item_of_a_bundled_scene_says_how_to_resolve_it(name: str) -> None:
    checks = load(name).checks
    assert not without_remedy(checks)
    assert all(REMEDY.search(line) for line in open_checks(checks))


@pytest.mark.parametrize("practice", [[], ["practice=0027/ND"]])
def test_every_unchecked_or_assumed_item_of_a_lift_states_how_to_resolve_it_for_every_crane_type(
    lift: Lift, practice: list[str]
) -> None:
    checks = lift.read(*practice, text=unstated(lift.text)).checks
    assert {x.why for x in checks} >= {NOT_CHECKED, ASSUMED}
    assert not without_remedy(checks)


@pytest.mark.parametrize("does", ["", "stops: [hoist]"])
def test_an_interlock_that_only_reports_gives_a_note_and_one_that_stops_a_machine_gives_a_red_finding(
    lift: Lift, does: str
) -> None:
    """What a scene orders to be reported was foreseen; what stops a machine was not."""
    hook = next(hook.rope for machine in lift.read().plan.machines for hook in machine.hooks)
    high = f"interlocks={{high: {{when: height of {hook} >= 0 m, tells: it is up{f', {does}' if does else ''}}}}}"
    text = f"{lift.text[: lift.text.index('actions:')]}actions:\n  - wait: 1 s\n"
    checks = play(lift.read(high, text=text).plan).verdict.checks
    ((state, why),) = {(x.state, x.why) for x in checks if x.quantity == "interlock" and "high" in x.subject}
    assert (state, why) == (("red", "") if does else ("none", NOTED))
    assert (state_of(checks) == "red") == bool(does)
