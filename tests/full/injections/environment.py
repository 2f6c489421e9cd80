"""Faults of the environment of a run: variables, folders, limits, names and clocks."""

from __future__ import annotations

import os
import resource
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .starting import limited, mounted, namespaces
from .trial import SAME, SENTENCE, Kind, Trial

NAMES = {
    "non-ASCII": "größe 揚重",
    "spaces and quotes": "a 'b' \"c\"  d",
    "percent and hash": "50% #1 {x} $HOME ?",
    "a line end": "a\nb",
    "an option": "--help",
    "no text": os.fsdecode(b"\xff\xfe"),
    "long": "x" * 200,
}
ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
KERNELS = ("Haswell", "Sandybridge", "Nehalem", "Prescott", "Zen", "SkylakeX", "NoSuch")
STREAMS = ("stdin", "stdout", "stderr")
RUNS = ("lift", "alone", "network")
EITHER = f"{SAME}, or {SENTENCE}"


def _same(**changed: str | None) -> Callable[[Trial], None]:
    """The same digest with other variables; None: without."""

    def run(trial: Trial) -> None:
        trial.environment |= {name: value.format(folder=trial.folder) for name, value in changed.items() if value}
        for name in (name for name, value in changed.items() if value is None):
            trial.environment.pop(name, None)
        trial.same(trial.run())

    return run


def _started(promised: Callable[..., None] = Trial.same, **how: Any) -> Callable[[Trial], None]:
    """Started otherwise: arguments of Popen."""
    return lambda trial: promised(trial, trial.run(**how))


def _before(do: Callable[[], object], promised: Callable[..., None] = Trial.same) -> Callable[[Trial], None]:
    return _started(promised, preexec_fn=do)


def bare(trial: Trial) -> None:
    kept = ("PATH", "TMPDIR", "HEAVYLIFT_CASE", "HEAVYLIFT_CACHE", "PYTHONPATH")
    trial.environment = {name: trial.environment[name] for name in kept if name in trial.environment}
    trial.same(trial.run())


def read_only_home(trial: Trial) -> None:
    home = trial.folder / "home"
    home.mkdir()
    trial.environment = {k: v for k, v in trial.environment.items() if k != "HEAVYLIFT_CACHE"} | {"HOME": str(home)}
    trial.same(trial.run(mounted(home, "ro", trial.command)))


def _closed(*numbers: int) -> Callable[[Trial], None]:
    def run(trial: Trial) -> None:
        words = " ".join(f"{number}{'<' if number == 0 else '>'}&-" for number in numbers)
        ended = trial.run(["sh", "-c", f'exec "$@" {words}', "sh", *trial.command])
        trial.same(ended)

    return run


def _named(name: str, variables: dict[str, str]) -> Callable[[Trial], None]:
    """In a folder of this name."""

    def run(trial: Trial) -> None:
        folder = trial.folder / name
        folder.mkdir()
        trial.output = folder / "run.mcap"
        trial.environment |= variables
        command = trial.command
        if trial.random.random() < 0.5:
            command[-1] = "run.mcap"
        promised = trial.same if name not in (NAMES["no text"], NAMES["a line end"]) else trial.same_or_sentence
        promised(trial.run(command, cwd=folder))

    return run


def no_folder(trial: Trial) -> None:
    """The working directory is removed before the command begins."""
    gone = trial.folder / "gone"
    gone.mkdir()
    script = 'rmdir "$1" && shift && exec "$@"'
    trial.same_or_sentence(trial.run(["sh", "-c", script, "sh", gone, *trial.command], cwd=gone))


def few_files(trial: Trial) -> None:
    files = trial.random.choice([10, 12, 16, 20, 24, 28, 32, 40, 48, 56, 64, 96, 128, 256])
    trial.same_or_sentence(trial.run(preexec_fn=limited(resource.RLIMIT_NOFILE, files)))


def little_stack(trial: Trial) -> None:
    stack = trial.random.choice([256, 512, 1024, 2048]) << 10
    trial.same_or_sentence(trial.run(preexec_fn=limited(resource.RLIMIT_STACK, stack)))


