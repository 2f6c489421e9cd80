"""A headless Chromium that is told what to do: Chrome's DevTools protocol over the pipe that it offers for tests."""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import subprocess
import time
from pathlib import Path
from types import TracebackType
from typing import Any, Self

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--hide-scrollbars", "--no-first-run",
    "--disable-extensions", "--remote-debugging-pipe",
)  # fmt: skip
PATIENCE_s = 60.0


class Chromium:
    """A browser with one page."""

    def __init__(self, profile: Path, width: int = 1200, height: int = 800) -> None:
        to_read, self._out = os.pipe()
        self._in, to_write = os.pipe()

        def wire() -> None:  # the browser reads from 3 and writes to 4
            a, b = os.dup(to_read), os.dup(to_write)
            os.dup2(a, 3)
            os.dup2(b, 4)

        quiet = subprocess.DEVNULL
        command = [str(CHROMIUM), *FLAGS, f"--user-data-dir={profile}", f"--window-size={width},{height}"]
        self._process = subprocess.Popen(
            command, preexec_fn=wire, pass_fds=(3, 4), stdin=quiet, stdout=quiet, stderr=quiet
        )  # fmt: skip
        self.pid = self._process.pid
        os.close(to_read)
        os.close(to_write)
        self._buffer, self._number, self._session = b"", 0, ""
        self.complaints: list[str] = []
        """What went wrong in the page, or was refused to it."""
        target = self("Target.createTarget", url="about:blank")["targetId"]
        self._session = self("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self(f"{domain}.enable")
        self("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def __call__(self, method: str, **parameters: Any) -> Any:
        """Give an order and return its answer."""
        self._number += 1
        order = {"id": self._number, "method": method, "params": parameters}
        order |= {"sessionId": self._session} if self._session else {}
        os.write(self._out, json.dumps(order).encode() + b"\0")
        while True:
            answer = self._read()
            if answer.get("id") == self._number:
                assert "error" not in answer, f"{method}: {answer['error']}"
                return answer["result"]

    def _read(self) -> Any:
        while b"\0" not in self._buffer:
            ready, _, _ = select.select([self._in], [], [], PATIENCE_s)
            assert ready, f"the browser does not answer; {self.complaints}"
            piece = os.read(self._in, 1 << 20)
            assert piece, "the browser has ended"
            self._buffer += piece
        message, _, self._buffer = self._buffer.partition(b"\0")
        found = json.loads(message)
        sentence = {
            "Runtime.exceptionThrown": lambda p: (
                p["exceptionDetails"].get("exception", {}).get("description", "exception")
            ),
            "Log.entryAdded": lambda p: p["entry"]["text"] if p["entry"]["level"] == "error" else "",
        }.get(found.get("method", ""))
        if sentence is not None and sentence(found["params"]):
            self.complaints.append(sentence(found["params"]))
        if found.get("method") == "Network.requestWillBeSent":
            self.requests = [*getattr(self, "requests", []), found["params"]["request"]["url"]]
        return found

    def open(self, url: str) -> None:
        """Go to an address and wait until the page says that it is ready."""
        self.requests: list[str] = []
        self("Page.navigate", url="about:blank")
        self("Page.navigate", url=url)
        self.until("document.documentElement?.dataset.ready === 'yes'")

    def run(self, script: str) -> Any:
        """The value of a JavaScript expression."""
        answer = self("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def until(self, condition: str) -> None:
        """Wait for a condition of the page."""
        deadline = time.monotonic() + PATIENCE_s
        while not self.run(condition):
            assert time.monotonic() < deadline, f"never {condition}; {self.complaints}"
            time.sleep(0.02)

    def key(self, key: str) -> None:
        """Press a key."""
        for kind in ("keyDown", "keyUp"):
            self("Input.dispatchKeyEvent", type=kind, key=key)

    def picture(self, selector: str = "") -> bytes:
        """The page, or the part of it that a selector finds, as PNG."""
        clip = {}
        if selector:
            box = self.run(f"(r => ({{x: r.x, y: r.y, width: r.width, height: r.height, scale: 1}}))"
                           f"(document.querySelector('{selector}').getBoundingClientRect())")  # fmt: skip
            clip = {"clip": box}
        return base64.b64decode(self("Page.captureScreenshot", format="png", **clip)["data"])

    def paper(self) -> bytes:
        """The page as PDF."""
        return base64.b64decode(self("Page.printToPDF", printBackground=True)["data"])

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._process.kill()
        self._process.wait()
        os.close(self._in)
        os.close(self._out)
