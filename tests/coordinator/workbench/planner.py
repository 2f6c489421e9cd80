"""A planner before the page of the workbench: what is done with mouse and forms alone."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from heavylift.coordinator.workbench import version_of

PATIENCE_s, RUN_s = 120.0, 300.0  # on a busy machine: for an answer, for a run
PICTURES = os.environ.get("HEAVYLIFT_PICTURES")


class Hands:
    """What a planner does with mouse and forms alone."""

    def __init__(self, page: Any, file: Path) -> None:
        self.page, self.file = page, file

    @property
    def text(self) -> str:
        """What the file holds."""
        return self.file.read_text()

    def until(self, holds: Callable[[], bool]) -> None:
        """Wait until something holds."""
        deadline = time.monotonic() + PATIENCE_s
        while not holds():
            assert time.monotonic() < deadline, self.text
            self.page.wait_for_timeout(30)

    def written(self, piece: str) -> None:
        """Wait until the file has a piece of text, and the page, too."""
        self.until(lambda: piece in self.text)
        self.page.wait_for_function("piece => workbench.editor.text.includes(piece)", arg=piece)

    def shown(self) -> None:
        """Wait until the page has the text of the file."""
        self.page.wait_for_function("text => workbench.editor.text === text", arg=self.text)

    def previewed(self, text: str | None = None) -> None:
        """Wait until the checks of a text are shown: that of the file."""
        self.page.wait_for_selector(f"html[data-checks='{version_of(self.text if text is None else text)}']")

    def choose(self, *path: str) -> None:
        """Click a thing in the outline."""
        self.page.locator(f"#outline [data-path='{'.'.join(path)}']").click()

    def fill(self, key: str, value: str, order: str = "") -> None:
        """Fill in a field of the form, of an order of a stage."""
        within = f"fieldset[aria-label='{order}'] " if order else ""
        field = self.page.locator(f"#form {within}[data-key='{key}']")
        if field.evaluate("x => x.tagName") == "SELECT":
            field.select_option(value)
        else:
            field.fill(value)
            field.press("Enter")

    def add(self, group: str, label: str) -> None:
        """Add a thing by the menu of its group in the outline."""
        before, menu = self.text, self.page.locator("#outline").get_by_label(f"add to {group}", exact=True)
        offered = menu.locator("option").all_inner_texts()
        menu.select_option(label=next(x for x in offered if x == label or x.startswith(f"{label}: ")))
        self.until(lambda: self.text != before)
        self.shown()

    def paste(self, rows: str, lengths: str = "m", masses: str = "t", instead: bool = False) -> None:
        """Paste rows of a spreadsheet into the form, in addition to those that are there or instead of them."""
        form, before = self.page.locator("#form"), self.text
        if not form.locator("details.paste[open]").count():
            form.get_by_text("Paste from a spreadsheet").click()
        form.locator("textarea").fill(rows)
        form.get_by_label("lengths in").select_option(lengths)
        if form.get_by_label("masses in").count():
            form.get_by_label("masses in").select_option(masses)
        if instead:
            form.get_by_label("in place of").check()
        form.get_by_role("button", name="add these rows").click()
        self.until(lambda: self.text != before)
        self.shown()

    def begin(self, name: str, like: str) -> None:
        """Begin a scene like another one."""
        self.page.get_by_role("button", name="New ...").first.click()
        dialog = self.page.get_by_role("dialog")
        dialog.get_by_label("name").fill(name)
        dialog.get_by_label("begins like").first.select_option(like)
        dialog.get_by_role("button", name="create").click()
        self.page.wait_for_selector(f"option[value='{name}.yaml']:checked", state="attached")
        self.file = self.file.parent / f"{name}.yaml"

    def run(self) -> str:
        """Run the scene to its end and return the verdict that is shown."""
        recording = f"{self.file.stem}.mcap"
        self.page.get_by_role("button", name="Run", exact=True).click()
        self.page.wait_for_selector(f"html[data-motion='{recording}']", timeout=RUN_s * 1e3)
        return str(self.page.locator("#verdict").inner_text()).removeprefix(f"{recording}: ")

    def picture(self, name: str) -> None:
        """Take a picture of the page for its description, if a folder for it is named."""
        if PICTURES:
            self.page.screenshot(path=Path(PICTURES) / f"{name}.png", scale="css")

    def grip(self, body: str, p: list[float]) -> list[float]:
        """Where a point of a body is seen [pixel], once the camera and the picture stand still."""
        return list(
            self.page.evaluate(
                """async ([body, p]) => { const { stage } = workbench.views; let last = [0, 0];
                for (let still = 0; still < 3; ) {
                  await new Promise(requestAnimationFrame);
                  const [x, y] = stage.labels.seen(stage.labels.place(body, p), stage.camera);
                  still = x === last[0] && y === last[1] ? still + 1 : 0; last = [x, y];
                }
                const box = stage.gl.domElement.getBoundingClientRect();
                return [box.x + last[0], box.y + last[1]]; }""",
                [body, p],
            )
        )

    def drag(self, body: str, p: list[float], by: tuple[int, int]) -> None:
        """Drag what is seen at a point of a body by so many pixels."""
        x, y = self.grip(body, p)
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        self.page.mouse.move(x + by[0] / 2, y + by[1] / 2)
        self.page.mouse.move(x + by[0], y + by[1], steps=3)
        self.page.mouse.up()
