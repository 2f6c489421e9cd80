"""One table states each limit with its source, or that it is unknown; path and run are checked by this table."""

import json
import random
import re
from math import radians

import numpy as np
import pytest
from heavylift.coordinator.commands.common.app import app
from heavylift.kernel import SceneError
from heavylift.kernel.description import NOT_CHECKED
from heavylift.nodes.limits import (
    Check,
    RatedLimit,
    SignalColumns,
    checks_of,
    likewise,
    percent,
    table_of,
    uses_of,
    uses_on_path,
)
from heavylift.nodes.plan import Use, plan
from heavylift.nodes.scene import check, json_schema, load
from heavylift.nodes.scene.keys import Block, Supports, comments
from heavylift.nodes.scene.keys.parts import SlingType
from heavylift.nodes.scenes import frames_folder, types_folder
from heavylift.recordings.read import RecordedVerdict
from lifting import bare, findings_of, hook_ropes

CHART = "cranes.crane.capacity chart=[[10 m, 100 t], [60 m, 400 t], [90 m, 300 t], [140 m, 120 t]]"


def peaks_alone(peaks: dict[str, tuple[float, float]]) -> SignalColumns:
    """Exact peaks [N] and when [s], and nothing else of a run."""
    return SignalColumns(t=np.zeros(1), tensions={name: np.zeros(1) for name in peaks}, peaks=peaks, dynamic=True)


def judged(peaks: dict[str, tuple[float, float]], built: plan.Plan) -> list[Check]:
    return findings_of(built, uses_of(built, [peaks_alone(peaks)]), dynamic=True)


@pytest.mark.parametrize("name", ["lift", "tandem", "turnover"])
def test_every_limit_of_a_lift_has_a_stated_source_or_is_marked_as_unknown(name: str) -> None:
    built = load(name).plan
    for limit in built.limits:
        assert bool(limit.source) == limit.known, limit
        assert limit.known or limit.note, limit
        assert re.match(r"\w[\w-]*\.yaml:\d+:\d+$", limit.where), limit
    assert {limit.quantity for limit in built.limits} >= {
        "hook load", "trolley load", "sling tension", "sling peak", "rope factor", "rope peak", "drum pull",
        "off-lead along", "off-lead across", "bridle angle", "side force", "hook height", "rope length", "rails",
        "girder", "clearance", "wind", "crane load" if name == "lift" else "tandem load",
    }  # fmt: skip
    assert plan.decode(plan.encode(built)) == built


def test_each_limit_states_the_scene_or_the_crane_type_or_an_assumption_as_its_source() -> None:
    given = ["limits={clearance: 1.5 m, off-lead along: 2 deg}", "cranes.crane.hook capacity=500 t"]
    rows = {(limit.subject, limit.quantity): limit for limit in bare("lift", given).plan.limits}
    message = {
        ("all", "clearance"): (1.5, "the scene"),
        ("crane.H1", "off-lead along"): (radians(2.0), "the scene"),
        ("crane.H1", "off-lead across"): (radians(3.0), "assumed"),
        ("crane.H1", "hook load"): (500e3, "the scene"),
        ("crane lower", "trolley load"): (450e3, "type goliath-900"),
        ("all", "wind"): (None, ""),
    }
    for key, (value, source) in message.items():
        assert rows[key].value == (pytest.approx(value) if value is not None else None), key
        assert rows[key].source == source, key


def test_every_damping_constant_is_a_key_with_a_source_or_an_assumption() -> None:
    found = {}
    for model in (SlingType, Supports, Block):
        found |= {(model.__name__, key): message for key, message in comments(model).items() if "damping" in key}
        keys = {field.alias for field in model.model_fields.values() if "damping" in str(field.alias)}
        assert keys == {key for owner, key in found if owner == model.__name__}
    assert len(found) == 2
    files = frames_folder() / "block-loader.yaml", types_folder() / "goliath-900.yaml"
    parameters = [line for file in files for line in file.read_text().partition("bodies:")[0].splitlines()]
    found |= {line.strip(): line for line in parameters if "damping:" in line}
    assert len(found) == 8
    assert all("assumed" in message for message in found.values()), found


def test_limits_of_a_scene_have_documented_keys_and_reject_wrong_units_and_ranges() -> None:
    keys = json_schema()["$defs"]["LiftLimits"]["properties"]
    assert [*keys] == [
        "off-lead", "off-lead along", "off-lead across", "clearance", "bridle warning", "bridle", "heave",
        "impact", "touch", "wind", "signals", "ropes",
    ]  # fmt: skip
    assert keys["off-lead"]["default"] == "3 deg"
    with pytest.raises(SceneError, match="unknown key 'off led'"):
        bare("lift", ["limits={off led: 2 deg}"])
    with pytest.raises(SceneError, match="an angle must be greater than zero here, not -1 deg"):
        bare("lift", ["limits={off-lead: -1 deg}"])
    with pytest.raises(SceneError, match="out of range: choose 50 % to 100 %"):
        bare("lift", ["cranes.crane.sheave efficiency=2 %"])


