"""Injects faults into runs, as one table: python tests/full/faults.py [--short] [--json] [--seed N] [-j N]

Every process of a run in every way at every moment, disks, recordings, frames and sockets, processes of other hosts and
the line to them, environments: of runs of a lift, in processes and in one, of a DEVS network with each model in a
process and with two in one, some of `turnover`.  Each row says what is promised, how often it was tried and really hit,
and how often it ended so; every case that ends otherwise is printed on standard error, with what repeats it, and the
exit code is 1.  Where processes were replaced, the longest times are printed from the blow until it is noticed
(detection), from then until a successor has joined (recovery), and until that has heard all that its predecessor was
told (replay); with `-j 1` no other case disturbs them.
"""

from __future__ import annotations

import argparse
import json
import random
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from injections import bus, disk, environment, files, hosts, observers, processes, table
from injections.inside.striking import SIGNALS
from injections.trial import Case, Kind, Trial
from injections.workloads import possible

AREAS: dict[str, tuple[Sequence[Kind], int]] = {  # all kinds, and how many cases the short form takes
    "processes": (processes.KINDS, 14),
    "observers": (observers.KINDS, 2),
    "disk": (disk.KINDS, 5),
    "recordings": (files.KINDS, 3),
    "bus": (bus.KINDS, 4),
    "hosts": (hosts.KINDS, 2),
    "environment": (environment.KINDS, 8),
}
TURNOVERS = 12  # cases of the longest run


def cases(seed: int, short: bool) -> list[Case]:
    """Each kind at each moment in each run, or a few of each area."""
    rng, found = random.Random(seed), list[Case]()
    for kinds, few in AREAS.values():
        area = [
            Case(kind, moment, workload, seed)
            for kind in kinds
            for moment in kind.moments
            for workload in kind.workloads
            if workload != "turnover" and possible(moment, workload)
        ]
        found += rng.sample(area, few) if short else area
    if not short:
        moments = [(kind, moment) for kind in processes.KINDS for moment in kind.moments]
        long = [Case(kind, moment, "turnover", seed) for kind, moment in moments if possible(moment, "turnover")]
        found += rng.sample(long, TURNOVERS)
    return found


def carried_out(case: Case) -> Trial:
    """One case, tried."""
    return Trial(case).carry_out()


def strangers(short: bool) -> list[dict[str, Any]]:
    """Rows of what strangers try, in the same table."""
    script = Path(__file__).with_name("strangers.py")
    command = [sys.executable, str(script), "--json", *(["--short"] if short else [])]
    rows = [json.loads(line) for line in subprocess.run(command, stdout=subprocess.PIPE).stdout.splitlines()]
    assert rows, f"{script} has printed no row"
    return rows


def main() -> int:
    """Run all cases; print the table; the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--short", action="store_true", help="a few cases of each area")
    parser.add_argument("--json", action="store_true", help="rows as JSON objects, one a line")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("-j", type=int, default=2, help="cases at once")
    parser.add_argument("--only", default="", help="cases whose name holds this: 'kernel: KILL, run, lift'")
    given = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for name in SIGNALS[1:]:  # whoever has started this may have them ignored, and so would all cases
        signal.signal(signal.Signals[name], signal.SIG_DFL)
    chosen = [case for case in cases(given.seed, given.short) if given.only in str(case)]
    began, trials = time.monotonic(), list[Trial]()
    order = random.Random(given.seed).sample(chosen, len(chosen))  # slow kinds are spread
    with ThreadPoolExecutor(given.j) as pool:
        try:
            for carried in as_completed([pool.submit(carried_out, case) for case in order]):
                trials.append(trial := carried.result())
                if trial.failure:
                    message = f"NOT AS PROMISED: --seed {given.seed} --only '{trial.case}': {trial.failure}"
                    print(message, file=sys.stderr, flush=True)
        except KeyboardInterrupt:  # the table of what was tried so far
            pool.shutdown(cancel_futures=True)
    place = {case: i for i, case in enumerate(chosen)}
    rows = table.rows(sorted(trials, key=lambda trial: place[trial.case]))
    missed = [row["kind"] for row in rows if not row["hit"]]
    rows += [] if given.only else strangers(given.short)
    table.show(rows, given.json)
    failed, tried, hit = (sum(row.get(name, row["tried"]) for row in rows) for name in ("not", "tried", "hit"))
    print(table.timing(trials), file=sys.stderr)
    print(f"{tried - failed} of {tried} as promised, {hit} were hit; {time.monotonic() - began:.0f} s", file=sys.stderr)
    if missed and not given.short:
        print(f"never hit: {', '.join(missed)}", file=sys.stderr)
    return int(failed > 0 or (bool(missed) and not given.short and not given.only))


if __name__ == "__main__":
    sys.exit(main())
