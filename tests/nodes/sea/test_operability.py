"""How high a sea may be: limits and operability over seeds, against motions that are proportional to the sea."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import pytest
from heavylift.coordinator.sweeps import ScatterTable, SeaRuns, limits_of, operability_sheet, sea_of
from heavylift.kernel import SceneError
from heavylift.nodes.scene import parse

SCENE = """\
heavylift: 1
name: sea
end: 30 s
samples: 5 Hz
method: dopri5
waves: {seas: {wind: {Hs: 0.5 m, Tp: 8 s, components: 20}}, heading: 150 deg, ramp: 10 s}
limits: {signals: [height of barge <= 0.05 m]}
vessels:
  barge:
    mass: 14432 t
    type: barge-110
    com: [0 m, 0 m, 2 m]
    floating: {mooring: {surge: 400 kN/m, sway: 400 kN/m, yaw: 400 MN m/rad}}
actions: [{wait: 1 s}]
"""
LINEAR = 0.02  # what the barge does not do in proportion to the sea, and the last step of the search
TABLE = "Hs \\ Tp, 6, 8, 10\n1, 10, 20, 5\n2, 20, 30,\n3, 10, 5, 0\n"


def test_in_the_highest_allowed_sea_the_confidence_bound_of_the_load_quantile_equals_the_limit() -> None:
    """The heave of the barge is proportional to the sea, and so is the bound of its P90."""
    with ThreadPoolExecutor(1) as pool:
        runs = SeaRuns(parse(SCENE), range(1, 11), 60.0, pool)
        (name,) = (x for x in runs.row([]) if x.startswith("use/"))
        use = runs.row([])[name]
        found = limits_of(runs.scene, "waves.seas.wind.Hs=0.1..4 m", fails="undecided", seas=runs)
    assert found.green == pytest.approx(0.5 / use, rel=LINEAR)
    assert found.runs[found.green][name] < 1.0 < found.runs[found.red][name]


def test_the_longest_allowed_wave_period_is_where_a_scan_over_periods_reaches_the_limit() -> None:
    """A longer sea heaves the barge more; at the period that is found, half a metre is the highest sea, too."""
    with ThreadPoolExecutor(1) as pool:
        runs = SeaRuns(parse(SCENE), range(1, 11), 60.0, pool)
        (name,) = (x for x in runs.row([]) if x.startswith("use/"))
        scan = [runs.row([f"waves.seas.wind.Tp={T} s"])[name] for T in range(5, 10)]
        found = limits_of(runs.scene, "waves.seas.wind.Tp=5..10 s", fails="undecided", seas=runs)
        there = runs.row([f"waves.seas.wind.Tp={found.green!r} s", "waves.seas.wind.Hs=1 m"])[name]
    assert scan == sorted(scan)
    assert 4 + sum(use < 1.0 for use in scan) < found.green < found.red < 5 + sum(use < 1.0 for use in scan)
    assert there == pytest.approx(2.0, rel=LINEAR)


class _Fake(SimpleNamespace):
    """Runs of a lift that passes up to Hs = 0.3 Tp, and that counts them."""

    def row(self, settings: list[str]) -> dict[str, object]:
        Hs, Tp = (float(x.partition("=")[2].split()[0]) for x in settings)
        assert [x.partition("=")[0] for x in settings] == ["waves.seas.wind.Hs", "waves.seas.wind.Tp"]
        self.count.append((Hs, Tp))
        state = "amber" if Hs <= 0.3 * Tp else "undecided"
        return {"status": "done", "state": state, "verdict": state, "sentence": "", "use": Hs / Tp, "limit": "heave"}


def test_the_operability_is_the_share_of_sea_states_in_which_a_lift_passes_its_checks(tmp_path: Path) -> None:
    (tmp_path / "scatter.csv").write_text(TABLE)
    runs = _Fake(count=[], seeds=range(10))
    sheet = operability_sheet(
        parse(SCENE), ScatterTable.read(tmp_path / "scatter.csv"), "wind", runs, lambda text: None
    )
    assert sheet.lead == "GREEN: the lift may be done in 65.0 % of the time (65 of 100 occurrences)"
    assert [row[:2] for row in sheet.tables[0].rows] == [(6.0, 1.0), (8.0, 2.0), (10.0, 1.0)]
    assert (3.0, 10.0) not in runs.count, "no sea is run that never occurs, nor one above it"


BAD = {
    "": "not a scatter table of numbers",
    "Hs,6\n1,-1\n": "not negative",
    "Hs,6\n1,0\n": "not all zero",
    "Hs,6,8\n1,2\n": "one number for each of 2 periods",
    "Hs,8,6\n1,2,3\n": "ascending order",
    "Hs,6\n1,many\n": "not a scatter table of numbers",
}


@pytest.mark.parametrize("text", BAD)
def test_a_table_that_is_no_scatter_table_is_refused_in_one_sentence(text: str, tmp_path: Path) -> None:
    (tmp_path / "scatter.csv").write_text(text)
    with pytest.raises(SceneError, match=BAD[text]):
        ScatterTable.read(tmp_path / "scatter.csv")


def test_operability_varies_the_named_sea_or_the_only_sea_of_the_scene() -> None:
    assert sea_of(parse(SCENE), "") == sea_of(parse(SCENE), "waves.seas.wind") == "wind"
    with pytest.raises(SceneError, match=r"seas: waves.seas.wind"):
        sea_of(parse(SCENE), "waves.seas.swell")