def test_a_load_chart_is_interpolated_between_its_points() -> None:
    draw = random.Random(8)
    for _ in range(50):
        xs = sorted(draw.sample(range(100), draw.randint(2, 6)))
        chart = tuple((float(x), draw.uniform(1, 9)) for x in xs)
        limit = RatedLimit(subject="a", quantity="hook load", unit="kg", chart=chart)
        for x in (draw.uniform(-20, 120) for _ in range(20)):
            assert limit.at(x) == pytest.approx(np.interp(x, *zip(*chart, strict=True)), rel=1e-12)


def test_the_capacity_of_a_hook_depends_on_the_trolley_position_by_the_load_chart() -> None:
    scene = bare("lift", [CHART])
    use = next(x for x in scene.uses if x.limit.quantity == "hook load" and x.limit.subject == "crane.H3")
    assert use.value == pytest.approx(170e3, rel=2e-3), "the block leans a little as ropes of two lengths give way"
    assert use.bound == pytest.approx(400e3 - 100e3 * 23 / 30), "at y = 83 m, where it goes at last"
    assert use.use == pytest.approx(170 / (400 - 100 * 23 / 30), rel=2e-3)
    with pytest.raises(
        SceneError, match=r"hook load of crane\.H3 would be 169\.8 t, 100\.\d+ %; 169\.\d t is allowed .*\(sideways\)"
    ):
        bare("lift", ["cranes.crane.capacity chart=[[0 m, 175.4 t], [81 m, 175.4 t], [141 m, 0.01 t]]"])
    with pytest.raises(SceneError, match="the places of a chart must increase, but 10 m comes after 60 m"):
        bare("lift", ["cranes.crane.capacity chart=[[60 m, 100 t], [10 m, 400 t]]"])


def test_a_sling_has_one_limit_for_its_static_load_and_one_for_its_peak_tension() -> None:
    """Its load against what it may carry, its peak against breaking force over partial factors."""
    built = bare("lift", ["rig.sling={breaking: 6 MN, factor: 5, partial factor: 3}"]).plan
    cases = {1.19e6: [], 1.26e6: ["sling tension"], 1.99e6: ["sling tension"], 2.1e6: ["sling tension", "sling peak"]}
    for peak, beyond in cases.items():
        uses = uses_of(built, [peaks_alone({"loader-1.sling-2": (peak, 12.5)})])
        assert [use.limit.quantity for use in uses if use.beyond and "sling" in use.limit.quantity] == beyond
    message = [f.sentence for f in judged({"loader-1.sling-2": (2.1e6, 12.5)}, built)]
    assert message == [
        "sling peak of loader-1.sling-2 was 2100 kN, 105 %; 2000 kN is allowed (the scene)",
        "sling tension of loader-1.sling-2 was 2100 kN, 175 %; 1200 kN is allowed (the scene)",
    ]


def test_one_finding_shows_the_first_exceeded_sling_and_names_the_other_exceeded_slings() -> None:
    built = bare("lift").plan
    peaks = {f"loader-{i}.sling-1": (1.3e6, 5.0) for i in (1, 2, 3)}
    (message,) = likewise(judged(peaks, built))
    assert message.sentence.endswith("; likewise loader-2.sling-1, loader-3.sling-1")
    assert message.state == "red"


def test_a_load_cell_beyond_its_limit_between_samples_gives_a_red_check() -> None:
    """The sum of three ropes is only sampled; the cell saw it pass its rated value."""
    built = bare("lift").plan
    rated = (900e3 + 75e3) * built.gravity
    ropes = {name: np.array([0.3 * rated]) for name in hook_ropes(built)}
    quiet = SignalColumns(t=np.array([3.0]), tensions=ropes, dynamic=True)
    assert not [f for f in findings_of(built, uses_of(built, [quiet]), dynamic=True) if f.subject == "crane"]
    heard = SignalColumns(
        t=np.array([3.0]), tensions=ropes, dynamic=True, crossings={"crane.main.load": (1.001 * rated, 3.2)}
    )
    (red,) = [f for f in findings_of(built, uses_of(built, [heard]), dynamic=True) if f.subject == "crane"]
    assert (red.word, red.t, red.sentence) == (
        "red",
        3.2,
        "crane load of crane was 901.0 t, 100.11 %; 900.0 t is allowed (type goliath-900)",
    )


