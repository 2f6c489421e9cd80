"""Responses of a vessel out of a table by period and heading: interpolated as complex numbers, faults told by cell."""

from __future__ import annotations

import cmath
from pathlib import Path

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.scene import load
from heavylift.nodes.scene.keys import Responses

HEAD = "draught,heading [deg],period [s],surge [m/m],surge phase [deg],roll [deg/m],roll phase [deg],from\n"
ROWS = {  # by heading [deg] and period [s]: surge and roll
    (150, 8): (0.25, 90, 1.1, -70), (150, 10): (0.4, 80, 2.0, -100),
    (180, 8): (0.3, 95, 0.0, 0), (180, 10): (0.5, 85, 0.1, 170),
}  # fmt: skip
TABLE = HEAD + "".join(
    f"{name},{h},{T},{','.join(str(x * (2 if name == 'light' else 1)) for x in row)},made up\n"
    for name in ("loaded", "light") for (h, T), row in ROWS.items()
)  # fmt: skip
SCENE = """
heavylift: 1
name: sea
end: 20 s
waves: {height: 2 m, period: %s, heading: %s, ramp: 10 s}
vessels:
  barge:
    mass: 13200 t
    size: [110 m, 32 m, 8 m]
    draught: 4.5 m
    heading: %s
    responses from: barge.csv#loaded
actions: [{wait: 1 s}]
"""


def answered(folder: Path, period: str, heading: str = "150 deg", bow: str = "0 deg", table: str = TABLE) -> Responses:
    (folder / "barge.csv").write_text(table)
    (folder / "sea.yaml").write_text(SCENE % (period, heading, bow))
    found = load(folder / "sea.yaml").scene.vessels["barge"].responses
    assert found is not None
    return found


def expected(h: int, T: int) -> list[complex]:
    a, p, b, q = ROWS[h, T]
    return [cmath.rect(a, cmath.pi * p / 180), cmath.rect(b * cmath.pi / 180, cmath.pi * q / 180)]


def told(found: Responses) -> list[complex]:
    return [cmath.rect(*x) for x in (found.surge, found.roll)]


def test_vessel_responses_at_table_rows_have_their_stated_values(tmp_path: Path) -> None:
    assert told(answered(tmp_path, "8 s")) == pytest.approx(expected(150, 8), abs=1e-15)


@pytest.mark.parametrize(("heading", "bow"), [("160 deg", "0 deg"), ("-160 deg", "40 deg"), ("250 deg", "90 deg")])
def test_vessel_responses_between_table_rows_are_interpolated_in_amplitude_and_phase(
    tmp_path: Path, heading: str, bow: str
) -> None:
    """By period and by the direction against the bow: here a quarter and a third of the way."""
    corners = [[expected(h, T) for T in (8, 10)] for h in (150, 180)]
    along = [[a + 0.25 * (b - a) for a, b in zip(*pair, strict=True)] for pair in corners]
    want = [a + (b - a) / 3 for a, b in zip(*along, strict=True)]
    assert told(answered(tmp_path, "8.5 s", heading, bow)) == pytest.approx(want, abs=1e-12)


def test_keys_of_the_scene_override_a_vessel_table(tmp_path: Path) -> None:
    (tmp_path / "barge.csv").write_text(TABLE)
    text = SCENE % ("8 s", "150 deg", "0 deg")
    own = text.replace("    responses from", "    responses: {surge: [0.7 m/m, 0 deg]}\n    responses from")
    (tmp_path / "sea.yaml").write_text(own)
    found = load(tmp_path / "sea.yaml").scene.vessels["barge"].responses
    assert found is not None
    assert found.surge == (0.7, 0.0)
    assert told(found)[1] == pytest.approx(expected(150, 8)[1])


def test_wave_loads_on_a_free_vessel_can_come_from_a_table(tmp_path: Path) -> None:
    (tmp_path / "loads.csv").write_text("period [s];heave [MN/m];heave phase [deg]\n6;4;0\n8;9;20\n")
    text = SCENE % ("8 s", "150 deg", "0 deg")
    floating = "motion: forces\n    floating: {waterplane: 3200 m2, GM: 5 m, GML: 180 m, loads from: loads.csv}"
    (tmp_path / "sea.yaml").write_text(text.replace("responses from: barge.csv#loaded", floating))
    loaded = load(tmp_path / "sea.yaml").scene.vessels["barge"].floating
    assert loaded is not None
    assert loaded.loads.heave == pytest.approx((9e6, 20 * cmath.pi / 180))


BAD = {
    ("12 s", TABLE): "barge.csv covers waves with a period of 8 s to 10 s, but the wave of the scene has 12 s",
    ("8 s", TABLE.replace("loaded", "empty")): "barge.csv has no row 'loaded'",
    ("8 s", HEAD): "barge.csv has no row 'loaded'",
    ("8 s", TABLE.replace("0.25", "0.2x")): "barge.csv:2:14: error: vessels.barge.responses.surge: '0.2 m/m x'",
    ("8 s", TABLE.replace("surge [m/m]", "surge [t]")): "'0.25 t' is not a valid motion per wave amplitude",
    ("8 s", TABLE.replace("roll phase [deg]", "phase of roll")): "barge.csv has no column 'roll phase [deg]'",
    (
        "8 s",
        TABLE.replace("roll", "role"),
    ): "barge.csv: unknown column 'role' in the responses of a vessel: did you mean 'roll'?",
    (
        "8 s",
        TABLE.replace("loaded,150,10", "loaded,150,8"),
    ): "barge.csv has several rows for the same wave, such as line 3",
}


@pytest.mark.parametrize(("period", "table"), BAD)
def test_missing_rows_of_a_vessel_table_are_reported(tmp_path: Path, period: str, table: str) -> None:
    with pytest.raises(SceneError) as error:
        answered(tmp_path, period, table=table)
    assert BAD[period, table] in str(error.value)
