"""Over TLS on the loopback interface: who has the right certificate takes part, all others are refused by a sentence
on both sides, and the run goes on to the same digest."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest
import zenoh
from heavylift.coordinator.commands import open_listener
from heavylift.coordinator.hosts import Credentials, RemoteListener, library, make_certificates, play
from heavylift.coordinator.participants import fingerprint
from heavylift.coordinator.run import run as simulate
from heavylift.coordinator.transport import (
    AFAR,
    FrameTopic,
    Hub,
    NodeLink,
    Placement,
    Writer,
    key,
    place,
    remote_session,
)
from heavylift.kernel import HeavyliftError, ProtocolError
from heavylift.nodes.plan import encode
from heavylift.nodes.scene import load
from heavylift.recordings import Recording
from of_a_yard import PATIENCE_s, ended, finish, free_port, start, until


def coordinator(folder: Path, keys: Path, *arguments: str, scene: str = "lift") -> tuple[subprocess.Popen[str], str]:
    """A run that waits for its remote processes, and where to connect to."""
    endpoint = f"tls/127.0.0.1:{free_port()}"
    run = start(folder, "run", scene, "--listen", endpoint, "--certificates", keys, "-o", "run.mcap", *arguments)
    return run, endpoint


@pytest.mark.large
def test_the_command_printed_by_the_coordinator_lets_a_remote_process_join(
    tmp_path: Path, keys: Path, truth: str
) -> None:
    run, endpoint = coordinator(tmp_path, keys, "--remote", "block")
    asked = until(run, "waiting for process block")
    command = asked.split("on its host type: heavylift ")[1].replace("DIRECTORY", str(keys)).split()
    assert command[:4] == ["node", "block", "--connect", endpoint]
    code, text = finish(tmp_path, *command)
    assert code == 0, text
    number = command[-1]
    assert text == f"joined run {number} at {endpoint} with block\nrun {number} is over\n"
    code, text = ended(run)
    assert code == 0, text
    assert re.match(r"process block on host \S+ has joined\n", text)
    assert Recording(tmp_path / "run.mcap").result["digest"] == truth


def foreign(tmp_path: Path, keys: Path) -> tuple[Credentials, str]:
    """Keys that another yard has made, whose authority we are reported to trust or not."""
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


def no_certificate(endpoint: str, keys: Path) -> dict[str, object]:
    """Zenoh's settings of somebody who trusts the coordinator and shows nothing."""
    tls = {"root_ca_certificate": str(keys / "yard.pem"), "verify_name_on_connect": True}
    return {"protocols": ["tls"], "tls": tls, "endpoint": endpoint}


def plain_tcp(endpoint: str, keys: Path) -> dict[str, object]:
    """Zenoh's settings of somebody who does not encrypt."""
    return {"protocols": ["tcp"], "tls": {}, "endpoint": endpoint.replace("tls/", "tcp/")}


def test_a_remote_process_without_a_valid_certificate_is_refused_and_the_run_continues(
    tmp_path: Path, keys: Path, truth: str
) -> None:
    run, endpoint = coordinator(tmp_path, keys, "--remote", "block")
    until(run, "waiting for process block")

    def refused(name: str, credentials: Credentials, run_id: str = "", scene: str = "") -> str:
        with pytest.raises(ProtocolError) as error:
            play(name, RemoteListener.at(endpoint, credentials), run_id, scene, print)
        return str(error.value)

    own = Credentials.load(keys, "block")
    for name, credentials, insists, message in (
        (
            "crane",
            Credentials.load(keys, "crane"),
            (),
            "process 'crane' runs on the coordinator's host; those of other",
        ),
        ("yard-b", Credentials.load(keys, "yard-b"), (), "this run has no process 'yard-b'; it waits for block"),
        ("block", own, ("feed",), "it insists on run feed, but this is run "),
        ("block", own, ("", "other"), "its scene is not the one that is run; give both hosts the same file"),
    ):
        assert refused(name, credentials, *insists).startswith(f"process {name} may not join: {message}")
        assert re.search(rf"refused process {name} on host \S+: {re.escape(message)}", until(run, "refused"))
    for wrong in (foreign, distrustful, expired):
        (tmp_path / wrong.__name__).mkdir()
        credentials, message = wrong(tmp_path / wrong.__name__, keys)
        assert re.match(f"process block cannot join: .*{message}", refused("block", credentials))
    for stranger in (no_certificate, plain_tcp):
        link = stranger(endpoint, keys)
        config = {
            "mode": "client",
            "connect": {"endpoints": [link.pop("endpoint")], "timeout_ms": 300, "exit_on_failure": True},
            "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
            "transport": {"link": link, "auth": {"usrpwd": {"user": AFAR, "password": AFAR}}},
        }
        with pytest.raises(zenoh.ZError):
            zenoh.open(zenoh.Config.from_json5(json.dumps(config)))
    play("block", RemoteListener.at(endpoint, own), "", fingerprint(encode(load("lift").plan)), print)
    assert ended(run)[0] == 0
    assert Recording(tmp_path / "run.mcap").result["digest"] == truth


BOTH = Placement({"block": ("block",), "crane": ("crane",)}, frozenset({"block", "crane"}))


