"""The page in a browser: the same picture twice, what it must show at fixed times, light, dark, on paper, and live."""

from __future__ import annotations

import base64
import io
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from browser import CHROMIUM, Chromium
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from heavylift.recordings import Recording, view
from heavylift.recordings.render import LivePage, view as rendering
from matplotlib.colors import rgb_to_hsv
from matplotlib.image import imread
from numpy.typing import NDArray

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium to open the page with")

RED, YELLOW, BLUE, ROPES = (0.0, 0.035), (0.10, 0.14), (0.56, 0.62), (0.17, 0.34)  # hues: block, portal, trolley
FEW = 150  # pixels that are more than a rounding of edges


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chromium]:
    with Chromium(tmp_path_factory.mktemp("profile")) as chromium:
        yield chromium


@pytest.fixture(scope="module")
def lift(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory, "lift", "end=60 s")


@pytest.fixture(scope="module")
def pendulum(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory, "pendulum", "end=10 s")


def recorded(tmp_path_factory: pytest.TempPathFactory, scene: str, *settings: str) -> Path:
    """The page of a bundled scene."""
    path = tmp_path_factory.mktemp(scene) / f"{scene}.mcap"
    run(load(scene, settings), path, in_process=True)
    return view(path, path.with_suffix(".html"))


def pixels(png: bytes) -> NDArray[np.float64]:
    """Hue, saturation, value of each pixel from 0 to 1."""
    hsv: NDArray[np.float64] = rgb_to_hsv(imread(io.BytesIO(png), format="png")[:, :, :3])
    return hsv


def coloured(hsv: NDArray[np.float64], hue: tuple[float, float]) -> NDArray[np.intp]:
    """Rows and columns (n, 2) of strong pixels of this hue."""
    strong = (hsv[:, :, 1] > 0.5) & (hsv[:, :, 2] > 0.25)
    return np.argwhere(strong & (hsv[:, :, 0] >= hue[0]) & (hsv[:, :, 0] <= hue[1]))


@pytest.mark.large
def test_the_page_of_a_recording_draws_the_same_picture_whenever_it_shows_the_same_instant(
    browser: Chromium, lift: Path
) -> None:
    pictures = []
    for _ in range(2):
        browser.open(f"{lift.as_uri()}#t=40")
        pictures.append(browser.picture("#stage"))
    assert pictures[0] == pictures[1]
    assert browser.run("document.getElementById('clock').textContent") == "0:40.00 / 1:00.00"
    assert browser.run("document.getElementById('stage-name').textContent") == "up"
    assert browser.complaints == [], "the page has no errors"
    assert all(request.startswith("file:") for request in browser.requests), "nothing is asked of any network"


def test_on_the_page_of_a_recording_block_and_portal_and_trolleys_and_ropes_are_visible_and_move(
    browser: Chromium, lift: Path
) -> None:
    browser.open(f"{lift.as_uri()}#t=0&view=along")
    before = pixels(browser.picture("#stage"))
    browser.open(f"{lift.as_uri()}#t=60&view=along")
    after = pixels(browser.picture("#stage"))
    for hue in (RED, YELLOW, BLUE):
        assert len(coloured(before, hue)) > FEW
    block = [coloured(x, RED).mean(axis=0) for x in (before, after)]
    assert block[1][0] < block[0][0] - 1.0, "hoisted: higher in the picture"
    assert abs(block[1][1] - block[0][1]) > 3.0, "traversed: aside in the picture"
    hues = [np.median(x[tuple(coloured(x, ROPES).T)][:, 0]) for x in (before, after)]
    assert len(coloured(after, ROPES)) > FEW
    assert hues[1] < hues[0] - 0.02, "the ropes carry: from green towards yellow"


@pytest.mark.large
def test_the_page_of_a_recording_has_colours_for_light_dark_and_print(browser: Chromium, lift: Path) -> None:
    values = {}
    for theme in ("light", "dark"):
        browser.open(f"{lift.as_uri()}#t=40&theme={theme}")
        hsv = pixels(browser.picture())
        values[theme] = float(np.median(hsv[:, :, 2]))
        assert len(coloured(hsv, RED)) > FEW
    assert values["light"] > 0.75
    assert values["dark"] < 0.25
    browser("Emulation.setEmulatedMedia", media="print")
    assert browser.run("getComputedStyle(document.querySelector('#stage canvas')).display") == "none", "printed once"
    browser("Emulation.setEmulatedMedia", media="")
    paper = browser.paper()  # of the dark page
    assert paper.startswith(b"%PDF")
    assert browser.run("document.documentElement.dataset.theme") == "dark", "what was before the print"
    assert browser.run("document.getElementById('printed').src.length") > 10_000, "the scene is on it"