def few_processes(trial: Trial) -> None:
    """RLIMIT_NPROC does not bind root, so pids of a control group would be needed there."""
    most = trial.random.randint(5, 60)
    trial.same_or_sentence(trial.run(preexec_fn=limited(resource.RLIMIT_NPROC, most)))


def little_memory(trial: Trial) -> None:
    room = trial.random.randint(300, 1500) << 20
    trial.same_or_sentence(trial.run(preexec_fn=limited(resource.RLIMIT_AS, room)))


def little_time(trial: Trial) -> None:
    """SIGXCPU or SIGKILL: a process that is lost, or a command that is."""
    ended = trial.run(preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (1, 3)))
    trial.same(ended) if ended.code == 0 else trial.resumed()


CLOCK = """
import random, time
jumps = random.Random(SEED)
def jumping(clock):
    return lambda: clock() + jumps.choice([-4e8, -3600.0, 0.0, 0.0, 5.0, 4e8])
time.time = jumping(time.time)
time.time_ns = lambda clock=time.time_ns: clock() + int(jumps.choice([-4e17, 0, 0, 4e17]))
"""


def jumping_clock(trial: Trial) -> None:
    """The wall clock of all processes, not the monotonic one, by up to 13 years."""
    (trial.folder / "patch").mkdir()
    (trial.folder / "patch" / "sitecustomize.py").write_text(CLOCK.replace("SEED", str(trial.random.random())))
    trial.environment["PYTHONPATH"] += f":{trial.folder / 'patch'}"
    trial.same(trial.run())


def one_processor(trial: Trial) -> None:
    cpu = trial.random.choice(sorted(os.sched_getaffinity(0)))
    trial.same(trial.run(preexec_fn=lambda: os.sched_setaffinity(0, {cpu})))


def odd_hours(trial: Trial) -> None:
    """The monotonic clock began long ago."""
    offset = trial.random.choice([10**5, 10**8])
    trial.same(trial.run(["unshare", "--map-root-user", "--time", "--monotonic", offset, *trial.command]))


def blocked(trial: Trial) -> None:
    signals = {signal.SIGINT, signal.SIGTERM, signal.SIGCHLD, signal.SIGALRM, signal.SIGUSR1}
    few = trial.random.sample(sorted(signals), 2)
    trial.same(trial.run(preexec_fn=lambda: signal.pthread_sigmask(signal.SIG_BLOCK, few)))


def ignored(trial: Trial) -> None:
    number = trial.random.choice([signal.SIGCHLD, signal.SIGPIPE, signal.SIGHUP, signal.SIGINT, signal.SIGUSR1])
    trial.same(trial.run(preexec_fn=lambda: signal.signal(number, signal.SIG_IGN)))


def optimised(trial: Trial) -> None:
    script = Path(sys.executable).with_name("heavylift")
    trial.same(trial.run([sys.executable, "-OO", script, *trial.command[1:]]))


