"""Drawings of key instants: for every kind of crane they measure what is there, and nothing lies over anything else."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from heavylift.recordings import Recording, report
from heavylift.recordings.drawings import (
    SIZE,
    DimensionLine,
    Drawing,
    DrawnInstant,
    Text,
    clipped,
    drawings,
    drawn,
    hull,
    instants_of,
    parts,
    points_of,
    svg_of,
    within,
    write_dxf,
)
from heavylift.recordings.read import recorded_verdict
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays

CRANES = ("lift", "crawler", "hall", "jib", "floating", "moored", "spreader", "tandem")
SVG = "{http://www.w3.org/2000/svg}"
PROJECT = {"number": "4711", "name": "A block with quite a long name", "author": "A. Planner", "date": "2026-11-28"}


@pytest.fixture(scope="module", params=CRANES)
def lift(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("drawn") / f"{request.param}.mcap"
    run(load(request.param), path, in_process=True)
    return Recording(path)


@pytest.fixture(scope="module")
def made(lift: Recording) -> list[tuple[DrawnInstant, Drawing]]:
    verdict = recorded_verdict(lift)
    return list(zip(instants_of(lift, verdict), drawn(lift, verdict, PROJECT), strict=True))


def dimensions(drawing: Drawing, view: int, way: str) -> list[float]:
    """What the dimensions of a view say [m]."""
    found = (x for x in drawing.views[view].items if isinstance(x, DimensionLine) and x.way == way)
    return [float(x.words.rpartition(" ")[2]) for x in found]


@pytest.mark.large(beyond=3)
def test_heights_and_radii_written_in_drawings_are_those_at_the_drawn_instant(
    made: list[tuple[DrawnInstant, Drawing]],
) -> None:
    for x, drawing in made:
        heights = dimensions(drawing, 1, "v")
        lowest = float(x.of("block")[:, 2].min())
        assert any(h == pytest.approx(float(hook.eye[2]), abs=0.006) for hook in x.hooks for h in heights)
        assert float(x.of("crane")[:, 2].max()) == pytest.approx(heights[-1], abs=0.006)
        if lowest > 0.1:
            assert any(h == pytest.approx(lowest, abs=0.006) for h in heights)
        for hook in x.hooks:
            if hook.axis is not None:
                radius = float(np.hypot(*(hook.eye - hook.axis)[:2]))
                for view in (0, 1):
                    assert radius == pytest.approx(dimensions(drawing, view, "h")[0], abs=0.006)


def test_nothing_in_drawings_leaves_the_sheet_and_texts_do_not_overlap(
    made: list[tuple[DrawnInstant, Drawing]],
) -> None:
    for _, drawing in made:
        boxes = []
        for view in drawing.views:
            for item in view.items:
                ink = points_of(item) + np.array(view.place)
                assert ((ink >= 0.0) & (ink <= SIZE)).all(), f"{drawing.title}: {item} leaves the sheet"
                for part in parts(item):
                    if isinstance(part, Text):
                        corners = points_of(part) + np.array(view.place)
                        boxes.append((part.words, corners.min(axis=0), corners.max(axis=0)))
        for words, low, high in boxes:
            assert (low >= 0.0).all(), (drawing.title, words)
            assert (high <= SIZE).all(), (drawing.title, words)
        for (a, low, high), (b, least, most) in combinations(boxes, 2):
            apart = (low > most - 0.05).any() or (least > high - 0.05).any()
            assert apart, f"{drawing.title}: '{a}' lies over '{b}'"


def test_in_drawings_the_numbers_of_dimension_lines_lie_above_all_lines_on_a_white_background(
    made: list[tuple[DrawnInstant, Drawing]],
) -> None:
    """Lines of one dimension may cross the number of another, which is still legible."""
    for _, drawing in made:
        for view, group in zip(
            drawing.views, ET.fromstring(svg_of(drawing.views, SIZE, "")).iter(f"{SVG}g"), strict=True
        ):
            marks = [mark.tag.removeprefix(SVG) for mark in group]
            assert not {"polyline", "polygon"} & {*marks[marks.index("text") :]}
            numbers = sum(isinstance(item, DimensionLine) for item in view.items)
            assert sum(pair == ("rect", "text") for pair in pairwise(marks)) == marks.count("rect") == numbers


def test_a_rope_has_the_same_label_whatever_its_model_level(made: list[tuple[DrawnInstant, Drawing]]) -> None:
    """A rope with mass consists of pieces, of which the last one holds the hook."""
    for x, drawing in made:
        words = [item.words for item in drawing.views[2].items if isinstance(item, Text)]
        ropes = {line.rope.partition("~")[0] for line in x.lines if not line.sling}
        for rope in {rope for rope in ropes if "port" not in rope and "starboard" not in rope}:  # mooring lines
            assert sum(word.startswith(f"{rope} ") for word in words) == 1, rope
        assert not [word for word in words if "~" in word]


@pytest.mark.large(beyond=3)
def test_svg_and_dxf_drawings_have_the_same_content(lift: Recording, tmp_path: Path) -> None:
    import ezdxf

    verdict = recorded_verdict(lift)
    charts = drawings(lift, verdict, PROJECT)
    assert len(charts) >= 3
    for chart in charts:
        assert ET.fromstring(chart.image).get("viewBox") == "0 0 283 196"
    write_dxf(lift, tmp_path / "a.dxf", verdict, PROJECT)
    assert write_dxf(lift, tmp_path / "b.dxf", verdict, PROJECT).read_bytes() == (tmp_path / "a.dxf").read_bytes()
    space = ezdxf.readfile(tmp_path / "a.dxf").modelspace()
    measured = [x.get_measurement() for x in space.query("DIMENSION")]
    text = [
        x for d in drawn(lift, verdict, PROJECT) for view in d.views for x in view.items if isinstance(x, DimensionLine)
    ]
    assert measured == pytest.approx([float(x.words.rpartition(" ")[2]) for x in text], abs=0.006)


@pytest.mark.large(beyond=3)
def test_the_report_of_a_lift_has_drawings_and_the_report_of_a_mechanism_has_none(
    lift: Recording, tmp_path: Path
) -> None:
    text = report(lift, tmp_path / "report.html").read_text()
    assert text.count('class="drawing"') == len(drawings(lift, recorded_verdict(lift), PROJECT))


@given(arrays(np.float64, (8, 2), elements=st.floats(-50, 50).map(lambda x: round(x, 3))))
def test_a_convex_outline_contains_all_its_points_and_is_clipped_by_a_box(points: np.ndarray) -> None:
    outline = hull(points)
    if len(outline) > 2:
        assert all(within(outline, p + (outline.mean(axis=0) - p) * 1e-6) for p in points)
    low, high = np.array([-10.0, -20.0]), np.array([30.0, 5.0])
    cut = clipped(outline, low, high)
    assert (cut >= low - 1e-9).all()
    assert (cut <= high + 1e-9).all()
    kept = ((points >= low) & (points <= high)).all(axis=1)
    assert len(cut) >= (1 if kept.any() else 0)
