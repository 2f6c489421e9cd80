"""An interlock stops a machine at the end of its load chart, allows unloading moves, and a bypass is recorded."""

from __future__ import annotations

from math import acos, degrees, hypot, radians
from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.kernel import SceneError
from heavylift.nodes.scene import LoadedScene, load, parse
from heavylift.recordings import Recording
from heavylift.recordings.read import recorded_verdict

RADIUS, BOOM, FOOT = 18.0, 42.0, 1.5  # beyond it the chart allows 62.5 t, and 63 t hang; of crawler-250 [m]
AHEAD = 0.2  # [deg] of the boom: the hook swings ahead of its tip by a tenth of a metre
RATE, EMERGENCY = radians(0.3), radians(0.5)
STOPPED = "the interlock crawler.moment stopped crawler.main, crawler.luffer: moment of main >= 100 %"
UP = ("crawler main: hoist 1 m/min until lifted", "crawler main: hoist 4 m/min by 1 m")
OUT = "crawler: luff 0.3 deg/s by -3 deg"


def crawler(*actions: str, more: str = "") -> LoadedScene:
    """The bundled crawler with its boom at 17 m and another action list."""
    listed = "".join(f"  - {action}\n" for action in actions)
    place = "block: {at: [17 m, 0 m, 2 m]}\ncranes: {crawler: {radius: 17 m}}\n"
    return parse(f"extends: crawler\nname: crawler\n{place}{more}actions:\n{listed}", "scene.yaml", passing=True)


def recorded(scene: LoadedScene, folder: Path) -> Recording:
    run(scene, folder / "run.mcap", in_process=True)
    return Recording(folder / "run.mcap")


def said(rec: Recording, kind: str) -> list[tuple[float, dict[str, object]]]:
    return [(e.t_ns * 1e-9, e.value) for e in rec.events() if e.type == kind]


def findings(rec: Recording) -> list[str]:
    found = recorded_verdict(rec)
    return [x.sentence for x in found.findings if x.quantity in ("interlock", "bypass")] if found else []


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return recorded(load("crawler", ["samples=50 Hz"]), tmp_path_factory.mktemp("crawler"))


def test_the_load_chart_interlock_stops_the_boom_at_the_last_allowed_radius(whole: Recording) -> None:
    (t, _), *_ = said(whole, "Tripped")
    pose = whole["pose/crawler.main"]
    x, y = (np.interp(t, pose.t, pose.values[:, i]) for i in (0, 1))
    assert hypot(x, y) == pytest.approx(RADIUS, abs=1e-4)
    angle = whole["joint/position/crawler.luffing.angle"]
    rest = t + RATE / EMERGENCY
    before, after = (np.interp(s, angle.t, angle.values[:, 0]) for s in (t, rest))
    assert before - after == pytest.approx(RATE**2 / (2 * EMERGENCY), abs=5e-6)
    assert degrees(before) == pytest.approx(degrees(acos((RADIUS - FOOT) / BOOM)), abs=AHEAD)


def test_luffing_in_resets_the_load_chart_interlock_so_that_the_module_can_be_set_down(whole: Recording) -> None:
    trips = [(value["over"], value["bypassed"]) for _, value in said(whole, "Tripped")]
    assert trips[0] == (True, False)
    assert trips[-1] == (False, False)
    assert said(whole, "Landed")
    assert whole.result["status"] == "finished"
    assert findings(whole) == [
        "the interlock crawler.moment stopped crawler.main, crawler.luffer: moment of main >= 100 %"
    ]


def test_the_command_check_reports_that_the_load_chart_interlock_stops_the_boom() -> None:
    message = [f.sentence for f in load("crawler").findings if f.quantity == "interlock"]
    assert message == [STOPPED]


def test_a_tripped_interlock_blocks_hoisting_and_luffing_out_but_not_lowering(tmp_path: Path) -> None:
    more = ("{when: luff stopped, crawler main: hoist 1 m/min by 0.5 m, crawler: luff 0.3 deg/s by -1 deg}",)
    scene = crawler(*UP, OUT, *more, "{when: moves stopped, crawler main: lower 1 m/min by 0.5 m}")
    rec = recorded(scene, tmp_path)
    limits = [(value["actor"], value["limit"]) for _, value in said(rec, "Limit")]
    why = "interlock crawler.moment"
    assert sorted(limits) == [("crawler.luffer", why), ("crawler.luffer", why), ("crawler.main", why)]
    assert rec.result["status"] == "finished"


