"""A folder with a scene in it, a workbench that serves it to a browser, and a planner before it."""

from __future__ import annotations

import shutil
import threading
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from heavylift.nodes.scene import bundled
from planner import Hands, PATIENCE_s

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = ["--no-sandbox", "--enable-unsafe-swiftshader"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the smallest lift, under another name."""
    shutil.copy(bundled()["lift"], tmp_path / "my-lift.yaml")
    return tmp_path


@pytest.fixture
def address(folder: Path) -> Iterator[str]:
    """Where a workbench serves that folder."""
    from heavylift.coordinator.workbench import served

    scene = folder / "my-lift.yaml"
    with served(folder, scene if scene.exists() else None) as (url, run, server):
        thread = threading.Thread(target=run)
        thread.start()
        urllib.request.urlopen(url).close()
        yield url
        server.should_exit = True
        thread.join()


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    """Debian's browser, driven by Playwright."""
    playwright = pytest.importorskip("playwright.sync_api")
    if CHROMIUM is None:
        pytest.skip("no Chromium to open the workbench with")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def page(chromium: Any, address: str, folder: Path) -> Iterator[Any]:
    """The page of the folder when the checks of its scene are there."""
    page = chromium.new_page(viewport={"width": 1500, "height": 950}, color_scheme="light")
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.set_default_timeout(1e3 * PATIENCE_s)
    page.goto(address)
    begun = "[data-checks]" if (folder / "my-lift.yaml").exists() else ""
    page.wait_for_selector(f"html[data-schema]{begun}")
    yield page
    assert complaints == []
    page.close()


@pytest.fixture
def hands(page: Any, folder: Path) -> Hands:
    """A planner before the page."""
    return Hands(page, folder / "my-lift.yaml")
