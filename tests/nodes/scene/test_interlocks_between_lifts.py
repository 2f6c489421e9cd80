"""An interlock between two lifts of one scene: two jibs that slew towards each other stop in time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import bundled, load, parse
from heavylift.recordings import Recording

JIB = """\
heavylift: 1
name: jib
accuracy: 0.1 %
cranes:
  jib: {type: jib-60, radius: 34 m, slew: -40 deg}
actions:
  - jib: slew 2 deg/s by 40 deg
  - when: slew stopped
    wait: 1 s
"""
TWO = """\
heavylift: 1
name: two
samples: 10 Hz
lifts:
  a: {extends: jib.yaml}
  b:
    extends: jib.yaml
    at: [90 m, 0 m]
    cranes: {jib: {slew: 220 deg}}
    actions: [{jib: slew 2 deg/s by -40 deg}, {when: slew stopped, wait: 1 s}]
interlocks:
  apart: {when: gap a-jib.boom b-jib.boom <= LIMIT m, stops: [slew]}
"""


@pytest.mark.parametrize(("limit", "trips"), [(25.0, True), (60.0, True), (10.0, False)])
def test_booms_of_two_lifts_stop_before_they_come_too_near(tmp_path: Path, limit: float, trips: bool) -> None:
    """Their tips are 22 m apart when both point at each other; beyond 60 m they are never, so nothing may move."""
    (tmp_path / "jib.yaml").write_text(JIB)
    (tmp_path / "two.yaml").write_text(TWO.replace("LIMIT", f"{limit:g}"))
    if not trips:
        scene = load(tmp_path / "two.yaml")
        assert [x.name for x in scene.plan.interlocks] == ["a-jib.apart", "b-jib.apart"]
        return
    result = run(load(tmp_path / "two.yaml"), tmp_path / "run.mcap", in_process=True)
    assert result.verdict is not None
    assert "worst: the interlock a-jib.apart stopped a-jib.slewer: gap" in result.verdict.line
    rec = Recording(tmp_path / "run.mcap")
    (t, u) = sorted(e.t_ns * 1e-9 for e in rec.events() if e.type == "Tripped" and e.value["over"])[:2]
    assert t == u
    moved = [rec[f"joint/position/{x}-jib.slewing.angle"].values[-1, 0] for x in "ab"]
    assert (abs(moved[0] - np.radians(-40.0)) < 1e-9) == (limit == 60.0)


def test_an_interlock_on_the_load_of_another_lift_uses_its_load_chart(tmp_path: Path) -> None:
    (tmp_path / "jib.yaml").write_text(JIB)
    limit = "when: load of b-jib.main >= 90 %, stops: [slew], on: a-jib"
    text = TWO.replace("when: gap a-jib.boom b-jib.boom <= LIMIT m, stops: [slew]", limit)
    (tmp_path / "two.yaml").write_text(text)
    (found,) = load(tmp_path / "two.yaml").plan.interlocks
    (guard,) = found.guards
    assert (guard.quantity, guard.ropes, guard.point.body) == ("moment", ("b-jib.main",), "b-jib.main")


def test_interlocks_do_not_stop_machines_that_move_apart() -> None:
    """Two cranes of a hall on one runway, and a trolley that traverses to a post beside it: each is barred the way to
    the other alone."""
    text = bundled()["hall"].read_text(encoding="utf-8").split("actions:")[0]
    text = text.replace("cranes:\n", "cranes:\n  next: {type: overhead-100, at: 20 m, trolley: 8 m}\n")
    foot = "joints: {foot: {type: fixed, child: pole, at: [-20 m, 2 m, 0 m]}}"
    post = f"bodies: {{pole: {{mass: 1 t, box: [1 m, 1 m, 12 m]}}}}\n  {foot}"
    locks = "apart: {when: gap hall.bridge next.bridge <= 3 m, stops: [travel], towards: true}"
    near = "near: {when: gap hall.trolley pole <= 2 m, stops: [traverse], towards: true, on: hall}"
    more = f"mechanism:\n  name: post\n  {post}\ninterlocks:\n  {locks}\n  {near}\nactions:\n  - wait: 1 s\n"
    distances = {s.actuator: s.way for lock in parse(text + more, passing=True).plan.interlocks for s in lock.stops}
    assert distances == {"hall.travelling": 1, "next.travelling": -1, "hall.traversing": -1}
