"""Over TLS on the loopback interface: who has the right certificate takes part, all others are refused by a sentence
on both sides, and the run goes on to the same digest."""

from __future__ import annotations

import os
import re
import signal
import subprocess
from pathlib import Path

import pytest
from heavylift.coordinator.certificates import Credentials, make_certificates
from heavylift.coordinator.door import Door
from heavylift.coordinator.remote_node import play
from heavylift.coordinator.run import run as simulate
from heavylift.coordinator.x509 import library
from heavylift.kernel.errors import ProtocolError
from heavylift.nodes.scene import load
from heavylift.recordings import Recording
from of_a_yard import ended, finish, free_port, start, until

LOST_WITHIN_s = 10.0


def coordinator(folder: Path, keys: Path, *arguments: str, scene: str = "lift") -> tuple[subprocess.Popen[str], str]:
    """A run that waits for its remote processes, and where to connect to."""
    endpoint = f"tls/127.0.0.1:{free_port()}"
    run = start(folder, "run", scene, "--listen", endpoint, "--certificates", keys, "-o", "run.mcap", *arguments)
    return run, endpoint


def test_the_command_that_the_coordinator_asks_for_completes_the_run(tmp_path: Path, keys: Path, truth: str) -> None:
    run, endpoint = coordinator(tmp_path, keys, "--remote", "block")
    asked = until(run, "waiting for process block")
    command = asked.split("on its host type: heavylift ")[1].replace("DIRECTORY", str(keys)).split()
    assert command[:4] == ["node", "block", "--connect", endpoint]
    code, said = finish(tmp_path, *command)
    assert code == 0, said
    number = command[-1]
    assert said == f"joined run {number} at {endpoint} with block\nrun {number} is over\n"
    code, said = ended(run)
    assert code == 0, said
    assert re.match(r"process block on host \S+ has joined\n", said)
    assert Recording(tmp_path / "run.mcap").result["digest"] == truth


def test_a_remote_process_hosts_several_nodes_and_the_kernel(tmp_path: Path, keys: Path, truth: str) -> None:
    place = ["--place", "kernel,crane,loader-1=yard-b", "--remote", "yard-b", "--remote", "block"]
    run, endpoint = coordinator(tmp_path, keys, *place)
    nodes = [start(tmp_path, "node", p, "--connect", endpoint, "--certificates", keys) for p in ("block", "yard-b")]
    assert [ended(node)[0] for node in nodes] == [0, 0]
    assert ended(run)[0] == 0
    assert Recording(tmp_path / "run.mcap").result["digest"] == truth


def test_who_does_not_belong_is_refused_on_both_sides_and_the_run_goes_on(
    tmp_path: Path, keys: Path, truth: str
) -> None:
    run, endpoint = coordinator(tmp_path, keys, "--remote", "block")
    until(run, "waiting for process block")
    there = ["--connect", endpoint, "--certificates", keys]
    expected = [
        (["crane", *there], "process 'crane' runs on the coordinator's host; those of other hosts are block"),
        (["yard-b", *there], "this run has no process 'yard-b'; it waits for block"),
        (["block", *there, "--run", "feed"], "it insists on run feed, but this is run "),
        (["block", *there, "--scene", "pendulum"], "its scene is not the one that is run; give both hosts the same"),
    ]
    for arguments, told in expected:
        code, said = finish(tmp_path, "node", *arguments)
        assert code == 1
        assert said.startswith(f"heavylift: process {arguments[0]} may not join: {told}"), said
        assert re.search(rf"refused process {arguments[0]} on host \S+: {re.escape(told)}", until(run, "refused"))
    code, said = finish(tmp_path, "node", "block", *there, "--scene", "lift")
    assert code == 0, said
    assert ended(run)[0] == 0
    assert Recording(tmp_path / "run.mcap").result["digest"] == truth


def foreign(tmp_path: Path, keys: Path) -> tuple[Credentials, str]:
    """Keys that another yard has made, whose authority we are told to trust or not."""
    make_certificates(tmp_path / "foreign", ["block"])
    other = Credentials.load(tmp_path / "foreign", "block")
    return Credentials(keys / "yard.pem", other.certificate, other.key), "does not accept .*block.pem: .*"


def distrustful(tmp_path: Path, keys: Path) -> tuple[Credentials, str]:
    """A process that does not trust this coordinator's yard."""
    make_certificates(tmp_path / "foreign", ["block"])
    return Credentials.load(
        tmp_path / "foreign", "block"
    ), "the certificate shown at .* is not accepted: .*certificate.*"


def expired(tmp_path: Path, keys: Path) -> tuple[Credentials, str]:
    """A certificate of the right yard that ended half an hour ago."""
    use = library()
    pems = use.pems(
        *use.leaf("block", ("block",), -1 / 48, (use.x509_of(keys / "yard.pem"), use.key_of(keys / "yard.key")))
    )
    for end, data in zip(("pem", "key"), pems, strict=True):
        (tmp_path / f"block.{end}").write_bytes(data)
    return Credentials(keys / "yard.pem", tmp_path / "block.pem", tmp_path / "block.key"), "certificate expired"