@pytest.mark.large
def test_all_charts_on_the_page_of_a_recording_mark_the_same_instant(browser: Chromium, lift: Path) -> None:
    lines = "[...document.querySelectorAll('.now')].filter(x => !x.hidden).map(x => x.getBoundingClientRect().x)"
    browser.open(f"{lift.as_uri()}#t=40")
    first = browser.run(lines)
    assert len(first) == 1, "from the start"
    browser.run("document.querySelectorAll('#picker input')[0].click()")
    browser.until(f"{lines}.length === 2")
    assert browser.run(lines)[0] == browser.run(lines)[1]
    legend = "document.querySelector('.u-legend .u-value').textContent"
    assert browser.run(legend) == "0:40.00"
    browser.open(f"{lift.as_uri()}#t=50")
    assert browser.run(lines)[0] > first[0]


def test_the_3d_picture_of_a_scene_without_machines_fills_the_page_of_its_recording(
    browser: Chromium, pendulum: Path
) -> None:
    browser.open(f"{pendulum.as_uri()}#t=0&view=across")
    hsv = pixels(browser.picture("#stage"))
    ball = coloured(hsv, BLUE)
    assert len(ball) > FEW
    rows, columns = hsv.shape[:2]
    height, width = np.ptp(ball[:, 0]), np.ptp(ball[:, 1])
    assert 0.9 < height / width < 1.1, "a ball"
    assert 0.55 < ball[:, 0].mean() / rows < 0.95, "in the lower part, the pivot above"
    assert 0.1 < ball[:, 1].mean() / columns < 0.9


def test_keys_and_clicks_on_the_page_of_a_recording_change_time_and_stage_and_playback(
    browser: Chromium, lift: Path
) -> None:
    browser.open(f"{lift.as_uri()}#t=0")
    browser.key("?")
    assert browser.run("document.getElementById('help').open")
    browser.key("?")
    assert not browser.run("document.getElementById('help').open")
    browser.key("PageDown")
    assert browser.run("document.getElementById('stage-name').textContent") == "lift off"
    browser.run("document.querySelectorAll('#events li:not(.inner)')[3].click()")
    assert browser.run("heavylift.player.now === heavylift.run.events.filter(e => !e.inner)[3].t")
    browser.key("End")
    assert browser.run("heavylift.player.now === heavylift.run.last")
    browser.key(" ")
    browser.until("heavylift.player.playing && heavylift.player.now > 0 && heavylift.player.now < heavylift.run.last")
    browser.key(" ")
    assert not browser.run("heavylift.player.playing")


def test_the_live_page_follows_a_run_to_its_end(browser: Chromium, tmp_path: Path) -> None:
    with LivePage() as page:
        begun = threading.Thread(
            target=run,
            args=(load("lift", ["end=60 s"]), tmp_path / "run.mcap"),
            kwargs={"in_process": True, "page": page},
        )
        begun.start()
        browser.open(page.url)
        browser.until("document.documentElement.dataset.ended === 'yes'")
        begun.join()
    assert browser.run("document.getElementById('status').textContent") == (
        f"finished, 60 s simulated; recorded in {tmp_path / 'run.mcap'}"
    )
    stages = ["take up slack", "lift off", "up", "sideways", "swing"]
    assert browser.run("heavylift.run.stages.map(s => s.name)") == stages
    assert browser.run("heavylift.run.last") == pytest.approx(60.0, abs=1e-6)
    browser.run("heavylift.player.jump(30)")
    assert browser.run("document.getElementById('clock').textContent") == "0:30.00 / 1:00.00", "scrolled back"
    assert len(coloured(pixels(browser.picture("#stage")), RED)) > FEW
    assert browser.complaints == []


def test_the_page_of_a_recording_writes_names_and_loads_and_dimensions_over_the_3d_view(
    browser: Chromium, lift: Path
) -> None:
    browser.open(f"{lift.as_uri()}#t=40&view=across")
    written = "heavylift.stage.draw(1), heavylift.stage.labels.written"
    assert {"block", "crane", "CG 300 t", "1909 kN · 44 %"} <= set(browser.run(written))
    click = "document.querySelector('#shows [name=%s]').click(), "
    message = set(browser.run(click % "dimensions" + click % "lugs" + written))
    assert {"20 m", "8 m"} <= message, "length and height of the block"
    assert "16 m" not in message, "its width is not seen from here"
    assert message & {"P1", "Q1"}
    off = set(
        browser.run("".join(click % name for name in ("names", "loads", "gravity", "dimensions", "lugs")) + written)
    )
    assert off == set()


@pytest.mark.large
def test_side_views_on_the_page_of_a_recording_are_parallel_projections_that_show_all_bodies(
    browser: Chromium, lift: Path
) -> None:
    inside = """[0, 1, 2, 3, 4, 5, 6, 7].every(k => {
      const { stage } = heavylift, p = stage.box.low.clone();
      if (k & 1) p.x = stage.box.high.x; if (k & 2) p.y = stage.box.high.y; if (k & 4) p.z = stage.box.high.z;
      p.project(stage.camera); return Math.abs(p.x) <= 1 && Math.abs(p.y) <= 1; })"""
    browser.open(f"{lift.as_uri()}#t=0")
    for side in ("corner", "along", "across", "top"):
        browser.run(f"heavylift.stage.look('{side}'), heavylift.stage.draw(1)")
        assert browser.run("!!heavylift.stage.camera.isOrthographicCamera") == (side != "corner")
        assert browser.run(inside), side


