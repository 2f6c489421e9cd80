"""Two hosts as two network namespaces with a cable between them: the same digest, also over a bad line, and a sentence
when the cable is cut off with its host.

Where the kernel does not allow namespaces these stories are skipped with its reason.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from heavylift.recordings import Recording
from of_a_yard import ended, start, until

HUB, FAR = "10.77.0.1", "10.77.0.2"
PORT = 7447


def ip(*words: str, tool: str = "ip") -> None:
    """A command that changes the network of this machine, or the reason why it may not."""
    try:
        done = subprocess.run([tool, *words], capture_output=True, text=True, timeout=10)
    except FileNotFoundError:
        pytest.skip(f"there is no command '{tool}' here: hosts cannot be distinguished by network namespaces")
    if done.returncode:
        pytest.skip(f"the kernel does not allow '{tool} {' '.join(words)}': {done.stderr.strip()}")


@pytest.fixture
def cable() -> Iterator[tuple[str, str]]:
    """Names of two network namespaces that reach each other, and nothing else, at HUB and FAR."""
    here, there = f"hl-a-{os.getpid()}", f"hl-b-{os.getpid()}"
    try:
        for name in (here, there):
            ip("netns", "add", name)
        ip("link", "add", "yard-a", "netns", here, "type", "veth", "peer", "name", "yard-b", "netns", there)
        for name, device, address in ((here, "yard-a", HUB), (there, "yard-b", FAR)):
            ip("-n", name, "addr", "add", f"{address}/24", "dev", device)
            ip("-n", name, "link", "set", device, "up")
            ip("-n", name, "link", "set", "lo", "up")
        yield here, there
    finally:
        for name in (here, there):
            subprocess.run(["ip", "netns", "delete", name], capture_output=True, check=False)


def over(cable: tuple[str, str], folder: Path, keys: Path) -> str:
    """Digest of `lift` with the block and the kernel on the other host."""
    here, there = cable
    place = ["--place", "block,kernel=yard-b", "--remote", "yard-b", "--listen", f"tls/{HUB}:{PORT}"]
    run = start(folder, "run", "lift", *place, "--certificates", keys, "-o", "run.mcap", inside=here)
    until(run, "waiting for process yard-b")
    arguments = ["node", "yard-b", "--connect", f"tls/{HUB}:{PORT}", "--certificates", keys]
    node = start(folder, *arguments, inside=there)
    code, text = ended(node)
    assert code == 0, text
    code, text = ended(run)
    assert code == 0, text
    return str(Recording(folder / "run.mcap").result["digest"])


@pytest.mark.large
def test_a_run_on_two_hosts_has_the_same_digest_as_on_one(
    cable: tuple[str, str], tmp_path: Path, keys: Path, truth: str
) -> None:
    assert over(cable, tmp_path, keys) == truth


def test_a_network_that_delays_and_loses_packets_does_not_change_any_byte_of_the_recording(
    cable: tuple[str, str], tmp_path: Path, keys: Path, truth: str
) -> None:
    for name, device in zip(cable, ("yard-a", "yard-b"), strict=True):
        line = ["qdisc", "add", "dev", device, "root", "netem", "delay", "2ms", "1ms", "loss", "2%"]
        ip("-n", name, *line, tool="tc")
    assert over(cable, tmp_path, keys) == truth


def test_the_coordinator_is_reachable_at_its_own_address_only(
    cable: tuple[str, str], tmp_path: Path, keys: Path
) -> None:
    here, there = cable
    listen = f"tls/127.0.0.1:{PORT}"
    run = start(tmp_path, "run", "lift", "--remote", "block", "--listen", listen, "--certificates", keys, inside=here)
    until(run, "waiting for process block")
    knock = f"import socket; socket.create_connection(('{HUB}', {PORT}), 2)"
    tried = subprocess.run(
        ["ip", "netns", "exec", there, "python3", "-c", knock], capture_output=True, text=True, timeout=20
    )
    run.kill()
    ended(run)
    assert "ConnectionRefusedError" in tried.stderr
