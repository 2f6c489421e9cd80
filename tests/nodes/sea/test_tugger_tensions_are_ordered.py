"""The tension of a tugger line follows orders at a stated rate: at rest, in a run, in its checks and in a replay."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from heavylift.coordinator.commands.common.app import app
from heavylift.coordinator.record import play
from heavylift.coordinator.replay import RecordedRun
from heavylift.coordinator.run.verify import verify
from heavylift.kernel import SceneError
from heavylift.nodes.limits import uses_on_path
from heavylift.nodes.scene import LoadedScene, parse
from heavylift.nodes.statics import follow
from test_tugger_lines_limit_a_swing import LINE, SCENE
from typer.testing import CliRunner

sys.path.insert(0, str(Path(__file__).parents[2] / "coordinator" / "verdict"))
from lift_of_a_type import TYPES, begun

CLOSE = 1e-3  # [N] of a tension of some kN, from a profile that is exact
PULL = "  - {stage: pull, port: pull 0.5 kN/s to 6 kN}\n"


def scene(orders: str = PULL, **lines: Any) -> LoadedScene:
    return parse(text_of(orders, **lines))


def text_of(orders: str = PULL, spread: float = 0.5, capacity: str = "7 kN", rate: str = "rate: 2 kN/s, ") -> str:
    lines = (("port", 30, 2), ("starboard", -30, -2))
    forces = ", ".join(LINE % (name, far, near, spread, capacity) for name, far, near in lines)
    head, hanging = SCENE.split("  - {stage: hanging, ")
    text = head % forces.replace("tension: ", f"{rate}tension: ")
    return f"{text}{orders}  - {{stage: hanging, {hanging.replace('40 s', '2 s')}"


def at_end(of: LoadedScene) -> dict[str, float]:
    """Tensions [N] of both lines at the end of the path at rest."""
    last = follow(of.plan).states[-1]
    return {name: last.tensions[name] for name in ("port", "starboard")}


@pytest.mark.parametrize(
    ("orders", "port", "starboard"),
    [
        (PULL, 6e3, 4e3),
        ("  - {stage: pull, port: pull 2 kN/s by -3 kN, starboard: pull 60 kN/min by 1.5 kN}\n", 1e3, 5.5e3),
        ("  - {stage: pull, port: pull 1 kN/s to 0 kN}\n", 0.0, 4e3),
        ("  - {stage: pull, port: pull 1 kN/s by -4 kN}\n", 0.0, 4e3),
        ("  - {port: pull 1 kN/s to 6 kN}\n  - {stage: pull, port: release}\n  - {wait: 1 s}\n", 0.0, 4e3),
    ],
)
def test_the_tension_at_rest_after_an_order_is_the_ordered_one(orders: str, port: float, starboard: float) -> None:
    found = at_end(scene(orders))
    assert found == {"port": pytest.approx(port, abs=CLOSE), "starboard": pytest.approx(starboard, abs=CLOSE)}


def test_the_tension_in_a_run_rises_at_the_ordered_rate() -> None:
    """Without a spread it is the ordered tension at each instant: 0.5 kN/s with ramps of 4 kN/s2, from 4 to 6 kN."""
    of = scene(spread=0.0)
    run = play(of.plan)
    past, begin = run.past.part(0, len(run.t)), next(t for t, _, name in run.conduct.stages if name == "pull")
    t = past.t - begin
    ramp, rate = 0.5e3 / 4e3, 0.5e3
    lasts = 2e3 / rate + ramp
    want = 4e3 + np.interp(t, [ramp / 2.0, lasts - ramp / 2.0], [0.0, 2e3])
    ramps = (np.abs(t - ramp / 2.0) < ramp) | (np.abs(t - lasts + ramp / 2.0) < ramp)
    assert past.tensions["port"][~ramps] == pytest.approx(want[~ramps], abs=CLOSE)
    assert np.abs(past.tensions["port"] - want)[ramps].max() <= rate * ramp / 8.0 + CLOSE
    assert set(past.tensions["starboard"]) == {4e3}
    (row,) = [x for x in run.judge.fine[1] if (x.limit.subject, x.limit.quantity) == ("port", "rope tension")]
    assert (row.value, row.use) == (pytest.approx(6e3), pytest.approx(6.0 / 7.0))


def test_the_block_is_pulled_aside_by_the_difference_of_the_tensions() -> None:
    """2 kN more to port, on 20 t under 40 to 60 m of rope and slings: by 0.4 to 0.6 m."""
    before, after = (
        [x for x in follow(scene().plan).states if x.stage == stage][-1].poses["block"][0] for stage in ("slew", "pull")
    )
    assert 0.4 < after[1] - before[1] < 0.6


def test_a_tension_that_is_ordered_above_the_capacity_of_the_winch_is_refused() -> None:
    with pytest.raises(SceneError, match=r"rope tension of port would be 6 kN, 120 %; 5 kN is allowed"):
        scene(capacity="5 kN")


@pytest.mark.parametrize(
    ("orders", "rate", "words"),
    [
        (PULL, "", "'port' cannot pull"),
        (PULL.replace("0.5 kN/s", "2.1 kN/s"), "rate: 2 kN/s, ", "'port' can pull at 2 kN/s at most"),
        (PULL.replace("0.5 kN/s", "0.5 m/s"), "rate: 2 kN/s, ", "rate of tension"),
        (PULL.replace("6 kN", "6 m"), "rate: 2 kN/s, ", "not a valid force"),
        (PULL.replace("pull 0.5 kN/s to 6 kN", "hoist 1 m/min by 1 m"), "rate: 2 kN/s, ", "'port' cannot hoist"),
        (PULL.replace("6 kN", "-1 kN"), "rate: 2 kN/s, ", "'port' is a line, which cannot push"),
        (
            PULL.replace("to 6 kN", "by -6 kN"),
            "rate: 2 kN/s, ",
            r"scene.yaml:\d+:\d+: .*'port' has 4 kN, and 'by -6 kN' leaves less than 0 kN: a line cannot push",
        ),
        (
            PULL + PULL.replace("stage: pull, ", "").replace("to 6 kN", "by -6.1 kN"),
            "rate: 2 kN/s, ",
            r"'port' has 6 kN, and 'by -6.1 kN'",
        ),
        ("", "rate: -2 kN/s, ", "rate"),
    ],
)
def test_impossible_orders_to_a_tugger_line_are_refused_in_one_sentence(orders: str, rate: str, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        scene(orders, rate=rate)


@pytest.mark.parametrize("order", ["release", "unhook"])
def test_a_line_that_was_released_is_not_ordered_to_pull(order: str) -> None:
    with pytest.raises(SceneError, match=r"'port' was released by an earlier order"):
        scene(f"  - {{stage: let go, port: {order}}}\n{PULL}")


@pytest.mark.parametrize(("given", "good"), [("tension: 7 kN", True), ("breaking: 60 kN, factor: 2", False)])
def test_a_stated_limit_of_a_line_is_not_above_its_capacity(given: str, good: bool) -> None:
    text = f"{text_of()}limits: {{ropes: {{port: {{{given}, source: a certificate}}}}}}\n"
    if good:
        parse(text)
    else:
        with pytest.raises(SceneError, match=r"scene.yaml:\d+:\d+: .*30 kN is more than the 7 kN of the line itself"):
            parse(text)


def test_a_run_with_ordered_tensions_is_reproduced_from_its_recording(tmp_path: Path) -> None:
    (tmp_path / "tugged.yaml").write_text(text_of())
    done = CliRunner().invoke(app, ["run", str(tmp_path / "tugged.yaml"), "-o", str(tmp_path / "run.mcap")])
    assert done.exit_code in (0, 1), done.output
    assert verify(RecordedRun(tmp_path / "run.mcap")).same


@pytest.mark.parametrize("crane", TYPES)
def test_a_tag_line_on_the_load_of_any_crane_is_pulled_by_order(
    crane: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text, (half, x, y) = begun(crane, tmp_path)
    ends = f"start: {{body: world, at: [{x + half + 40} m, {y} m, 1 m]}}, end: {{body: block, at: [{half} m, 0, 0]}}"
    line = f"{{type: tugger line, {ends}, tension: 2 kN, rate: 1 kN/s, spread: 0.3, capacity: 9 kN}}"
    text = text[: text.index("  - stage: down")] + "  - {stage: pull, tug: pull 0.5 kN/s to 4 kN}\n"
    of = parse(f"{text}mechanism: {{name: tuggers, forces: {{tug: {line}}}}}\n", str(tmp_path / "made.yaml"), [])
    rows = uses_on_path(of.plan, list(follow(of.plan).states))
    (use,) = [u for u in rows if (u.limit.subject, u.limit.quantity) == ("tug", "rope tension")]
    assert (use.value, use.use) == (pytest.approx(4e3, abs=CLOSE), pytest.approx(4.0 / 9.0))
    run = play(of.plan)
    tension = run.past.part(0, len(run.t)).tensions["tug"]
    assert tension[0] == pytest.approx(2e3, rel=0.01)
    assert tension[-1] == pytest.approx(4e3, rel=0.3)
