"""A lift beside an idle crane with two empty lifting beams: the idle crane costs almost nothing and changes nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from heavylift.coordinator.participants import KernelNode, RowSink, Session
from heavylift.coordinator.record import boxes
from heavylift.coordinator.run import run
from heavylift.kernel.islands import Islands
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.devs import Tag, seconds
from heavylift.nodes.scene import LoadedScene, bundled, parse
from lifting import unstated

END = 45.0  # [s] the block is in the air by then
SECOND = 1_000_000_000
APART = 1e-5  # relative: tolerance 1e-6 [1 %], two ways of stepping
CRANE = "  crane: {type: goliath-900, at: 40 m}"
LOADER = "    loader-3: {hook: crane H3, sling: 10 m, lugs: [R1, R2]}"
IDLE = "  idle: {type: goliath-900, at: 120 m}"
EMPTY = """
    loader-4: {hook: idle H1, sling: 10 m}
    loader-5: {hook: idle H2, sling: 10 m}
  groups:
    working: [crane H1, crane H2, crane H3]"""


def scene(islands: str = "apart", end: float = END) -> LoadedScene:
    given = unstated(bundled()["lift"].read_text())
    assert given.count(CRANE) == given.count(LOADER) == 1
    given = given.replace(CRANE, f"{CRANE}\n{IDLE}").replace(LOADER, LOADER + EMPTY)
    given = given.replace("all hooks:", "working hooks:").replace("all slings", "all working slings")
    given = given.replace("    trolleys:", "    crane upper trolley:")
    return parse(given, overrides=[f"end={end} s", f"fidelity.islands={islands}"])


def simulated(islands: str = "apart") -> Simulation | Islands:
    plan = scene(islands).plan
    session = Session(plan, lambda config: KernelNode(config, RowSink()), end=Tag(seconds(END)))
    session.kernel._flush = lambda *least: None  # type: ignore[method-assign]
    session.advance()
    return session.kernel.simulation


def cost(*parts: Simulation) -> float:
    """Operations: attempted steps times those of one evaluation."""
    return sum((p["accepted"] + p["rejected"]) * p.native.method.f_rate.operations for p in parts)


def test_an_idle_crane_takes_almost_no_computing_time_and_does_not_change_the_lift() -> None:
    two, whole = simulated(), simulated("together")
    assert isinstance(two, Islands)
    assert isinstance(whole, Simulation)
    working, idle = two.parts
    assert [x.name for x in idle.given.bodies][:3] == ["idle.lower", "idle.main", "idle.upper"]
    assert cost(idle) < 1e-3 * cost(working)
    assert cost(*two.parts) < 0.7 * cost(whole)
    # the empty hooks hang at their upper limit switches: whether these are reached is a matter of the last bit
    ends = [{e.name: e.what for _, e in x.log if e.name.split(".")[0] != "idle"} for x in (two, whole)]
    assert ends[0] == ends[1]
    same, expected = (dict(x.rows)[44 * SECOND] for x in (two, whole))
    for group in ("tension", "poses", "potential"):
        at = whole.method.row_layout.at[group]
        assert np.abs(same[at] - expected[at]).max() < APART * np.abs(expected[at]).max(), group


def test_a_lift_beside_an_idle_crane_is_the_same_in_one_process_and_in_ten(tmp_path: Path) -> None:
    together = run(scene(), tmp_path / "together.mcap", in_process=True)
    apart = run(scene(), tmp_path / "apart.mcap")
    assert apart.digest == together.digest
    assert together.energy_error < 1e-6


def test_an_idle_crane_without_a_load_is_drawn_with_its_main_body_and_both_trolleys() -> None:
    plan = parse(unstated(bundled()["lift"].read_text()).replace(CRANE, f"{CRANE}\n{IDLE}")).plan
    drawn = boxes(plan)
    assert {"idle.main", "idle.upper", "idle.lower"} <= {box.body for box in drawn}
