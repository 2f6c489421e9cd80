"""No network socket, a directory for this user only, and no way from one run or node into another."""

import os
import queue
import stat
import sys
from pathlib import Path

import pytest
import zenoh
from heavylift.coordinator.transport import OBSERVER, Hub, LocalHub, guest_session, key, node_session
from heavylift.kernel import ProtocolError
from msgspec import structs
from of_the_system import Start, network_sockets, sockets

GUESTS = ("observer", "operator")
linux_only = pytest.mark.skipif(sys.platform != "linux", reason="watches processes in /proc, which only Linux has")


@linux_only
def test_no_process_of_a_run_has_a_network_socket(start: Start) -> None:
    before = network_sockets(os.getpid())
    _, processes = start(west=(), east=())
    assert network_sockets(os.getpid()) == before
    for pid in (*processes.pids.values(), processes._keeper.pid):
        assert network_sockets(pid) == []


@linux_only
def test_a_run_in_one_process_opens_no_socket_at_all() -> None:
    before = sockets(os.getpid())
    with LocalHub(["west"]) as hub:
        hub.link("west")
        assert sockets(os.getpid()) == before


def test_only_the_user_may_enter_the_run_directory() -> None:
    with Hub(["west"]) as hub:
        assert stat.S_IMODE(hub.directory.path.stat().st_mode) == 0o700
        kept = [path for path in hub.directory.path.iterdir() if path.is_file() and path.stat().st_size]
        assert sorted(path.name for path in kept) == ["observer", "operator"]  # a file of all passwords is gone
        assert {stat.S_IMODE(path.stat().st_mode) for path in kept} == {0o600}
        for user, password in hub._passwords.items():
            assert [path.name for path in kept if password in path.read_text()] == [user] * (user in GUESTS)
        assert stat.S_ISSOCK(Path(hub.directory.socket).stat().st_mode)
        assert len(hub.directory.socket.encode()) < 104
    assert not hub.directory.path.exists()


def test_a_run_finds_a_place_for_its_socket_if_the_temporary_directory_has_a_long_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    deep = tmp_path / ("a" * 120)
    deep.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(deep))
    with Hub(["west"]) as hub:
        assert len(hub.directory.socket.encode()) < 104


def test_the_ticket_to_join_a_run_appears_neither_on_a_command_line_nor_in_the_environment(start: Start) -> None:
    hub, processes = start(west=())
    secret = hub.ticket("west").password.encode()
    node = Path(f"/proc/{processes.pids['west']}")
    for pid in (processes.pids["west"], processes._keeper.pid):
        for place in ("cmdline", "environ"):
            assert secret not in Path(f"/proc/{pid}/{place}").read_bytes()
    assert (node / "fd" / "0").readlink() == Path(os.devnull)  # it was there, and has been read


def test_two_runs_at_the_same_time_do_not_disturb_each_other(start: Start) -> None:
    first, _ = start(west=(), east=())
    second, other = start(west=(), east=())
    assert first.run != second.run
    assert first.directory.path != second.directory.path
    for number in range(50):
        first.send("west", b"first %d" % number)
        second.send("west", b"second %d" % number)
        assert first.receive(5) == ("west", b"first %d" % number)
        assert second.receive(5) == ("west", b"second %d" % number)
    second.dismiss(b"stop")
    other.end()
    second.close()
    first.send("east", b"still here")
    assert first.receive(5) == ("east", b"still here")


def test_a_node_cannot_send_under_the_name_of_another(start: Start) -> None:
    hub, _ = start(west=())
    with Hub(["west"]) as other, node_session(other.ticket("west")) as session:
        for at in (
            key(other.run, "out", "east", "east"),
            key(hub.run, "out", "west", "west"),
            key(other.run, "out", "~hub", "~hub"),
        ):
            session.put(at, b"forged", congestion_control=zenoh.CongestionControl.BLOCK)
        assert other.receive(0.1) is None
    assert hub.receive(0.1) is None


def test_a_node_with_a_wrong_password_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("heavylift.coordinator.transport.session.CONNECT_ms", 100)
    with Hub(["west", "east"]) as hub:
        ticket = hub.ticket("west")
        wrong = structs.replace(ticket, process="east")
        with pytest.raises(ProtocolError, match="process east cannot join run"):
            node_session(wrong)


def test_an_observer_of_a_run_receives_its_events_but_no_messages_between_nodes(start: Start) -> None:
    hub, _ = start(west=())
    seen: queue.SimpleQueue[tuple[str, bytes]] = queue.SimpleQueue()

    def note(sample: zenoh.Sample) -> None:
        seen.put((str(sample.key_expr).removeprefix(f"heavylift/{hub.run}/"), sample.payload.to_bytes()))

    with guest_session(hub.directory.path, OBSERVER) as session:
        for pattern in ("event/**", "in/west/west", "out/west/west", "**"):
            session.declare_subscriber(key(hub.run, pattern), note)
        heard = None
        while heard is None:  # the first events come before the observer's wish to see them
            hub.publish_event("west.hoist", "done", b"1")
            try:
                heard = seen.get(timeout=0.05)
            except queue.Empty:
                continue
        hub.send("west", b"private")
        assert hub.receive(5) == ("west", b"private")
        hub.publish_event("block", "lifted", b"2")
        while heard[1] == b"1":
            assert heard[0] == "event/west.hoist/done"
            heard = seen.get(timeout=5)
        assert heard == ("event/block/lifted", b"2")


def test_an_observer_that_stops_reading_does_not_stop_the_run(start: Start) -> None:
    hub, processes = start(west=(), watcher=("observe",))
    os.kill(processes.pids["watcher"], 19)
    for _ in range(2000):
        hub.publish_event("west.hoist", "done", b"e" * 1000)
    hub.send("west", b"go on")
    assert hub.receive(5) == ("west", b"go on")
