"""Every process of a run is killed or stopped at every phase, at a random moment within the phase.

Model, kernel and keeper are replaced, and the run has its digest; a coordinator that is gone leaves a recording that
can be resumed, and one that is asked to stop says so as well.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import time
from pathlib import Path

from heavylift.nodes.models import KERNEL

from . import leftovers
from .inside.coordinator import MEASURED
from .inside.striking import FATAL, NUMBERS, SIGNALS, TWICE
from .trial import RESUMED, SAME, Ended, HANGS_s, Kind, NotAsPromised, Trial, clean
from .workloads import COMMANDS, GRANTS, RINGS, processes_of

COMMAND = str(Path(__file__).parent / "inside" / "command.py")
DEADLINE_s = 2.0
ACTS = (*FATAL, "STOP, CONT", "exception", "exit(0)", "memory", *SIGNALS)
MOMENTS = ("start", "import", "compile", "run", "exit", "recovery")
IMPORTS = {"coordinator": 900, "keeper": 400, KERNEL: 60, "model": 20}  # modules that are looked for, about
OWN = r"(Value|Runtime)Error: injected( \(\w+\.py:\d+\))?$"  # of a model that raises an exception


def plan(trial: Trial, who: str) -> dict[str, object]:
    """What striking.py is reported."""
    case, rng = trial.case, trial.random
    role, act, moment, grants = _role(who), _act(case.kind), case.moment, GRANTS.get(case.workload, 60)
    nodes = processes_of("lift" if case.workload == "alone" else case.workload)
    each = max(2, grants // len(nodes) // 2)
    point = rng.randrange(1, grants if role in ("keeper", "coordinator") else each)
    found = {"who": who, "act": act, "phase": moment, "folder": str(trial.folder)}
    found |= {"delay": rng.choice([0.0, 0.002, 0.02]), "late": rng.random() < 0.5}
    found |= {"start_delay": rng.uniform(0, 1.5), "stopped": rng.choice([0.03, 0.3, 3.0])}
    if act == TWICE:
        found["stopped"] = rng.choice([0.001, 0.01, 0.1])
    if moment == "start":
        point = rng.randrange(len(nodes)) if role == "keeper" else rng.randrange(2)
    if moment == "import":
        point = rng.randrange(1, IMPORTS[role])
    if moment == "recovery" or (role == "keeper" and moment == "run"):
        found |= {"loses": rng.choice(nodes), "lose_at": rng.randrange(1, each)}
    if moment == "recovery" and who in nodes:
        point = rng.randrange(1, each)
        found |= {"loses": who, "lose_at": rng.randrange(point, point + 3)}
    return found | {"point": point}


def strike(trial: Trial) -> None:
    """A run in one of whose processes it happens."""
    case, role, act = trial.case, trial.case.kind.name.partition(":")[0], _act(trial.case.kind)
    models = [name for name in processes_of("lift" if case.workload == "alone" else case.workload) if name != KERNEL]
    who = trial.random.choice(models) if role == "model" else role
    ended = run(trial, plan(trial, who))
    found = re.findall(MEASURED + r" ([\d.]+) ([\d.]+) ([\d.]+) ", ended.said)
    trial.times = [tuple(map(float, times)) for times in found]
    trial.struck = any((trial.folder / name).exists() for name in ("struck", "own"))
    if role != "coordinator" or not trial.struck or act == "STOP, CONT":
        if act == "exception" and role != "keeper" and ended.code:
            return trial.sentence(ended, OWN)
        if ended.code:
            raise NotAsPromised(f"exit code {ended.code}: {ended.said[-600:]}")
        return trial.compare(trial.output) if act == "exception" else trial.same(ended)
    if left := leftovers.left(trial.folder, trial.temporary):  # before anything else is run
        raise NotAsPromised(f"left behind: {', '.join(left)}")
    if act in (*SIGNALS, TWICE):
        clean(ended)
        number = NUMBERS["SIGINT" if act == TWICE else act]
        if ended.code not in (0, 128 + number, *([-number] if case.moment == "import" else [])):
            raise NotAsPromised(f"exit code {ended.code}: {ended.said[-600:]}")
        if ended.code > 0 and not ended.said.strip().splitlines()[-1].startswith("heavylift: stopped"):
            raise NotAsPromised(f"it does not say that it was stopped: {ended.said[-600:]}")
    trial.resumed()


def run(trial: Trial, planned: dict[str, object]) -> Ended:
    """The run, with an empty cache if machine code is to be made; a coordinator that is stopped is killed."""
    environment = {**trial.environment, "HEAVYLIFT_INJECT": json.dumps(planned)}
    environment["PYTHONPATH"] += f":{Path(__file__).parents[1]}"
    if planned["phase"] == "compile":
        environment["HEAVYLIFT_CACHE"] = str(trial.folder / "cache")
    command = [sys.executable, COMMAND, *COMMANDS[trial.case.workload], "-o", trial.output]
    if trial.case.workload != "alone":
        command += ["--deadline", f"{DEADLINE_s:g} s"]
    process = trial.start(command, env=environment)
    until = time.monotonic() + HANGS_s
    while process.poll() is None:
        if leftovers.state(process.pid) == "T" and planned["act"] == "STOP":
            time.sleep(0.3)
            process.kill()
        if time.monotonic() > until:
            process.kill()
            process.wait()
            raise subprocess.TimeoutExpired(command, HANGS_s)
        time.sleep(0.02)
    return trial.end(process)


def _role(who: str) -> str:
    return who if who in (KERNEL, "keeper", "coordinator") else "model"


def _act(kind: Kind) -> str:
    return kind.name.partition(": ")[2]


def _kinds() -> list[Kind]:
    found = []
    scenes = {"model": ("lift", *RINGS), KERNEL: ("lift", "turnover"), "keeper": ("lift", *RINGS)}
    for role, workloads in scenes.items():
        moments = [moment for moment in MOMENTS if (role, moment) != ("model", "compile")]  # it has no machine code
        for act in ACTS:
            message = SAME if act != "exception" or role == "keeper" else f"a sentence with it, or {SAME}"
            found.append(Kind(f"{role}: {act}", message, strike, tuple(moments), workloads))
    for act in (*ACTS, TWICE):
        message = f"stopped in one sentence, {RESUMED}" if act in (*SIGNALS, TWICE) else RESUMED
        message = SAME if act == "STOP, CONT" else message
        found.append(Kind(f"coordinator: {act}", message, strike, MOMENTS, ("lift", "alone", *RINGS)))
    return found


KINDS = _kinds()