VARIABLES: dict[str, dict[str, str | None]] = {
    "no HOME": {"HOME": None, "HEAVYLIFT_CACHE": None},
    "HOME is not there": {"HOME": "{folder}/none/home", "HEAVYLIFT_CACHE": None},
    "HOME is no folder": {"HOME": "/dev/null", "HEAVYLIFT_CACHE": None},
    "TMPDIR is not there": {"TMPDIR": "{folder}/none"},
    "TMPDIR is a file": {"TMPDIR": "/etc/passwd"},
    "TMPDIR is empty": {"TMPDIR": ""},
    "LC_ALL=C": ASCII,
    "LC_ALL of nowhere": {"LC_ALL": "xx_YY.UTF-8"},
    "Turkish": {"LC_ALL": "tr_TR.UTF-8", "LANG": "tr_TR"},
    "ASCII output": {"PYTHONIOENCODING": "ascii"},
    "another hash seed": {"PYTHONHASHSEED": "4242"},
    "warnings are errors": {"PYTHONWARNINGS": "error"},
    "development mode": {"PYTHONDEVMODE": "1"},
    "debugging allocator": {"PYTHONMALLOC": "debug"},
    "Python's own allocator": {"PYTHONMALLOC": "malloc"},
    "no byte code": {"PYTHONDONTWRITEBYTECODE": "1"},
    "unbuffered": {"PYTHONUNBUFFERED": "1"},
    "faulthandler": {"PYTHONFAULTHANDLER": "1"},
    "one column": {"COLUMNS": "1", "LINES": "1", "TERM": "dumb"},
    "another time zone": {"TZ": "Asia/Kathmandu"},
    "four BLAS threads": {"OPENBLAS_NUM_THREADS": "4", "OMP_NUM_THREADS": "4"},
    "many arenas": {"MALLOC_ARENA_MAX": "64", "MALLOC_PERTURB_": "165"},
    "debugging of Zenoh": {"RUST_LOG": "zenoh=debug", "RUST_BACKTRACE": "full"},
    "settings of Zenoh": {"ZENOH_CONFIG": "/dev/null", "ZENOH_RUNTIME": "(rx: (worker_threads: 1))"},
} | {f"BLAS for {name}": {"OPENBLAS_CORETYPE": name, "OPENBLAS_VERBOSE": "0"} for name in KERNELS}
KINDS = [
    *(Kind(f"environment: {name}", SAME, _same(**changed), ("start",), RUNS) for name, changed in VARIABLES.items()),
    Kind("environment: next to none", SAME, bare, ("start",), RUNS),
    *(
        Kind(
            f"environment: closed {', '.join(STREAMS[number] for number in few)}", SAME, _closed(*few), ("start",), RUNS
        )
        for few in [(0,), (1,), (2,), (0, 1), (1, 2), (0, 1, 2)]
    ),
    *(
        Kind(f"environment: umask {mask:03o}", SAME, _started(umask=mask), ("start",), RUNS)
        for mask in (0o000, 0o077, 0o177, 0o777)
    ),
    *(
        Kind(f"environment: folder named with {what}{told}", SAME, _named(name, variables), ("start",), RUNS)
        for what, name in NAMES.items()
        for told, variables in (("", {}), (", LC_ALL=C", ASCII))
    ),
    Kind("environment: folder is gone", EITHER, no_folder, ("start",), RUNS),
    Kind("environment: another working directory", SAME, _started(cwd="/"), ("start",), RUNS),
    Kind("environment: few files", EITHER, few_files, ("start", "run", "exit"), RUNS),
    Kind("environment: little stack", EITHER, little_stack, ("start", "run"), RUNS),
    Kind("environment: few processes", EITHER, few_processes, ("start",), RUNS),
    Kind("environment: little memory", EITHER, little_memory, ("start", "run", "exit"), RUNS),
    Kind("environment: little time", f"{SAME}, or resumed to it", little_time, ("run",), RUNS),
    Kind("environment: no core dumps", SAME, _before(limited(resource.RLIMIT_CORE, 0)), ("start",), RUNS),
    Kind("environment: no locked memory", SAME, _before(limited(resource.RLIMIT_MEMLOCK, 0)), ("start",), RUNS),
    Kind("environment: no priority", SAME, _before(lambda: os.nice(19)), ("start",), RUNS),
    Kind("environment: one processor", SAME, one_processor, ("start",), RUNS),
    Kind("environment: the wall clock jumps", SAME, jumping_clock, ("run",), RUNS),
    Kind("environment: signals are blocked", SAME, blocked, ("start",), RUNS),
    Kind("environment: signals are ignored", SAME, ignored, ("start", "run"), RUNS),
    Kind("environment: python -OO", SAME, optimised, ("start",), RUNS),
]
MOUNTED = [
    Kind("environment: read-only HOME", SAME, read_only_home, ("start",), RUNS),
    Kind("environment: a monotonic clock of long ago", SAME, odd_hours, ("start",), RUNS),
]
KINDS += MOUNTED if namespaces() else []
