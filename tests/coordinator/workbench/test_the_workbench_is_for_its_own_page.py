"""Requests: only with the word, from this machine's own page; writes only inside the folder, over a known version."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import msgspec
import pytest

pytest.importorskip("starlette")
from heavylift.coordinator.workbench import OpenScene, application, runs, version_of
from starlette.testclient import TestClient

WORD, PORT = "word", 4711
PATIENCE_s = 30.0
HERE = f"http://127.0.0.1:{PORT}"


@pytest.fixture
def opened(folder: Path) -> OpenScene:
    """An open scene whose threads are not at work: nothing is previewed."""
    return OpenScene(folder, folder / "my-lift.yaml")


@pytest.fixture
def page(opened: OpenScene) -> TestClient:
    return TestClient(application(opened, WORD, PORT), base_url=HERE)


def test_workbench_requests_without_the_secret_word_are_refused(page: TestClient) -> None:
    answer = page.get(f"/{WORD}/")
    assert answer.status_code == 200
    assert "default-src 'none'" in answer.text
    assert (answer.headers["X-Frame-Options"], answer.headers["Cache-Control"]) == ("DENY", "no-store")
    for path in ("/", "/other/", "/wordy/", "/events", "/save"):
        assert page.get(path).status_code == 404
    assert page.post("/other/save", json={}).status_code == 404


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "evil.example"},
        {"Host": "127.0.0.1:80"},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
    ],
)
def test_workbench_requests_from_other_sites_are_refused(
    page: TestClient, folder: Path, headers: dict[str, str]
) -> None:
    before = (folder / "my-lift.yaml").read_text()
    assert page.get(f"/{WORD}/", headers=headers).status_code == 403
    body = {"text": "heavylift: 1\n", "version": version_of(before)}
    assert page.post(f"/{WORD}/save", json=body, headers=headers).status_code == 403
    assert (folder / "my-lift.yaml").read_text() == before


def test_saving_a_scene_is_refused_unless_the_request_names_the_present_version(page: TestClient, folder: Path) -> None:
    path = folder / "my-lift.yaml"
    before = path.read_text()
    answer = page.post(f"/{WORD}/save", json={"text": "heavylift: 1\n", "version": version_of(before)})
    assert answer.json()["answer"]["version"] == version_of("heavylift: 1\n")
    second = page.post(f"/{WORD}/save", json={"text": before, "version": version_of(before)})
    assert second.status_code == 409
    assert "changed elsewhere" in second.json()["error"]
    assert path.read_text() == "heavylift: 1\n"


def test_several_edits_in_one_request_of_the_workbench_are_made_together_or_not_at_all(
    page: TestClient, folder: Path
) -> None:
    path = folder / "my-lift.yaml"
    before = path.read_text()
    good = {"path": ["block", "mass"], "value": "310 t"}
    bad = {"path": ["block", "mass", "of"], "value": "1"}
    for edits, status in (([good, bad], 409), ([good], 200)):
        answer = page.post(f"/{WORD}/edit", json={"edits": edits, "version": version_of(before)})
        assert answer.status_code == status
        assert path.read_text() == (before if status == 409 else before.replace("mass: 300 t", "mass: 310 t"))


@pytest.mark.parametrize("name", ["../secret.yaml", "/etc/passwd", "sub/../../secret.yaml", "link.yaml", "notes.txt"])
def test_the_workbench_opens_no_file_outside_its_folder(
    page: TestClient, opened: OpenScene, folder: Path, name: str
) -> None:
    (folder.parent / "secret.yaml").write_text("heavylift: 1\n")
    (folder / "notes.txt").write_text("heavylift: 1\n")
    (folder / "link.yaml").symlink_to(folder.parent / "secret.yaml")
    assert page.post(f"/{WORD}/open", json={"name": name}).status_code == 409
    assert opened.scene == folder / "my-lift.yaml"


def test_a_bundled_scene_is_read_only_and_can_be_copied(page: TestClient, opened: OpenScene, folder: Path) -> None:
    assert page.post(f"/{WORD}/open", json={"name": "jib"}).status_code == 200
    assert opened.scene is not None
    text = opened.scene.read_text()
    assert page.post(f"/{WORD}/save", json={"text": "", "version": version_of(text)}).status_code == 409
    for name in ("../out", "a/b", "", ".hidden", "my-lift"):
        assert page.post(f"/{WORD}/copy", json={"name": name}).status_code == 409
    assert page.post(f"/{WORD}/copy", json={"name": "my-jib"}).status_code == 200
    assert (folder / "my-jib.yaml").read_text() == text
    assert opened.own
    assert {x.name for x in folder.iterdir()} == {"my-lift.yaml", "my-jib.yaml"}


SLEEPER = """import signal, sys, time
signal.signal(signal.SIGINT, lambda *_: sys.exit(130))
print("    0.0 s  lift off", "watch it at http://127.0.0.1:8/word/", sep=chr(10), flush=True)
time.sleep(60)
"""


def test_the_workbench_runs_one_simulation_at_a_time_and_can_stop_it(
    page: TestClient, opened: OpenScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    def ask(do: str) -> tuple[int, str]:
        answer = page.post(f"/{WORD}/run", json={"do": do})
        return answer.status_code, answer.json().get("error", "")

    def said(key: str, value: object) -> None:
        deadline = time.monotonic() + PATIENCE_s
        while not any(m.kind == "run" and msgspec.json.decode(m.data).get(key) == value for m in opened.since(0)):
            assert time.monotonic() < deadline
            time.sleep(0.02)

    monkeypatch.setattr(runs, "COMMAND", [sys.executable, "-c", SLEEPER])
    assert ask("stop") == (409, "no run is in progress")
    assert page.get(f"/{WORD}/live").status_code == 404
    assert ask("run") == (200, "")
    said("live", True)
    assert "a run is in progress" in ask("run")[1]
    assert "is not an order" in ask("dance")[1]
    assert ask("stop") == (200, "")
    said("code", 130)
    assert ask("stop") == (409, "no run is in progress")


@pytest.mark.parametrize(
    "name", ["../secret.svg", "my-lift.yaml", "link.svg", "page.html", "nothing.pdf", "x/../../secret.svg"]
)
def test_the_workbench_serves_only_documents_inside_its_folder(page: TestClient, folder: Path, name: str) -> None:
    (folder.parent / "secret.svg").write_text("<svg/>")
    (folder / "page.html").write_text("<script>alert(1)</script>")
    (folder / "link.svg").symlink_to(folder.parent / "secret.svg")
    assert page.get(f"/{WORD}/kept/{name}").status_code in (404, 409)


def test_pages_of_studies_run_no_scripts(page: TestClient, folder: Path) -> None:
    (folder / "my-lift-limits.html").write_text("<script>alert(1)</script>")
    answer = page.get(f"/{WORD}/kept/my-lift-limits.html")
    assert answer.status_code == 200
    assert answer.headers["Content-Security-Policy"].startswith("sandbox; default-src 'none'")
    assert page.get(f"/{WORD}/folder").json()["studies"] == ["my-lift-limits.html"]


def test_the_workbench_refuses_an_invalid_name_for_a_new_scene(page: TestClient, folder: Path) -> None:
    for name in ("Lift A 300t", "ü", "", "../other", "9-lives"):
        answer = page.post(f"/{WORD}/new", json={"name": name, "like": "lift"})
        assert answer.status_code == 409
        assert "choose a name such as my-lift" in answer.json()["error"]
    assert not [path for path in folder.iterdir() if path.stem in ("Lift A 300t", "9-lives")]


def test_a_new_scene_never_replaces_an_existing_scene_file(page: TestClient, opened: OpenScene, folder: Path) -> None:
    before = (folder / "my-lift.yaml").read_text()
    for name, like in (("my-lift", "tandem"), ("../out", "tandem"), ("", "tandem"), ("pair", "../lift")):
        assert page.post(f"/{WORD}/new", json={"name": name, "like": like}).status_code == 409
    assert (folder / "my-lift.yaml").read_text() == before
    assert page.post(f"/{WORD}/new", json={"name": "pair", "like": "tandem"}).status_code == 200
    assert (folder / "pair.yaml").read_text().count("name: pair\n") == 1
    assert opened.scene == folder / "pair.yaml"


@pytest.mark.parametrize(
    ("body", "kind", "status"),
    [
        (b"{}", "application/json", 400),
        (b"not JSON", "application/json", 400),
        (b"{}", "text/plain", 415),
        (b" " * (2 << 20), "application/json", 413),
    ],
)
def test_a_malformed_workbench_request_is_refused(page: TestClient, body: bytes, kind: str, status: int) -> None:
    assert page.post(f"/{WORD}/save", content=body, headers={"Content-Type": kind}).status_code == status
