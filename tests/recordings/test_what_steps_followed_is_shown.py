"""A run of which rope tensions alone were asked tells where its steps were long; figure and page show it."""

from __future__ import annotations

import json
import re
from itertools import pairwise
from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from heavylift.recordings import Recording, plot, view
from heavylift.recordings.read.info import info
from heavylift.recordings.read.pace import Pace, followed, paces

LONG = ["method=sdirk2", "tolerance=0.01", "tolerance of=rope tension"]
LEGEND = "dark strip: steps follow every motion"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("lift") / "lift.mcap"
    run(load("lift", LONG), path, in_process=True)
    return path


def test_spans_cover_the_run_and_alternate(recorded: Path) -> None:
    found = paces(Recording(recorded))
    assert found[0].start == 0.0
    assert all(a.end == b.start and a.long is not b.long for a, b in pairwise(found))
    assert found[-1].end == pytest.approx(Recording(recorded).fact("sim_s", 0.0), abs=1e-6)


def test_steps_are_short_only_where_their_number_says_so(recorded: Path) -> None:
    rec = Recording(recorded)
    t, taken = rec.signal("steps").t, rec.signal("steps").values[:, 0]
    for span in paces(rec):
        inside = (t >= span.start) & (t <= span.end)
        steps = taken[inside][-1] - taken[inside][0]
        assert (span.end - span.start > 0.1 * steps) == span.long


def test_it_is_summed_up_in_words() -> None:
    spans = [Pace(0.0, 2.0, False), Pace(2.0, 50.0, True), Pace(50.0, 54.5, False)]
    assert followed(spans) == "every motion for 6.5 s of 54.5 s"
    assert followed([]) == ""


def test_figure_page_and_text_show_them(recorded: Path, tmp_path: Path) -> None:
    told = followed(paces(Recording(recorded)))
    assert f"{LEGEND} for" in plot(recorded, tmp_path / "x.svg").read_text()
    assert f"follow {told}" in info(recorded)
    page = view(recorded, tmp_path / "x.html").read_text()
    (text,) = re.findall(r'<script id="run" type="application/json">(.*?)</script>', page)
    shown = json.loads(text)
    assert ["steps follow", told] in shown["facts"]
    assert [(p["t"], p["long"]) for p in shown["paces"]] == [(p.start, p.long) for p in paces(Recording(recorded))]
    assert "steps" not in {signal["group"] for signal in shown["signals"]}


def test_other_methods_follow_every_motion_and_count_nothing(tmp_path: Path) -> None:
    path = tmp_path / "lift.mcap"
    run(load("lift", ["end=2 s"]), path, in_process=True)
    assert "steps" not in Recording(path).signals()
    assert LEGEND not in plot(path, tmp_path / "x.svg").read_text()
