"""Signals stop a command as Ctrl-C does, even where Python loses what they raise; readers may leave."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from command import HEAVYLIFT, PATIENCE_s, descendants, gone, start, until
from heavylift.recordings import Recording

CODES = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 129, signal.SIGQUIT: 131}


@pytest.mark.parametrize("where", [[], ["--in-process"]], ids=["processes", "one process"])
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT], ids=lambda n: n.name)
@pytest.mark.large(beyond=2)
def test_an_interrupted_run_ends_all_processes_and_completes_its_recording(number, where, tmp_path, monkeypatch):
    (tmp_path / "tmp").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "tmp"))
    run = start(tmp_path, "run", "lift", "--rate", "4", *where)
    until(run, "take up slack")
    processes = descendants(run.pid)
    run.send_signal(number)
    _, error = run.communicate(timeout=PATIENCE_s)
    assert run.returncode == CODES[number], error
    assert error.splitlines()[-1].startswith(f"heavylift: stopped by {number.name} at ")
    assert gone(processes)
    assert Recording(tmp_path / "lift.mcap").result["status"] == "failed"
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["lift.mcap", "tmp"]


IGNORANT = """
import os, signal
from heavylift.coordinator.stopping import Stopping
signal.signal(signal.SIGHUP, signal.SIG_IGN)
Stopping()
signal.raise_signal(signal.SIGHUP)
"""


def test_a_command_keeps_ignoring_an_operating_system_signal_that_was_ignored_at_its_start():
    assert subprocess.run([sys.executable, "-c", IGNORANT], capture_output=True, timeout=PATIENCE_s).returncode == 0


ENDED = """
import atexit, signal, threading, time
from heavylift.coordinator.stopping import Stopping

def signalled(): signal.raise_signal(signal.{name})

threading.Timer(0.05, signal.pthread_kill, [threading.main_thread().ident, signal.{name}]).start()
atexit.register(signalled)
Stopping().end(process=True)
"""


@pytest.mark.parametrize("name", [number.name for number in CODES])
def test_an_operating_system_signal_after_the_end_of_a_command_changes_nothing(name):
    """Neither while Python waits for threads nor while it tears itself down."""
    ended = subprocess.run([sys.executable, "-c", ENDED.format(name=name)], capture_output=True, timeout=PATIENCE_s)
    assert (ended.returncode, ended.stderr) == (0, b"")


LOSING = """
import ctypes, gc, os, signal, time, weakref
from heavylift.coordinator.stopping import Stopping

Stopping()

def signalled(*_):
    signal.raise_signal(signal.SIGTERM)
    return 0

class Dying:
    def __del__(self): signalled()

def finalizer(): Dying()

def weak_reference():
    class Thing: pass
    thing = Thing()
    reference = weakref.ref(thing, signalled)
    del thing

def collector():
    gc.callbacks.append(signalled)
    gc.collect()
    gc.callbacks.clear()

def foreign_code(): ctypes.CFUNCTYPE(ctypes.c_int)(signalled)()

def bare_except():
    try: signalled()
    except BaseException: pass

try:
    HOW()
    print("lost")
    time.sleep(60)
    print("went on")
except KeyboardInterrupt as error:
    print(error)
"""


@pytest.mark.parametrize("how", ["finalizer", "weak_reference", "collector", "foreign_code", "bare_except"])
def test_an_operating_system_signal_whose_exception_python_discards_is_raised_again(how):
    done = subprocess.run(
        [sys.executable, "-c", LOSING.replace("HOW", how)], capture_output=True, text=True, timeout=PATIENCE_s
    )
    assert (done.stdout, done.stderr) == ("lost\nSIGTERM\n", "")


HELD = """
import os, signal, subprocess, time
from heavylift.coordinator.stopping import Stopping
from heavylift.coordinator.supervision.processes import Processes

class Signalled(subprocess.Popen):
    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        signal.raise_signal(signal.SIGTERM)
        print("the keeper runs as", self.pid)

subprocess.Popen = Signalled
Stopping()
try:
    with Processes():
        time.sleep(60)
except KeyboardInterrupt as error:
    print(error)
