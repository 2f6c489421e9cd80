"""The page in a browser: the same picture twice, what it must show at fixed times, light, dark, on paper, and live."""

from __future__ import annotations

import io
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from browser import CHROMIUM, Chromium
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from heavylift.recordings import view
from heavylift.recordings.render.live import LivePage
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
    return recorded(tmp_path_factory, "lift")


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
def test_the_same_instant_is_the_same_picture(browser: Chromium, lift: Path) -> None:
    pictures = []
    for _ in range(2):
        browser.open(f"{lift.as_uri()}#t=40")
        pictures.append(browser.picture("#stage"))
    assert pictures[0] == pictures[1]
    assert browser.run("document.getElementById('clock').textContent") == "40.00 s / 60.00 s"
    assert browser.run("document.getElementById('stage-name').textContent") == "up"
    assert browser.complaints == [], "the page has no errors"
    assert all(request.startswith("file:") for request in browser.requests), "nothing is asked of any network"


def test_block_portal_trolleys_and_ropes_are_seen_and_move(browser: Chromium, lift: Path) -> None:
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
def test_light_dark_and_paper(browser: Chromium, lift: Path) -> None:
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
def test_each_chart_has_the_line_of_the_common_time(browser: Chromium, lift: Path) -> None:
    lines = "[...document.querySelectorAll('.now')].filter(x => !x.hidden).map(x => x.getBoundingClientRect().x)"
    browser.open(f"{lift.as_uri()}#t=40")
    first = browser.run(lines)
    assert len(first) == 1, "from the start"
    browser.run("document.querySelectorAll('#picker input')[0].click()")
    browser.until(f"{lines}.length === 2")
    assert browser.run(lines)[0] == browser.run(lines)[1]
    legend = "document.querySelector('.u-legend .u-value').textContent"
    assert browser.run(legend) == "40"
    browser.open(f"{lift.as_uri()}#t=50")
    assert browser.run(lines)[0] > first[0]


def test_a_scene_that_is_no_yard_fills_its_picture(browser: Chromium, pendulum: Path) -> None:
    browser.open(f"{pendulum.as_uri()}#t=0&view=across")
    hsv = pixels(browser.picture("#stage"))
    ball = coloured(hsv, BLUE)
    assert len(ball) > FEW
    rows, columns = hsv.shape[:2]
    height, width = np.ptp(ball[:, 0]), np.ptp(ball[:, 1])
    assert 0.9 < height / width < 1.1, "a ball"
    assert 0.55 < ball[:, 0].mean() / rows < 0.95, "in the lower part, the pivot above"
    assert 0.1 < ball[:, 1].mean() / columns < 0.9


def test_keys_and_clicks(browser: Chromium, lift: Path) -> None:
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


def test_a_run_is_seen_while_it_goes_on_and_to_its_end(browser: Chromium, tmp_path: Path) -> None:
    with LivePage() as page:
        begun = threading.Thread(
            target=run, args=(load("lift"), tmp_path / "run.mcap"), kwargs={"in_process": True, "page": page}
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
    assert browser.run("document.getElementById('clock').textContent") == "30.00 s / 60.00 s", "scrolled back"
    assert len(coloured(pixels(browser.picture("#stage")), RED)) > FEW
    assert browser.complaints == []
