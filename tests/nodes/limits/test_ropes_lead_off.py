"""Limits of off-lead angles, of bridle angles and of the side pull on drives."""

from __future__ import annotations

import random
from dataclasses import replace
from math import atan, degrees, radians, sin, tan

import msgspec
import numpy as np
import pytest
from heavylift.kernel.description import NOT_CHECKED
from heavylift.nodes.limits import Check, SignalColumns, Use, checks_of, table_of, uses_of, uses_on_path
from heavylift.nodes.plan import Plan
from heavylift.nodes.statics import StaticState
from lifting import bare, cargo, findings_of, hook_ropes, slings

EXACT = 1e-12  # relative: the same triangle by other functions
LEVEL = np.eye(3)
LENGTH = 40.0  # [m] from trolley to hook
LOADED = 1.5e6  # [N]
HOOK = "crane.H3"


def plan(*settings: str) -> Plan:
    return bare("lift", settings).plan


def hung(built: Plan, along: float, across: float, tension: float = LOADED, sling: float = LOADED / 2) -> SignalColumns:
    """The hook H3 beside its trolley by so much [m], for one instant; its loader hangs level below it."""
    rope = hook_ropes(built)[HOOK]
    top = np.array([40.0, 83.0, 0.0])
    eye = top + np.array([along, across, rope.lines[0].a.p[2] - LENGTH])
    poses = {
        "crane.lower": top,
        "loader-3.upper": eye,
        "loader-3.lower": eye - [0, 0, 2.0],
        "crane.main": top * [1, 0, 0],
    }
    held = {name: np.array([sling if name.startswith("loader-3.") else 0.0]) for name in slings(built)}
    tensions = {name: np.zeros(1) for name in hook_ropes(built)} | held | {HOOK: np.array([tension])}
    placed = {name: (p[None, :], LEVEL[None]) for name, p in poses.items()}
    return SignalColumns(t=np.array([7.0]), tensions=tensions, poses=placed, stages=[(0.0, "swing")], dynamic=True)


def judged(built: Plan, signals: SignalColumns) -> list[Check]:
    return findings_of(built, uses_of(built, [signals]), dynamic=True)


def use(built: Plan, signals: SignalColumns, quantity: str, subject: str = HOOK) -> Use:
    return next(x for x in uses_of(built, [signals]) if (x.limit.quantity, x.limit.subject) == (quantity, subject))


def test_off_lead_angles_are_measured_in_each_direction() -> None:
    built, draw = plan(), random.Random(3)
    for _ in range(50):
        x, y = draw.uniform(-5, 5), draw.uniform(-5, 5)
        signals = hung(built, x, y)
        assert use(built, signals, "off-lead along").value == pytest.approx(atan(abs(x) / LENGTH), rel=EXACT)
        assert use(built, signals, "off-lead across").value == pytest.approx(atan(abs(y) / LENGTH), rel=EXACT)


def test_off_lead_up_to_three_degrees_is_allowed_and_a_larger_angle_gives_a_red_check() -> None:
    built = plan()
    assert judged(built, hung(built, LENGTH * tan(radians(2.99)), 0.0)) == []
    (red,) = judged(built, hung(built, 0.0, LENGTH * tan(radians(3.4))))
    assert (red.word, red.quantity, red.subject, red.stage, red.t) == ("red", "off-lead across", HOOK, "swing", 7.0)
    assert red.sentence == "off-lead across of crane.H3 was 3.40 deg; 3.00 deg is allowed (assumed)"


def test_an_empty_hook_may_swing_without_findings_about_off_lead() -> None:
    built = plan()
    assert judged(built, hung(built, 6.0, 6.0, tension=45e3 * built.gravity, sling=0.0)) == []


def test_each_machine_has_its_own_off_lead_limit_in_each_direction() -> None:
    built = plan("limits={off-lead: 2 deg}", "cranes.crane.off-lead across=5 deg")
    signals = hung(built, LENGTH * tan(radians(4)), LENGTH * tan(radians(4)))
    assert [(f.quantity, f.sentence) for f in judged(built, signals)] == [
        ("off-lead along", "off-lead along of crane.H3 was 4.00 deg; 2.00 deg is allowed (the scene)")
    ]
    assert use(built, signals, "off-lead across").use == pytest.approx(4 / 5, rel=1e-9)


def test_an_unknown_off_lead_limit_is_reported_and_not_checked() -> None:
    scene = bare("lift", ["limits={off-lead: unknown}"])
    built = unstated_pushes(scene.plan)
    assert judged(built, hung(built, 10.0, 10.0)) == []
    message = [check.sentence for check in scene.checks if check.why == NOT_CHECKED]
    for distance in ("along", "across"):
        assert f"off-lead {distance} of crane.H1: the machine's limit is unknown" in message