def test_a_remote_process_of_another_version_or_with_a_name_already_in_use_is_refused(
    keys: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    endpoint, text = f"tls/127.0.0.1:{free_port()}", list[str]()
    there = RemoteListener.at(endpoint, Credentials.load(keys, "block"))
    with (
        Hub(BOTH, RemoteListener.at(endpoint, Credentials.load(keys, "coordinator"))) as hub,
        remote_session(there) as session,
    ):
        hub.admit("", text.append)
        with monkeypatch.context() as other:
            other.setattr("heavylift.coordinator.hosts.remote_node.__version__", "0.0.1")
            with pytest.raises(ProtocolError, match=r"runs heavylift 0\.0\.1, the coordinator \S+; install"):
                play("block", there, "", "", print)
        with monkeypatch.context() as other:
            other.setattr("heavylift.coordinator.hosts.remote_node.code", lambda: "of an edited file")
            with pytest.raises(ProtocolError, match=r"files of one of them were changed; install heavylift \S+"):
                play("block", there, "", "", print)
        link = NodeLink(hub.ticket("block"), session)
        assert link.nodes == hub.placement.hosted["block"]
        hub._gate.hosts["block"] = "far-away"  # type: ignore[union-attr]
        with pytest.raises(ProtocolError, match="may not join: process 'block' is there already, on host far-away"):
            play("block", there, "", "", print)
        assert [line for line in text if "refused process block on host" in line] == text[-3:]


def test_a_certificate_restricts_a_process_to_the_keys_of_its_own_name(keys: Path) -> None:
    """A process of this yard that writes in place of another is not heard, whatever it calls itself."""
    endpoint = f"tls/127.0.0.1:{free_port()}"
    there = RemoteListener.at(endpoint, Credentials.load(keys, "block"))
    with (
        Hub(BOTH, RemoteListener.at(endpoint, Credentials.load(keys, "coordinator"))) as hub,
        remote_session(there) as session,
    ):
        for node in ("crane", "block"):
            frame = Writer(hub.run, node, FrameTopic.OUT, 1).frame(b"by block")
            at = key(hub.run, "out", node, node)
            session.put(at, frame, congestion_control=zenoh.CongestionControl.BLOCK)
        assert hub.receive(5) == ("block", b"by block")
        assert hub.receive(0.2) is None


@pytest.mark.large
def test_a_lost_remote_process_is_named_with_its_host_and_replaced(tmp_path: Path, keys: Path) -> None:
    run, endpoint = coordinator(tmp_path, keys, "--place", "block=yard-b", "--remote", "yard-b", scene="turnover")
    node = start(tmp_path, "node", "yard-b", "--connect", endpoint, "--certificates", keys)
    until(run, " s  load")
    node.kill()
    node.communicate()
    message = until(run, "node block")
    assert re.match(r"node block \(process yard-b on host \S+\) is replaced at t = \d+\.\d{3} s: ", message), message
    until(run, "waiting for process yard-b; on its host type: heavylift node yard-b")
    code, text = finish(tmp_path, "node", "yard-b", "--connect", endpoint, "--certificates", keys)
    assert code == 0, text
    code, text = ended(run)
    assert code == 0, text
    assert Recording(tmp_path / "run.mcap").result["status"] == "finished"


@pytest.mark.large
def test_a_remote_process_does_not_outlive_its_coordinator(tmp_path: Path, keys: Path) -> None:
    run, endpoint = coordinator(tmp_path, keys, "--remote", "block", scene="turnover")
    node = start(tmp_path, "node", "block", "--connect", endpoint, "--certificates", keys)
    until(run, " s  load")
    run.kill()
    ended(run)
    _, text = node.communicate(timeout=PATIENCE_s)
    assert node.returncode == 86
    assert f"at {endpoint} is gone; join again after the run has been restarted" in text


@pytest.mark.parametrize(
    ("remote", "listen", "in_process", "told"),
    [
        (["block"], "", False, "process block runs on another host, say where it can reach this one: --listen tls/"),
        (["blok"], "", False, "--remote 'blok': there is no process 'blok'; the processes are block, crane"),
        ([], "tls/127.0.0.1:1", False, "--listen tls/127.0.0.1:1: no process runs on another host"),
        (["block"], "tcp/127.0.0.1:7447", False, "tcp/127.0.0.1:7447: hosts may connect only over TLS"),
        (["block"], "7447", False, "'7447' is not a valid address; write tls/HOST:PORT"),
        (["block"], "tls/here:99999", False, "'tls/here:99999' is not a valid address; write tls/HOST:PORT"),
        (["block"], "tls/127.0.0.1:7447", True, "--in-process: process block is placed on another host"),
    ],
)
def test_invalid_options_for_remote_processes_are_refused_before_any_port_is_opened(
    keys: Path, remote: list[str], listen: str, in_process: bool, told: str
) -> None:
    with pytest.raises(HeavyliftError) as error:
        open_listener(place(["block", "crane"], {}, remote=remote).remote, listen, keys, in_process)
    assert str(error.value).startswith(told)


@pytest.mark.large
def test_a_scene_may_place_several_nodes_and_the_kernel_on_another_host(
    tmp_path: Path, keys: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "two-hosts.yaml").write_text(
        "heavylift: 1\nname: lift\nextends: lift\nplacement:\n  "
        "yard-b: {nodes: [kernel, crane, loader-1], host: remote}\n"
    )
    monkeypatch.chdir(tmp_path)
    alone = simulate(load("two-hosts.yaml"), tmp_path / "alone.mcap", in_process=True)
    run, endpoint = coordinator(tmp_path, keys, scene="two-hosts.yaml")
    code, text = finish(tmp_path, "node", "yard-b", "--connect", endpoint, "--certificates", keys)
    assert code == 0, text
    assert ended(run)[0] == 0
    assert Recording(tmp_path / "run.mcap").result["digest"] == alone.digest


def test_a_remote_node_that_finds_no_coordinator_ends_with_a_clear_message(
    tmp_path: Path, keys: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("heavylift.coordinator.transport.session.CONNECT_ms", 300)
    listener = RemoteListener.at(f"tls/127.0.0.1:{free_port()}", Credentials.load(keys, "block"))
    with pytest.raises(ProtocolError, match="this process is not admitted at tls/"):
        play("block", listener, "", "", print)
