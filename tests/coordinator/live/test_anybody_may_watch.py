"""Any number of observers, early, late, slow, frozen or killed: each sees all events, and the run does not notice."""

import json
import os
import signal
import threading
import time
from itertools import islice
from pathlib import Path

import pytest
from heavylift.coordinator.live import RunEnded, find, observe
from heavylift.kernel import ProtocolError
from heavylift.nodes.devs import Event
from heavylift.recordings import Recording
from running import PATIENCE_s, command, found, going, said

WATCHERS = 20
NAP_s = 0.002  # per event, of a slow observer


@pytest.mark.large
def test_each_observer_receives_every_event_once_and_in_order(tmp_path: Path) -> None:
    seen: dict[str, list[tuple[int, Event]]] = {}

    def watch(name: str, wait: float = 0.0, nap: float = 0.0) -> None:
        time.sleep(wait)
        seen[name] = got = []
        for numbered in observe(run):
            got.append(numbered)
            time.sleep(nap)

    with going(tmp_path, "run", "lift") as process:
        run = found(tmp_path / "lift.mcap")
        list(islice(observe(run), 1))
        os.kill(process.pid, signal.SIGSTOP)  # until both watch: on a loaded machine it would be over before
        frozen, killed = (command(tmp_path, "watch", run.notice.run) for _ in range(2))
        for observer in (frozen, killed):
            assert observer.stdout is not None
            assert observer.stdout.readline()  # it watches
        os.kill(frozen.pid, signal.SIGSTOP)
        killed.kill()
        os.kill(process.pid, signal.SIGCONT)
        threads = [threading.Thread(target=watch, args=(f"early {n}",)) for n in range(WATCHERS)]
        threads += [threading.Thread(target=watch, args=("late", 0.2))]
        threads += [threading.Thread(target=watch, args=("slow", 0.0, NAP_s))]
        for thread in threads:
            thread.start()
        assert process.wait(PATIENCE_s) == 0
        for thread in threads:
            thread.join(PATIENCE_s)
        os.kill(frozen.pid, signal.SIGCONT)
        assert frozen.stdout is not None
        thawed = frozen.stdout.read().splitlines()
        for observer in (frozen, killed):
            observer.communicate(timeout=PATIENCE_s)
    recording = Recording(tmp_path / "lift.mcap")
    truth = [(e.t_ns, e.microstep, e.source, e.port, e.index, e.type) for e in recording.events()]
    assert len(truth) > 50
    assert len(seen) == WATCHERS + 2
    for name, got in seen.items():
        assert [number for number, _ in got] == list(range(len(truth))), name
        assert [(e.t, e.k, e.source, e.port, e.index, e.type) for _, e in got] == truth, name
    assert len(thawed) == len(truth)  # one was read before, one says how the run ended
    assert thawed[-1] == "finished at 60.000000 s"


@pytest.fixture(scope="module")
def frozen_run(tmp_path_factory: pytest.TempPathFactory):  # type: ignore[no-untyped-def]
    """A run whose coordinator stands still in the middle, so that what can be seen of it does not change."""
    folder = tmp_path_factory.mktemp("frozen")
    with going(folder, "run", "lift") as process:
        run = found(folder / "lift.mcap")
        list(islice(observe(run), 40))
        os.kill(process.pid, signal.SIGSTOP)
        yield run, process


@pytest.mark.large
def test_a_run_in_progress_is_found_by_its_recording_run_id_or_scene(frozen_run) -> None:  # type: ignore[no-untyped-def]
    run, process = frozen_run
    notice = run.notice
    assert (notice.scene, notice.pid) == ("lift", process.pid)
    for name in (notice.recording, notice.recording + ".part", notice.run, notice.run[:6]):
        assert find(name) == run
    with pytest.raises(ProtocolError, match=r"^tower: no run has this name; these go on:(\n    \w+  .*)+$"):
        find("tower")


def test_the_command_watch_prints_events_as_lines_with_stage_and_units_or_as_json(frozen_run) -> None:  # type: ignore[no-untyped-def]
    run, _ = frozen_run
    wanted = ["watch", run.notice.recording, "--topics", "crane.input"]
    with going(Path(), *wanted) as text, going(Path(), *wanted, "--json") as data:
        assert text.stdout is not None
        assert data.stdout is not None
        lines = [text.stdout.readline() for _ in range(5)]
        first = json.loads(data.stdout.readline())
    assert [line.split()[:5] for line in lines] == [["0.000000", "s", "take", "up", "slack"]] * 5
    assert lines[0].split("crane.input")[1].strip() == "Watch: threshold crane.H3.highest, value 80, rising True"
    assert list(first) == ["number", "t_ns", "microstep", "stage", "source", "port", "index", "type", "value"]
    assert (first["source"], first["port"], first["stage"]) == ("crane", "input", "take up slack")


@pytest.mark.large
def test_observers_of_a_run_receive_a_report_if_the_run_is_killed(frozen_run) -> None:  # type: ignore[no-untyped-def]
    run, process = frozen_run
    observer = observe(run)
    with going(Path(), "watch", run.notice.run) as watching:
        assert watching.stdout is not None
        watching.stdout.readline()
        process.kill()
        _, error = watching.communicate(timeout=PATIENCE_s)
    seen = [event for _, event in observer]
    assert len(seen) >= 40
    assert observer.ended == RunEnded("failed", seen[-1].t * 1e-9, "its coordinator was killed")
    assert watching.returncode == 1
    assert error == f"heavylift: the run has failed at {seen[-1].t * 1e-9:.6f} s: its coordinator was killed\n"


def test_the_command_watch_refuses_a_run_that_has_ended(tmp_path: Path) -> None:
    (tmp_path / "old.mcap").touch()
    code, _, error = said(tmp_path, "watch", "old.mcap")
    assert code == 1
    assert error == ("heavylift: old.mcap: its run has ended; `heavylift info old.mcap` lists its contents\n")