@pytest.mark.parametrize("wrong", [foreign, distrustful, expired])
def test_a_wrong_certificate_is_refused_and_the_run_goes_on(
    tmp_path: Path, keys: Path, truth: str, wrong: object
) -> None:
    run, endpoint = coordinator(tmp_path, keys, "--remote", "block")
    until(run, "waiting for process block")
    credentials, told = wrong(tmp_path, keys)  # type: ignore[operator]
    with pytest.raises(ProtocolError, match=told) as error:
        play("block", Door.at(endpoint, credentials), "", "", print)
    assert str(error.value).startswith("process block cannot join: ")
    assert finish(tmp_path, "node", "block", "--connect", endpoint, "--certificates", keys)[0] == 0
    assert ended(run)[0] == 0
    assert Recording(tmp_path / "run.mcap").result["digest"] == truth


def test_a_process_of_this_run_is_there_once_only(tmp_path: Path, keys: Path) -> None:
    run, endpoint = coordinator(tmp_path, keys, "--remote", "block", "--remote", "crane")
    until(run, "waiting for process crane")
    first = start(tmp_path, "node", "block", "--connect", endpoint, "--certificates", keys)
    until(first, "joined run")
    code, said = finish(tmp_path, "node", "block", "--connect", endpoint, "--certificates", keys)
    assert code == 1
    assert re.fullmatch(r"heavylift: process block may not join: process 'block' is there already, on host \S+\n", said)
    assert finish(tmp_path, "node", "crane", "--connect", endpoint, "--certificates", keys)[0] == 0
    assert [ended(each)[0] for each in (first, run)] == [0, 0]


def test_a_lost_remote_process_is_named_with_its_host(tmp_path: Path, keys: Path) -> None:
    run, endpoint = coordinator(tmp_path, keys, "--place", "block=yard-b", "--remote", "yard-b", scene="turnover")
    node = start(tmp_path, "node", "yard-b", "--connect", endpoint, "--certificates", keys)
    until(run, " s  load")
    node.kill()
    node.communicate()
    code, said = ended(run)
    assert code == 1
    assert re.search(
        r"heavylift: node block \(process yard-b on host \S+\) is gone at t = \d+\.\d{3} s: .*; start the run again",
        said,
    ), said
    assert Recording(tmp_path / "run.mcap").result["status"] == "failed"


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_a_remote_process_does_not_outlive_its_coordinator(tmp_path: Path, keys: Path, number: int) -> None:
    run, endpoint = coordinator(tmp_path, keys, "--remote", "block", scene="turnover")
    node = start(tmp_path, "node", "block", "--connect", endpoint, "--certificates", keys)
    until(run, " s  load")
    os.kill(run.pid, number)
    ended(run)
    _, said = node.communicate(timeout=LOST_WITHIN_s)
    if number == signal.SIGKILL:
        assert node.returncode == 86
        assert f"at {endpoint} is gone; join again when it runs again" in said
    else:
        assert node.returncode == 0
        assert "is over" in said


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--remote", "block"], "process block runs on another host, say where it can reach this one: --listen tls/"),
        (["--remote", "blok"], "--remote 'blok': there is no process 'blok'; the processes are commander, crane, "),
        (["--listen", "tls/127.0.0.1:1"], "--listen tls/127.0.0.1:1: no process runs on another host"),
        (
            ["--remote", "block", "--listen", "tcp/127.0.0.1:7447"],
            "tcp/127.0.0.1:7447: hosts are connected by tls only",
        ),
        (["--remote", "block", "--listen", "7447"], "'7447' is no address, write tls/HOST:PORT"),
        (["--remote", "block", "--listen", "tls/here:99999"], "'tls/here:99999' is no address, write tls/HOST:PORT"),
        (["--remote", "block", "--in-process"], "--in-process: process block is placed on another host"),
    ],
)
def test_a_wrong_command_line_is_refused_before_anything_listens(
    tmp_path: Path, keys: Path, arguments: list[str], told: str
) -> None:
    code, said = finish(tmp_path, "run", "lift", "--certificates", keys, *arguments)
    assert code == 1
    assert said.startswith(f"heavylift: {told}"), said
    assert not list(tmp_path.iterdir())


def test_a_scene_may_place_a_process_on_another_host(
    tmp_path: Path, keys: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "two-hosts.yaml").write_text(
        "heavylift: 1\nname: lift\nextends: lift\nplacement:\n  yard-b: {nodes: [block, crane], host: remote}\n"
    )
    monkeypatch.chdir(tmp_path)
    alone = simulate(load("two-hosts.yaml"), tmp_path / "alone.mcap", in_process=True)
    run, endpoint = coordinator(tmp_path, keys, scene="two-hosts.yaml")
    code, said = finish(tmp_path, "node", "yard-b", "--connect", endpoint, "--certificates", keys)
    assert code == 0, said
    assert ended(run)[0] == 0
    assert Recording(tmp_path / "run.mcap").result["digest"] == alone.digest


def test_without_a_coordinator_the_node_says_so(tmp_path: Path, keys: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("heavylift.coordinator.session.CONNECT_ms", 300)
    door = Door.at(f"tls/127.0.0.1:{free_port()}", Credentials.load(keys, "block"))
    with pytest.raises(ProtocolError, match="nobody lets this process in at tls/"):
        play("block", door, "", "", print)