"""


def test_an_interrupt_during_the_start_of_a_process_is_handled_after_the_start():
    done = subprocess.run([sys.executable, "-c", HELD], capture_output=True, text=True, timeout=PATIENCE_s)
    started, stopped = done.stdout.splitlines()
    assert stopped == "SIGTERM"
    assert gone([int(started.removeprefix("the keeper runs as "))])


AGAIN = """
import atexit, signal
from heavylift.coordinator import cli
from heavylift.coordinator.commands.common import app

atexit.register(signal.raise_signal, signal.NUMBER)
app.carry_out = lambda: signal.raise_signal(signal.SIGINT)
cli.main()
"""


@pytest.mark.parametrize("number", CODES, ids=lambda n: n.name)
def test_repeated_interrupts_while_a_process_ends_have_no_effect(number):
    code = AGAIN.replace("NUMBER", number.name)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE_s)
    assert (done.returncode, done.stderr) == (130, "heavylift: stopped\n")


PUT = """
import os, signal
from heavylift.coordinator.stopping import Stopping
from heavylift.coordinator.transport.link import LocalLink
from heavylift.coordinator.transport.exchange import LocalHub

def signalled(cls, name):
    received = getattr(cls, name)

    def in_the_middle(self, sample):
        signal.raise_signal(signal.SIGTERM)
        received(self, sample)

    setattr(cls, name, in_the_middle)

signalled(LocalHub, "_arrived")
signalled(LocalLink, "_enqueue")
with LocalHub(["west"]) as hub:
    link = hub.link("west")
    for put in lambda: link.sample(b"a batch"), lambda: hub.send("west", b"a message"):
        stopping = Stopping()
        try:
            put()
        except KeyboardInterrupt as error:
            print(error)
        stopping.end()
    print(hub.samples(), link.receive())
"""


def test_an_interrupt_during_a_queue_operation_loses_no_message():
    done = subprocess.run([sys.executable, "-c", PUT], capture_output=True, text=True, timeout=PATIENCE_s)
    assert (done.stdout, done.stderr) == ("SIGTERM\nSIGTERM\n[('west', b'a batch')] b'a message'\n", "")


def patched(patch: str, folder: Path, *options: str) -> subprocess.CompletedProcess[str]:
    """A run of `lift` in whose processes a patch was imported first."""
    (folder / "patch").mkdir()
    (folder / "patch" / "sitecustomize.py").write_text(patch)
    return subprocess.run(
        [HEAVYLIFT, "run", "lift", *options],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(folder / "patch")},
        capture_output=True,
        text=True,
        timeout=PATIENCE_s,
    )


FAILING = """\
from heavylift.coordinator.run import scene

def greet(self):
    self.talk.welcome(next(iter(self._models)), b"", "")
    raise MemoryError

scene._Run.greet = greet
"""


@pytest.mark.parametrize("where", [[], ["--in-process"]], ids=["processes", "one process"])
def test_a_run_that_fails_during_start_up_ends_with_a_clear_message(where, tmp_path):
    done = patched(FAILING, tmp_path, *where)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].startswith("heavylift: the system gives no more memory")
    assert Recording(tmp_path / "lift.mcap").result["status"] == "failed"


SWALLOWING = """\
import os, signal
from heavylift.coordinator.run.conversation import Conversation

class Dying:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)

def play(self, before=Conversation.play):
    Dying()
    return before(self)

Conversation.play = play
"""


@pytest.mark.parametrize("where", [[], ["--in-process"]], ids=["processes", "one process"])
def test_a_ctrl_c_that_arrives_in_a_destructor_stops_the_run(where, tmp_path):
    done = patched(SWALLOWING, tmp_path, "--rate", "1", *where)
    assert done.returncode == 130
    assert done.stderr.splitlines()[-1].startswith("heavylift: stopped by the user at ")
    assert Recording(tmp_path / "lift.mcap").result["status"] == "failed"


def test_a_run_whose_output_pipe_is_closed_is_recorded_to_its_end(tmp_path):
    run = start(tmp_path, "run", "pendulum", "--in-process")
    run.stdout.close()
    run.stderr.close()
    assert run.wait(PATIENCE_s) == 141
    assert Recording(tmp_path / "pendulum.mcap").result["status"] == "finished"