def test_the_3d_view_of_a_moored_crane_frames_the_bodies_above_the_seabed(
    browser: Chromium, tmp_path_factory: pytest.TempPathFactory
) -> None:
    browser.open(recorded(tmp_path_factory, "moored", "end=1 s").as_uri())
    low, high = (browser.run(f"heavylift.stage.box.{x}.toArray()") for x in ("low", "high"))
    assert 110.0 <= high[0] - low[0] <= 130.0, "the barge is 110 m long, its lines reach 500 m"
    assert browser.run("heavylift.stage.ground.position.z") == pytest.approx(-60.0, abs=0.1)


@pytest.mark.large
def test_the_camera_of_the_3d_view_can_follow_the_block(browser: Chromium, lift: Path) -> None:
    off = (
        "(s => [0, 1, 2].map(i => s.controls.target.getComponent(i) - s.frames.get('block').position.getComponent(i)))"
    )
    browser.open(f"{lift.as_uri()}#t=20")
    browser.key("f")
    before = browser.run(f"{off}(heavylift.stage)")
    assert before == pytest.approx([0, 0, 0], abs=1e-9)
    browser.run("heavylift.player.jump(55)")
    assert browser.run(f"{off}(heavylift.stage)") == pytest.approx(before, abs=1e-9)


@pytest.mark.large
def test_a_picture_saved_from_the_page_of_a_recording_has_a_caption(browser: Chromium, lift: Path) -> None:
    browser.open(f"{lift.as_uri()}#t=40")
    browser.run("HTMLAnchorElement.prototype.click = function () { window.saved = [this.download, this.href] }")
    browser.key("s")
    name, address = browser.run("window.saved")
    assert name == "lift-up-0-40.00.png"
    state = imread(io.BytesIO(base64.b64decode(address.partition(",")[2])), format="png")
    host = browser.run("(r => [r.width, r.height])(document.getElementById('stage').getBoundingClientRect())")
    assert state.shape[1] / state.shape[0] == pytest.approx(host[0] / (host[1] + 26), rel=0.01)


def test_the_page_of_a_recording_fits_the_screen_of_a_phone(browser: Chromium, lift: Path) -> None:
    browser("Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=1, mobile=True)
    browser.open(f"{lift.as_uri()}#t=40")
    assert browser.run("document.documentElement.scrollWidth") == 390
    seen = "[...document.querySelectorAll('header *, footer *, #shows *')].map(e => e.getBoundingClientRect().right)"
    assert max(browser.run(seen)) <= 390
    assert browser.run("(x => x.scrollWidth <= x.clientWidth)(document.querySelector('#status'))"), "the verdict"
    browser("Emulation.setDeviceMetricsOverride", width=1200, height=800, deviceScaleFactor=1, mobile=False)


def test_the_page_of_a_long_recording_shows_coarse_data_at_once_and_the_rest_later(
    browser: Chromium, lift: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = lift.with_suffix(".mcap")
    signal = Recording(recording).signal("rope/tension")
    monkeypatch.setattr(rendering, "COARSE", 5000)
    message = rendering.content(Recording(recording))
    assert len(base64.b64decode(message["rows"]["t"])) // 8 < len(signal.t) / 2, "the coarse level"
    page = view(recording, tmp_path / "lift.html")
    browser.open(f"{page.as_uri()}#t=40")
    browser.until("document.documentElement.dataset.finer === 'yes'")
    assert browser.run("[...heavylift.run.t]") == signal.t.tolist()
    y = browser.run("[...heavylift.run.signal.get('rope/tension/crane.H3').y]")
    assert y == signal["crane.H3"].astype("<f4").tolist()
    pose = Recording(recording).signal("pose/block")
    assert browser.run("[...heavylift.run.body.get('block').x]") == pose.values.astype("<f4").ravel().tolist()
    assert browser.run("document.getElementById('clock').textContent") == "0:40.00 / 1:00.00"


@pytest.mark.large
def test_charts_on_the_page_of_a_recording_show_limits_and_clock_times(browser: Chromium, lift: Path) -> None:
    browser.open(f"{lift.as_uri()}#t=40")
    legend = browser.run("[...document.querySelectorAll('.u-legend .u-label')].slice(0, 4).map(e => e.textContent)")
    assert legend[0] == "time"
    assert set(legend[1:3]) == {"loader-3.sling-1", "loader-3.sling-2"}, "used most"
    assert legend[3] == "crane.H3"
    groups = browser.run("[...document.querySelectorAll('#picker label')].map(e => e.textContent.trim())")
    assert {"joint/position [m]", "joint/position [rad]"} <= set(groups)
    events = browser.run("[...document.querySelectorAll('#events li:not(.inner) span')].map(e => e.textContent)")
    assert {"stage take up slack begins", "loader-1.sling-1 taut", "block lifted off", "move of crane.H1 done"} <= set(
        events
    )
    assert not [text for text in events if "actor" in text]
