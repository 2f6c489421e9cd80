"""The page of a recording: self-contained, inert to what scenes say, and alive in a browser."""

from __future__ import annotations

import base64
import html
import json
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest
from heavylift.kernel import RecordingError
from heavylift.recordings import DrawnBox, Recorder, Recording, RopeLine, view
from heavylift.recordings.format import thinned
from heavylift.recordings.render.view import content
from small_run import Stage

NASTY = "</script><script>alert(1)</script><img src=x onerror=alert(2)> & {{script}}"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


@pytest.fixture
def page(begin: Callable[[], Recorder], batch: Callable[[int, int], bytes], tmp_path: Path) -> Path:
    """The page of a small run whose stage has a hostile name."""
    with begin() as rec:
        rec.boxes([DrawnBox("block", (0, 0, 0), (3, 2, 1))])
        rec.ropes(0, [RopeLine("west.H1", "world", (0, 0, 9), "block", (0, 0, 1))])
        payload = msgspec.msgpack.encode(Stage(NASTY, 1))
        rec.event(0, 1, "commander", "stage", 0, "Stage", payload)
        rec.samples(batch(0, 6))
        path = rec.close()
    return view(path, tmp_path / "run.html")


def embedded(page: Path) -> dict:
    found = re.search(r'<script id="run" type="application/json">(.*?)</script>', page.read_text(), re.DOTALL)
    assert found
    return json.loads(found[1])


def test_the_page_of_a_recording_contains_its_samples_and_shapes_and_rope_lines_and_stages(
    page: Path, tmp_path: Path
) -> None:
    run, rec = embedded(page), Recording(tmp_path / "run.mcap")
    signal = rec.signal("rope/tension")
    assert np.array_equal(np.frombuffer(base64.b64decode(run["rows"]["t"]), "<f8"), signal.t)
    names = [s["group"] + "/" + s["name"] for s in run["signals"]]
    rows = np.frombuffer(base64.b64decode(run["rows"]["x"]), "<f4").reshape(len(signal.t), -1)
    k = 7 * len(run["bodies"]) + names.index("rope/tension/west.H2")
    assert np.array_equal(rows[:, k], signal.values[:, 1].astype("<f4"))
    assert [b["name"] for b in run["bodies"]] == ["block", "hook"]
    assert np.array_equal(rows[:, 7:14], rec.signal("pose/hook").values.astype("<f4"))
    assert run["rig"] == [
        {"t": 0.0, "lines": [{"rope": "west.H1", "a_body": "world", "a": [0, 0, 9], "b_body": "block", "b": [0, 0, 1]}]}
    ]
    assert run["boxes"][0]["size"] == [3, 2, 1]
    assert run["stages"] == [{"t": 0.0, "name": NASTY}]
    assert content(rec)["peaks"][0]["rated"] == 9e5


def test_thinning_72000_samples_to_1000_keeps_the_extrema() -> None:
    load = np.sin(np.arange(72_000) / 7.0)
    load[31_234], load[50_001] = 9.0, -9.0
    kept = thinned([load], 1000)
    assert len(kept) <= 1000
    assert {0, 31_234, 50_001, 71_999} <= set(kept.tolist())
    assert np.all(np.diff(kept) > 0)
    assert np.diff(kept).max() < 2 * 72_000 / 499, "no stretch is left out"
    assert thinned([load[:900]], 1000).tolist() == list(range(900))


def test_the_page_of_a_recording_loads_nothing_from_the_network(page: Path) -> None:
    text = re.sub(r"<script(?: id=\"run\"[^>]*)?>.*?</script>", "", page.read_text(), flags=re.DOTALL)
    assert "src=" not in text
    assert "href=" not in text
    assert "url(" not in text


def test_text_of_a_scene_cannot_become_markup_on_the_page_of_its_recording(page: Path) -> None:
    text = page.read_text()
    assert text.count("<script") == 2
    assert "<img src" not in text
    assert "alert(1)" in text, "as data"


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium to open the page with")
@pytest.mark.large
def test_the_page_of_a_recording_opens_at_the_instant_that_its_web_address_states(page: Path) -> None:
    dom = subprocess.run(
        [
            str(CHROMIUM), "--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader", "--virtual-time-budget=4000", "--dump-dom", f"{page.as_uri()}#t=2.5",
        ],
        capture_output=True, text=True, timeout=60, check=True,
    ).stdout  # fmt: skip
    assert 'data-ready="yes"' in dom
    assert '<span id="clock">0:02.50 / 0:04.00</span>' in dom
    assert html.escape(NASTY, quote=False) in dom
    assert "<canvas" in dom


def test_recordings_that_cannot_be_shown_on_a_page_are_reported(tmp_path: Path, begin: Callable[[], Recorder]) -> None:
    with begin() as rec:
        path = rec.close()
    with pytest.raises(RecordingError) as error:
        view(path, tmp_path / "run.html")
    assert str(error.value) == f"{path}: the recording has no samples to show; let the run last longer"
    with Recorder(tmp_path / "queue.mcap", {"model": "queue:build"}) as rec, pytest.raises(RecordingError) as error:
        view(rec.close(), tmp_path / "run.html")
    assert str(error.value).endswith("no samples to show; a DEVS model has messages only: `heavylift plot` draws them")
    with pytest.raises(RecordingError, match=r"the file name of a page must end in \.html; choose such a name$"):
        view(path, tmp_path / "run.pdf")


def test_on_the_page_of_a_recording_a_second_run_for_comparison_is_transparent_and_dashed(
    begin: Callable[[], Recorder], batch: Callable[[int, int], bytes], page: Path, tmp_path: Path
) -> None:
    with begin() as rec:
        rec.boxes([DrawnBox("block", (0, 0, 0), (3, 2, 1), (0.5, 0.4, 0.3, 1.0))])
        rec.samples(batch(0, 4))
        shorter = rec.close()
    both = embedded(view(tmp_path / "run.mcap", tmp_path / "both.html", beside=shorter))
    alone = embedded(page)
    name = f"block {shorter.name}"
    assert [b["name"] for b in both["bodies"]] == [name, "block", "hook"], "the hook has no shape"
    glass = both["boxes"][-1]
    assert (glass["body"], glass["size"], glass["colour"]) == (name, [3, 2, 1], [0.5, 0.4, 0.3, 0.25])
    own = [s["group"] + "/" + s["name"] for s in alone["signals"]]
    names = [s["group"] + "/" + s["name"] for s in both["signals"]]
    assert names == [*own, *(f"beside/{signal}" for signal in own)]
    rows = np.frombuffer(base64.b64decode(both["rows"]["x"]), "<f4").reshape(6, -1)
    ghost, block = rows[:, :7], rows[:, 7:14]
    assert np.array_equal(ghost[:4], block[:4])
    assert np.array_equal(ghost[4:], block[[3, 3]]), "it stays where it was at its end"
    first, second = (21 + names.index(f"{other}rope/tension/west.H1") for other in ("", "beside/"))
    assert np.array_equal(rows[:4, first], rows[:4, second])
    assert np.isnan(rows[4:, second]).all()
    assert both["beside"] == shorter.name
    assert ["beside", f"{shorter.name}, as glass and dashed curves"] in both["facts"]
