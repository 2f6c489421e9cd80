"""The reference node in Rust, built here, is one station of a ring: the digest is that of a run in Python only."""

from __future__ import annotations

import os
import shutil
import subprocess
import threading
import time
from importlib import metadata
from pathlib import Path

import pytest
from heavylift import run_models
from heavylift.nodes.devs import ms

CRATE = Path(__file__).parents[1] / "coordinator/external/rust"
PATIENCE_s = 60.0


@pytest.fixture(scope="module")
def node() -> Path:
    cargo = shutil.which("cargo")
    if cargo is None:
        pytest.skip("NO CARGO HERE: the node in Rust was neither built nor run, install Rust to test it")
    target = Path(os.environ.get("CARGO_TARGET_DIR", CRATE / "target"))
    subprocess.run([cargo, "build", "--release", "--target-dir", target], cwd=CRATE, check=True)
    return target / "release/reference-node"


def test_the_rust_example_uses_the_zenoh_version_of_the_python_package() -> None:
    assert f'version = "={metadata.version("eclipse-zenoh")}"' in (CRATE / "Cargo.toml").read_text()


@pytest.mark.parametrize(("stations", "tokens", "hold"), [(2, 1, ms(5)), (4, 2, ms(5)), (3, 3, ms(1)), (3, 1, 1)])
def test_a_run_with_a_node_in_rust_has_the_same_digest(
    node: Path, tmp_path, monkeypatch, stations, tokens, hold
) -> None:
    ring, until = f"heavylift.nodes.zoo.token_ring:ring({stations}, {tokens}, {hold})", 101 * hold
    monkeypatch.chdir(tmp_path)
    ended: list[int] = []

    def play() -> None:
        ticket, deadline = tmp_path / "s1.ticket", time.monotonic() + PATIENCE_s
        while not ticket.exists() and time.monotonic() < deadline:
            time.sleep(0.01)
        ended.append(subprocess.run([node, ticket], timeout=PATIENCE_s, check=False).returncode)

    player = threading.Thread(target=play)
    player.start()
    run = run_models(ring, until=until / 1e9, external=["s1"])
    player.join()
    assert (ended, run.digest) == ([0], run_models(ring, until=until / 1e9, in_process=True).digest)