def test_an_overload_along_the_equilibrium_path_gives_a_red_check_with_stage_and_line_of_its_order() -> None:
    scene = bare("lift", ["rig.loaders.loader-3.capacity=140 t"])
    (red,) = findings_of(scene.plan, uses_on_path(scene.plan, scene.states), dynamic=False)
    assert (red.word, red.subject, red.stage) == ("red", "loader-3", "up")
    assert red.where == "lift.yaml:38:5", "where it carries most"
    message = "loader load of loader-3 would be 1469 kN, 107 %; 1373 kN is allowed (the scene)"
    assert f"red: {message}, at 0:45 (up) [lift.yaml:38:5]" in str(check(scene)), "in the words of a run"
    assert findings_of(bare("lift").plan, uses_on_path(bare("lift").plan, bare("lift").states), dynamic=False) == []


def test_a_position_may_exceed_its_end_position_by_a_small_tolerance() -> None:
    built = bare("lift").plan
    for beyond, red in ((0.0, False), (0.04, False), (0.06, True)):
        at = np.array([[400.0 + beyond, 0.0, 0.0]])
        signals = SignalColumns(t=np.zeros(1), tensions={}, poses={"crane.main": (at, np.eye(3)[None])}, dynamic=True)
        message = [f.sentence for f in findings_of(built, uses_of(built, [signals]), dynamic=True)]
        assert message == (
            ["place on its rails of crane was 400.06 m; 0 to 400 m is allowed (type goliath-900)"] if red else []
        )


def test_a_scene_can_limit_the_rope_tensions_of_a_mechanism() -> None:
    given = "limits={ropes: {fall-1: {tension: 400 kN}, fall-2: {breaking: 2 MN, factor: 4, source: certificate 7}}}"
    built = load("trolley", [given]).plan
    assert [(x.subject, x.value, x.factor, x.source) for x in built.limits] == [
        ("fall-1", 400e3, 1.0, "the scene"),
        ("fall-2", 500e3, 4.0, "certificate 7"),
    ]
    found = judged({"fall-1": (480e3, 3.0), "fall-2": (480e3, 3.0)}, built)
    assert [f.sentence for f in found] == ["rope tension of fall-1 was 480 kN, 120 %; 400 kN is allowed (the scene)"]
    checks = load("trolley", ["limits={ropes: {fall-1: {tension: 400 kN}}}"]).checks
    message = [check.sentence for check in checks if check.quantity == "rope tension" and check.why == NOT_CHECKED]
    assert message == ["rope tension of fall-2: give it under 'limits: {ropes: ...}'"]
    with pytest.raises(SceneError, match=r"limits.ropes.fall-3: there is no rope 'fall-3'"):
        load("trolley", ["limits={ropes: {fall-3: {tension: 1 kN}}}"])
    with pytest.raises(SceneError, match="give a rope either a 'tension' or a 'breaking' force"):
        load("trolley", ["limits={ropes: {fall-1: {factor: 5}}}"])


def test_checks_are_exported_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    app(["check", "lift", "--json", "--set", "rig.loaders.loader-3.capacity=140 t"], standalone_mode=False)
    message = json.loads(capsys.readouterr().out)
    rows = {(row["limit"]["subject"], row["limit"]["quantity"]): row for row in message["uses"]}
    row = rows["crane.H3", "rope factor"]
    assert (row["limit"]["value"], row["limit"]["breaking"], row["stage"]) == (5.6, 1351e3, "lift off")
    assert row["value"] == pytest.approx(12.35, abs=0.005)
    found = [row for row in message["verdict"]["checks"] if row["state"] == "red"]
    assert [(row["quantity"], row["subject"]) for row in found] == [("loader load", "loader-3")]
    assert (message["verdict"]["state"], message["verdict"]["red"]) == ("red", True)
    assert message["verdict"].keys() <= {*RecordedVerdict.__struct_fields__}, "in the words of a run"


def test_a_utilisation_near_its_limit_is_not_rounded_to_100_percent() -> None:
    uses = (0.123, 0.9949, 0.9951, 0.9999, 1.0, 1.0001, 1.004, 1.006)
    message = ["12 %", "99 %", "99.51 %", "99.99 %", "100 %", "100.01 %", "100.40 %", "101 %"]
    assert [percent(use) for use in uses] == message


def test_the_part_that_a_check_names_does_not_depend_on_rounding() -> None:
    """Of subjects that are loaded alike the first is reported, and a force below a newton is none."""
    limits = [RatedLimit(subject=name, quantity="side force", unit="N", value=1e5) for name in ("east", "west")]

    def message(*uses: Use) -> tuple[str, ...]:
        row = next(x for x in table_of(checks_of(bare("lift").plan, uses, [], None, [])).rows if x[1] == "side force")
        return row[2:4]

    for tiny in (0.0, 2e-4, -2e-4):
        assert message(Use(limits[0], 5e4, 1.0), Use(limits[1], 5e4 + tiny, 2.0)) == ("east (of 2)", "50 kN")
        assert message(Use(limits[0], abs(tiny), 1.0), Use(limits[1], 3e-4, 2.0)) == ("east (of 2)", "0 kN")
    assert message(Use(limits[0], 5e4, 1.0), Use(limits[1], 5e4 + 1.0, 2.0))[0] == "west (of 2)"
