"""Spoils all that heavylift reads of others, and looks for tracebacks, hangs and memory without bounds.

    python tests/full/fuzz.py --minutes 20 --seed 1            every kind for 20 minutes of CPU
    python tests/full/fuzz.py --kind resume --minutes 1        one of them

Whatever a case ends in, a result or a sentence of heavylift is right; anything else is told, with the case in a file.
"""

from __future__ import annotations

import argparse
import collections
import contextlib
import io
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from random import Random
from types import FrameType

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "recordings")]

from fuzzed import KINDS  # noqa: E402
from heavylift.kernel.errors import HeavyliftError  # noqa: E402

PATIENCE_s = 60.0  # for a case; those that compile a scene take seconds
ROOM_kB = 400_000  # by which the largest memory may grow in one case


class Hang(BaseException):
    """A case takes too long."""


class Result:
    """Cases of a kind, and what was wrong, each once: traceback, hang or memory, with its first case."""

    def __init__(self) -> None:
        self.cases = self.sentences = 0
        self.found: collections.Counter[str] = collections.Counter()
        self.first: dict[str, bytes] = {}

    def wrong(self, what: str, case: bytes) -> None:
        self.found[what] += 1
        self.first.setdefault(what, case)


def fuzz(kind: str, seed: int, cpu_s: float, most: int = sys.maxsize) -> Result:
    """Play random cases of a kind for so much CPU time, at most so many."""
    rng, result, end = Random(f"{kind} {seed}"), Result(), time.process_time() + cpu_s
    with tempfile.TemporaryDirectory(prefix="heavylift-fuzz-") as folder:
        draw, play = KINDS[kind](Path(folder))
        while time.process_time() < end and result.cases < most:
            _one(draw(rng), play, result)
    return result


def _one(case: bytes, play: Callable[[bytes], None], result: Result) -> None:
    result.cases += 1
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    try:
        with _patience(), contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            play(case)
    except HeavyliftError:
        result.sentences += 1
    except Hang as hang:
        result.wrong(f"hang at {_place(hang)}", case)
    except (Exception, SystemExit) as error:
        result.wrong(f"{type(error).__name__} at {_place(error)}: {str(error)[:100]}", case)
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    if grown > ROOM_kB and result.cases > 1:
        result.wrong(f"memory grew by {grown // 1000} MB", case)


def _place(error: BaseException) -> str:
    """The last line of heavylift that it passed."""
    lines = [x for x in traceback.extract_tb(error.__traceback__) if "/tests/" not in x.filename]
    ours = [
        x for x in lines if any(f"/{room}/" in x.filename for room in ("kernel", "nodes", "coordinator", "recordings"))
    ]
    last = (ours or lines or traceback.extract_tb(error.__traceback__))[-1]
    return f"{'/'.join(Path(last.filename).parts[-3:])}:{last.lineno}"


@contextlib.contextmanager
def _patience() -> Iterator[None]:
    def ring(number: int, frame: FrameType | None) -> None:
        raise Hang

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, PATIENCE_s)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def main() -> int:
    """Exit code 1 if anything was found."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--kind", action="append", choices=sorted(KINDS), help="default all")
    parser.add_argument("--minutes", type=float, default=1.0, help="of CPU time, for each kind")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    wrong = 0
    for kind in asked.kind or sorted(KINDS):
        result = fuzz(kind, asked.seed, 60.0 * asked.minutes)
        print(f"{kind}: {result.cases} cases, {result.sentences} refused, {len(result.found)} wrong", flush=True)
        for number, (what, times) in enumerate(result.found.most_common()):
            path = Path(tempfile.gettempdir()) / f"fuzz-{kind}-{asked.seed}-{number}"
            path.write_bytes(result.first[what])
            print(f"  {times} x {what}; the first is {path}", flush=True)
        wrong += len(result.found)
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
