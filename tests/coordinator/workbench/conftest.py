"""A folder with a scene in it, and a workbench that serves it to a browser."""

from __future__ import annotations

import shutil
import threading
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from heavylift.nodes.scene import bundled

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

    with served(folder, folder / "my-lift.yaml") as (url, run, server):
        thread = threading.Thread(target=run)
        thread.start()
        urllib.request.urlopen(url).close()
        yield url
        server.should_exit = True
        thread.join()


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    """Debian's browser, driven by Playwright."""
    playwright = pytest.importorskip("playwright.sync_api")
    if CHROMIUM is None:
        pytest.skip("no Chromium to open the workbench with")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()