def test_the_side_pull_of_ropes_is_checked_against_drive_and_brake() -> None:
    built = plan("cranes.crane.trolley drive=60 kN", "cranes.crane.trolley brake=90 kN", "limits={off-lead: 10 deg}")
    angle = radians(3.0)
    signals = hung(built, 0.0, LENGTH * tan(angle))
    pulled = [x for x in uses_of(built, [signals]) if x.limit.quantity == "side force" and x.limit.known]
    assert [x.value for x in pulled if x.limit.subject == "crane lower"] == pytest.approx([LOADED * sin(angle)] * 2)
    assert [(f.subject, f.sentence) for f in judged(built, signals)] == [
        ("crane lower", "side force of crane lower was 78.5 kN, 131 %; 60 kN is allowed (the scene; its drive moves)")
    ]
    uses = uses_of(unstated_pushes(built), [signals])
    unknown = [c for c in checks_of(built, uses, [], {}, []) if c.quantity == "side force" and c.why == NOT_CHECKED]
    message = {f"side force of crane: its {x}: unknown" for x in ("drive moves", "brake holds")}
    assert {c.sentence for c in unknown} >= message


def unstated_pushes(built: Plan) -> Plan:
    """A plan whose type states no force of drives and brakes."""
    rows = list(built.limits)
    for i, x in enumerate(rows):
        if x.quantity == "side force":
            rows[i] = msgspec.structs.replace(x, value=None, source="", note=f"{x.note}: unknown")
    return msgspec.structs.replace(built, limits=tuple(rows))


def spread(built: Plan, angle: float, tension: float = 5e5) -> SignalColumns:
    """One sling that stands so much off the vertical."""
    tie, sling = slings(built)["loader-3.sling-1"]
    up = np.array([0.0, sling.L0 * np.sin(angle), sling.L0 * np.cos(angle)])
    at = np.array(cargo(built).lugs[tie.lug]) - tie.upper.p + up
    poses = {"block": (np.zeros((1, 3)), LEVEL[None]), "loader-3.lower": (at[None, :], LEVEL[None])}
    tensions = {sling.name: np.array([tension])}
    return SignalColumns(t=np.array([1.0]), tensions=tensions, poses=poses, hooked=[(0.0, {sling.name: tie.lug})])


def test_a_bridle_angle_beyond_45_degrees_gives_a_note_and_beyond_60_degrees_a_red_check() -> None:
    built = plan()
    for angle, severities in ((27.5, []), (44.9, []), (46.0, ["warning"]), (59.9, ["warning"]), (61.0, ["red"])):
        found = judged(built, replace(spread(built, radians(angle)), dynamic=True))
        assert [f.word for f in found] == severities, angle
        for finding in found:
            assert finding.quantity == "bridle angle"
            assert degrees(finding.value or 0.0) == pytest.approx(angle)
    assert judged(built, spread(built, radians(80.0), tension=0.0)) == [], "a slack sling may hang as it will"
    wide = plan("limits={bridle: 70 deg, bridle warning: 65 deg}")
    assert judged(wide, spread(wide, radians(61.0))) == []


def test_the_off_lead_check_reports_its_maximum_with_time_and_stage() -> None:
    built = plan()
    uses = uses_of(built, [hung(built, 1.0, 0.0)])
    row = next(
        row
        for row in table_of(checks_of(built, uses, [], {f"use of {HOOK} off-lead along": 0.01}, [])).rows
        if row[1:3] == ("off-lead along", HOOK)
    )
    assert (row[0].value, *row[1:]) == (
        "assumed",
        "off-lead along",
        HOOK,
        "1.43 deg",
        "0:07.0, swing",
        "3.00 deg",
        "48 %",
        "assumed",
    )


def test_the_off_lead_of_ropes_is_checked_in_each_state_of_the_equilibrium_path() -> None:
    """A bridle that opens as its hook comes down, under a rope that leads off: the worst is reported."""
    built = plan()
    tie, _ = slings(built)["loader-3.sling-1"]
    states = []
    for number, angle in enumerate((10.0, 50.0, 65.0, 40.0), 1):
        seen = hung(built, LENGTH * tan(radians(angle / 10)), 0.0)
        spreads = spread(built, radians(angle))
        poses = {name: (tuple(p[0]), tuple(map(tuple, R[0]))) for name, (p, R) in (seen.poses | spreads.poses).items()}
        tensions = {name: float(T[0]) for name, T in seen.tensions.items()}
        states.append(
            StaticState(
                t=0.0, action=number, stage=f"stage {number}", event="", tensions=tensions, supports={}, poses=poses,
                coordinates={}, references={}, speeds={}, hooked={tie.rope: tie.lug} if number < 4 else {},
                grounded=False, stiffness=1.0,
            )
        )  # fmt: skip
    found = findings_of(built, uses_on_path(built, states), dynamic=False)
    assert [(f.word, f.quantity, f.stage) for f in found] == [
        ("red", "bridle angle", "stage 3"),
        ("red", "off-lead along", "stage 3"),
    ]
    assert found[0].sentence.startswith("bridle angle of loader-3.sling-1 would be 65.00 deg; 60.00 deg is allowed")
    assert {f.where for f in found} == {built.actions[2].where}


def test_a_side_force_without_a_known_limit_is_shown_in_the_table_of_checks() -> None:
    built = unstated_pushes(plan())
    uses = uses_of(built, [hung(built, 0.0, LENGTH * tan(radians(2.0)))])
    table = {(row[1], row[2], row[7]): row for row in table_of(checks_of(built, uses, [], {}, []), every=True).rows}
    row = table["side force", "crane lower", "its drive moves: unknown"]
    assert row[3:7] == (f"{LOADED * sin(radians(2.0)) / 1e3:.4g} kN", "0:07.0, swing", "not known", "")