def test_a_bypassed_interlock_is_reported_and_stops_nothing(tmp_path: Path) -> None:
    rec = recorded(crawler(*UP, "crawler moment: bypass", OUT, "crawler moment: restore"), tmp_path)
    would = STOPPED.replace("stopped", "would have stopped, had it not been bypassed,")
    assert findings(rec) == [would, STOPPED, "the interlock crawler.moment was bypassed"], "restored, it stops again"
    assert not [value for _, value in said(rec, "Limit") if value["actor"] == "crawler.luffer"]


def test_a_load_beyond_the_load_chart_is_refused_if_no_interlock_stops_the_crane() -> None:
    with pytest.raises(SceneError, match=r"would be 42\.3 t, 176 %; 24\.0 t is allowed"):
        parse("extends: jib\nname: jib\nblock: {mass: 40 t}\n", "scene.yaml", passing=True)


BAD = {  # an interlock of the scene, and what is reported of it
    "{when: all slings taut, stops: [hoist]}": "an interlock watches one measured quantity, such as",
    "{when: load of crawler >= 3 t and wind >= 3 m/s, stops: all}": "an interlock watches one measured quantity",
    "{when: load of crawler >= 3 t}": "an interlock needs an effect: add 'stops' or 'tells'",
    "{when: load of crane >= 3 t, stops: all}": "there is no 'crane' with load",
    "{when: load of crawler >= 3 t, stops: [host]}": "did you mean 'hoist'?",
    "{when: load of crawler >= 3 t, stops: [luff up]}": "nothing can 'luff up'",
    "{when: load of crawler >= 3 t, stops: [travel], on: crawler}": "'crawler' has nothing that can travel",
    "{when: load of crawler >= 3 t, stops: all, on: crane}": "there is no machine 'crane' with drives or winches",
    "{when: load of crawler >= 3 t, stops: all, until: wind <= 3 m/s}": "reset by the quantity that trips it: write",
    "{when: load of crawler >= 3 t, stops: all, until: load of crawler >= 2 t}": "it would be reset where it trips",
    "{when: load of crawler >= 3 t, stops: all, until: load of crawler <= 4 t}": "it would be reset where it trips",
    "{when: load of crawler >= 3 t, stops: [hoist], towards: true}": "it is known of a gap between two machines",
    "{when: load of crawler >= 3 m, stops: all}": "'3 m' is not a valid mass",
    "{when: wind >= 3 m/s, stops: all}": "no wind blows in this scene: add 'wind'",
    "{when: load of crawler >= 3 t, halts: all}": "unknown key 'halts'",
    "{when: load of crawler >= 3 t, stops: all, deceleration: 1 deg/s2}": "'1 deg/s2' is not a valid acceleration",
}
ORDERS = {
    "crawler moment: by pass": "an order begins with a verb, not 'by'",
    "crawler moment: hoist 1 m/min by 1 m": "it can: bypass, restore",
    "crawler main: bypass": "'crawler main' cannot bypass",
    "crawler luffer: stop ramp 1 m/s2": "'crawler.luffer' turns: write degrees or radians, not metres",
    "crawler: stop 1 m/s2": "nothing can follow 'stop'",
}


@pytest.mark.parametrize(("given", "told"), BAD.items())
def test_an_invalid_interlock_is_reported_with_its_line_in_the_scene(given: str, told: str) -> None:
    with pytest.raises(SceneError) as error:
        crawler("wait: 1 s", more=f"interlocks:\n  limit: {given}\n")
    assert told in str(error.value)
    assert "scene.yaml:6:" in str(error.value)


@pytest.mark.parametrize(("order", "told"), ORDERS.items())
def test_an_invalid_order_to_an_interlock_is_reported_with_its_line_in_the_scene(order: str, told: str) -> None:
    with pytest.raises(SceneError) as error:
        crawler(order)
    assert told in str(error.value)
    assert "scene.yaml:6:" in str(error.value)
