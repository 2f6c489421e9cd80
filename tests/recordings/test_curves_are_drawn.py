"""Any signals become figures: by pattern, a panel per unit, limits and stages; on paper, and on a page to zoom."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import pytest
from heavylift.kernel import RecordingError
from heavylift.recordings import curves, overlay

CHROMIUM = shutil.which("chromium")
SVG = "{http://www.w3.org/2000/svg}"


def words(path: Path) -> str:
    """All text of a drawing, which matplotlib leaves as comments beside its outlines."""
    return " ".join(re.findall(r"<!-- (.*?) -->", path.read_text()))


def test_plotted_curves_have_one_panel_per_unit_with_limits_and_stages(recorded: Path, tmp_path: Path) -> None:
    out = curves(recorded, ["rope/tension/*", "pose/block/?"], tmp_path / "x.svg")
    text = words(out)
    assert {"[kN]", "[m]", "rated 900 kN", "take up", "hoist", "Time [s]"} <= set(
        re.findall(r"rated \d+ kN|take up|Time \[s\]|\S+", text)
    )
    assert "pose/block/qx" not in text
    assert "rope/tension/west.H2" in text
    first = out.read_bytes()
    assert curves(recorded, ["rope/tension/*", "pose/block/?"], out).read_bytes() == first
    assert curves(recorded, ["rope/peak"], tmp_path / "x.png").read_bytes().startswith(b"\x89PNG")


def content(page: Path) -> dict[str, object]:
    (text,) = re.findall(r'<script id="run" type="application/json">(.*?)</script>', page.read_text())
    found: dict[str, object] = json.loads(text)
    return found


def test_a_page_with_plotted_curves_needs_no_other_file(recorded: Path, tmp_path: Path) -> None:
    out = curves(recorded, ["rope/*"], tmp_path / "x.html")
    text = out.read_text()
    assert "default-src 'none'" in text
    assert not re.search(r"(src|href)=", text.partition("<script>")[0])
    panels = content(out)["panels"]
    assert [panel["unit"] for panel in panels] == ["kN", "s"]  # type: ignore[attr-defined]
    assert [curve["name"] for curve in panels[1]["curves"]] == ["rope/peak_time/west.H1", "rope/peak_time/west.H2"]  # type: ignore[index]


@pytest.mark.skipif(CHROMIUM is None, reason="no chromium here: the page is not opened")
def test_a_browser_draws_one_chart_for_each_panel_of_a_page_with_curves(recorded: Path, tmp_path: Path) -> None:
    out = curves(recorded, ["rope/*"], tmp_path / "x.html")
    command = [str(CHROMIUM), "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path}/profile",
               "--virtual-time-budget=3000", "--dump-dom", out.as_uri()]  # fmt: skip
    page = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout
    assert 'data-ready="2"' in page
    assert page.count("<canvas") == 2


def test_curves_of_two_recordings_are_drawn_in_one_chart(recorded: Path, tmp_path: Path) -> None:
    other = shutil.copy(recorded, tmp_path / "other.mcap")
    out = overlay(recorded, other, tmp_path / "x.svg", ["rope/tension/west.H1"])
    assert "rope/tension/west.H1: largest difference 0 kN at 0.000 s, RMS 0 kN" in words(out)
    assert {"run.mcap", "other.mcap"} <= set(words(out).split())
    assert len(list(ElementTree.parse(out).getroot().iter(f"{SVG}path"))) > 4
    panels = content(overlay(recorded, other, tmp_path / "x.html"))["panels"]
    assert len(panels) == 4, "one of each signal"  # type: ignore[arg-type]


def test_drawing_unknown_signals_or_to_an_unknown_format_is_reported(recorded: Path, tmp_path: Path) -> None:
    with pytest.raises(
        RecordingError,
        match=r"x\.pdf: the file name of a figure must end in \.png, \.svg or \.html; choose such a name",
    ):
        curves(recorded, ["rope/*"], tmp_path / "x.pdf")
    with pytest.raises(RecordingError, match=r"no signal matches 'rope/tenison'; did you mean rope/tension\?"):
        curves(recorded, ["rope/tenison"], tmp_path / "x.png")
