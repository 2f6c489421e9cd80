"""Whatever ends the server, each edit that it has accepted is in the file; one of two browsers replaces a version."""

from __future__ import annotations

import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import httpx
import pytest
from heavylift.coordinator.workbench import edited, version_of

PATIENCE_s = 60.0
SERVER = """import sys
from heavylift.coordinator.workbench import workbench
workbench(sys.argv[1], lambda url: print(url, flush=True))
"""


@pytest.mark.parametrize("accepted", [1, 4, 9])
def test_each_accepted_edit_in_the_workbench_is_on_disk_if_the_server_is_killed(folder: Path, accepted: int) -> None:
    scene = folder / "my-lift.yaml"
    command = [sys.executable, "-c", SERVER, str(scene)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server, ThreadPoolExecutor() as threads:
        assert server.stdout is not None
        url, text = server.stdout.readline().strip(), scene.read_text()

        def ask(mass: int) -> httpx.Response:
            edits = [{"path": ["block", "mass"], "value": f"{mass} t"}]
            return httpx.post(f"{url}edit", json={"edits": edits, "version": version_of(text)}, timeout=PATIENCE_s)

        for number in range(accepted):
            answer = ask(301 + number)
            assert answer.status_code == 200, answer.text
            text = answer.json()["answer"]["text"]
        last = threads.submit(ask, 400)  # which the death may overtake or not
        server.send_signal(signal.SIGKILL)
        last.exception(PATIENCE_s)
    assert scene.read_text() in (text, edited(text, ["block", "mass"], "400 t"))
    assert f"mass: {300 + accepted} t" in text


def test_only_one_of_two_simultaneous_edits_of_the_same_version_is_accepted(folder: Path, address: str) -> None:
    scene = folder / "my-lift.yaml"
    text = scene.read_text()

    def ask(mass: int) -> int:
        edits = [{"path": ["block", "mass"], "value": f"{mass} t"}]
        body = {"edits": edits, "version": version_of(text)}
        return httpx.post(f"{address}edit", json=body, timeout=PATIENCE_s).status_code

    with ThreadPoolExecutor() as browsers:
        answers = list(browsers.map(ask, range(301, 309)))
    assert sorted(answers) == [200, *7 * [409]]
    assert scene.read_text() == edited(text, ["block", "mass"], f"{301 + answers.index(200)} t")
