"""Corrupts all data that heavylift reads from others, and detects tracebacks, crashes, hangs and unbounded memory.

    python tests/full/fuzz.py --minutes 20 --seed 1            every kind for 20 minutes of CPU
    python tests/full/fuzz.py --kind resume --minutes 1        one of them

Whatever a case ends in, a result or a sentence of heavylift is right; anything else is reported, with the case in a
file. Cases are played in a process of their own, which is killed and replaced where native code hangs or crashes.
"""

from __future__ import annotations

import argparse
import collections
import contextlib
import io
import itertools
import multiprocessing
import resource
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from pathlib import Path
from random import Random

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent), str(HERE.parent / "recordings")]

from fuzzed import KINDS  # noqa: E402
from heavylift.kernel import HeavyliftError  # noqa: E402
from spoiled_recordings import TooSlow, patience  # noqa: E402

PATIENCE_s = 60.0  # for a case; those that compile a scene take seconds
HARD_s = 200.0  # for a case that does not hear of it, or for the corpus
ROOM_kB = 400_000  # by which the largest memory may grow in one case
SPACE_bytes = 8 << 30  # of addresses: beyond is nothing but a MemoryError
REFUSED = "refused"

Case = tuple[bytes, Callable[[bytes], None]]


class Result:
    """Cases of a kind, and what was wrong, each once: traceback, hang or memory, with its first case."""

    def __init__(self) -> None:
        self.cases = self.sentences = 0
        self.found: collections.Counter[str] = collections.Counter()
        self.first: dict[str, bytes] = {}

    def add(self, case: bytes, ending: str) -> None:
        """`ending`: "", REFUSED, or what was wrong."""
        self.cases += 1
        self.sentences += ending == REFUSED
        if ending not in ("", REFUSED):
            self.found[ending] += 1
            self.first.setdefault(ending, case)


def fuzz(kind: str, seed: int, most: int) -> Result:
    """Play so many random cases of a kind in this process."""
    result = Result()
    with tempfile.TemporaryDirectory(prefix="heavylift-fuzz-") as folder:
        for case, play in itertools.islice(_cases(kind, seed, Path(folder)), most):
            result.add(case, _ending(case, play))
    return result


def guarded(kind: str, seed: int, cpu_s: float) -> Result:
    """Play random cases of a kind for so much CPU time, in a process that may hang and crash."""
    result, spent, processes = Result(), 0.0, 0
    with tempfile.TemporaryDirectory(prefix="heavylift-fuzz-") as folder:
        while spent < cpu_s:
            here, there = multiprocessing.Pipe(duplex=False)
            start = f"{seed}, process {processes}"
            child = multiprocessing.Process(target=_play, args=(there, kind, start, Path(folder), cpu_s - spent))
            child.start()
            there.close()
            case, used, ending = b"", 1.0, "hang that no signal ends"
            try:
                while here.poll(HARD_s):
                    case, used, message = here.recv()
                    if message is not None:
                        result.add(case, message)
            except EOFError:
                child.join()
                ending = f"end of the process with {child.exitcode}"
            if child.exitcode == 0:
                break
            child.kill()
            child.join()
            result.add(case, ending)
            spent, processes = spent + used, processes + 1
    return result


def _play(to: Connection, kind: str, start: str, folder: Path, cpu_s: float) -> None:
    """In the process that may be lost: tell each case before and after."""
    resource.setrlimit(resource.RLIMIT_AS, (SPACE_bytes, SPACE_bytes))
    began = time.process_time()
    for case, play in _cases(kind, start, folder):
        to.send((case, time.process_time() - began, None))
        ending = _ending(case, play)
        to.send((case, time.process_time() - began, ending))
        if time.process_time() - began > cpu_s:
            break


def _cases(kind: str, start: object, folder: Path) -> Iterator[Case]:
    rng = Random(f"{kind} {start}")
    draw, play = KINDS[kind](folder)
    while True:
        yield draw(rng), play


def _ending(case: bytes, play: Callable[[bytes], None]) -> str:
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    ending = ""
    try:
        with patience(PATIENCE_s), contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            play(case)
    except HeavyliftError:
        ending = REFUSED
    except TooSlow as hang:
        ending = f"hang at {_place(hang)}"
    except (Exception, SystemExit) as error:
        ending = f"{type(error).__name__} at {_place(error)}: {str(error)[:100]}"
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    return f"memory grew by more than {ROOM_kB // 1000} MB" if grown > ROOM_kB and ending in ("", REFUSED) else ending


def _place(error: BaseException) -> str:
    """The last line of heavylift that it passed."""
    lines = [x for x in traceback.extract_tb(error.__traceback__) if "/tests/" not in x.filename]
    ours = [
        x for x in lines if any(f"/{room}/" in x.filename for room in ("kernel", "nodes", "coordinator", "recordings"))
    ]
    last = (ours or lines or traceback.extract_tb(error.__traceback__))[-1]
    return f"{'/'.join(Path(last.filename).parts[-3:])}:{last.lineno}"


def main() -> int:
    """Exit code 1 if anything was found."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--kind", action="append", choices=sorted(KINDS), help="default all")
    parser.add_argument("--minutes", type=float, default=1.0, help="of CPU time, for each kind")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    wrong = 0
    for kind in asked.kind or sorted(KINDS):
        result = guarded(kind, asked.seed, 60.0 * asked.minutes)
        print(f"{kind}: {result.cases} cases, {result.sentences} refused, {len(result.found)} wrong", flush=True)
        for number, (what, times) in enumerate(result.found.most_common()):
            path = Path(tempfile.gettempdir()) / f"fuzz-{kind}-{asked.seed}-{number}"
            path.write_bytes(result.first[what])
            print(f"  {times} x {what}; the first is {path}", flush=True)
        wrong += len(result.found)
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
