"""All that can happen to one process of a run, in all phases: python tests/full/kills.py [--short] [--seed N] [-j N]

Each model, the kernel, the keeper and the coordinator x KILL, STOP, SEGV, exception, exit(0), out of memory x start,
run, exit, recovery; of `lift`, a DEVS network, the same with two models in a process (`grouped`), some of `turnover`;
the moment within a phase is drawn from the seed.
A case is well if it ends with the digest of the undisturbed run, after `resume` where the coordinator is gone (one that
is stopped is killed here), or, where a model raises an exception of its own, with that sentence; and if no process and
no private directory is left.  Prints every case that is not well, with what repeats it, and a table with the longest
times from the blow until it is noticed (detection), from then until a successor has joined (recovery), and until that
has heard all that its predecessor was told (replay); exit code 1 if not all are well.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from heavylift.nodes.models import KERNEL, node_names
from heavylift.nodes.scene import load
from heavylift.recordings import Recording
from injected import MEASURED

HERE = Path(__file__).parent
HEAVYLIFT = str(Path(sys.executable).with_name("heavylift"))
NETWORK = f"{HERE.parent / 'coordinator/supervision' / 'doomed_models.py'}:build"
RINGS = {"network": ("north", "east", "south"), "grouped": ("yard", "south")}
PLACES = {"grouped": ["--place", "north,east=yard"]}
ACTS = ("KILL", "STOP", "SEGV", "exception", "exit(0)", "memory")
PHASES = ("start", "run", "exit", "recovery")
GRANTS = {"lift": 60, "network": 118, "grouped": 78, "turnover": 250}  # of an undisturbed run, about
FEW = 12  # cases of turnover
SHORT, LIFTS = 30, 0.3  # cases of the short form, and the share of lifts among those that any model could be
DEADLINE_s = 2.0
HANGS_s = 300.0  # a run that takes longer, even where others load the machine
SOON_s = 20.0  # in which what a run leaves behind goes
RECOVERY_s = 1.0  # from the moment that a loss is known until a successor is there: target
COMPILED = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}  # as who has installed heavylift


@dataclass(frozen=True)
class Case:
    """One process of one run is struck."""

    scene: str
    who: str
    act: str
    phase: str
    seed: str

    def plan(self, folder: Path) -> dict[str, object]:
        """What injected.py is told."""
        rng = random.Random(f"{self.seed} {self}")
        nodes = processes_of(self.scene)
        each = max(2, GRANTS[self.scene] // len(nodes) // 2)
        point = rng.randrange(1, GRANTS[self.scene] if self.who in ("keeper", "coordinator") else each)
        plan = {"who": self.who, "act": self.act, "phase": self.phase, "folder": str(folder)}
        plan |= {
            "delay": rng.choice([0.0, 0.002, 0.02]),
            "late": rng.random() < 0.5,
            "start_delay": rng.uniform(0, 1.5),
        }
        if self.phase == "start":
            point = rng.randrange(len(nodes)) if self.who == "keeper" else rng.randrange(2)
        if self.phase == "recovery" or (self.who == "keeper" and self.phase == "run"):
            plan |= {"loses": rng.choice(nodes), "lose_at": rng.randrange(1, each)}
        if self.phase == "recovery" and self.who in nodes:
            point = rng.randrange(1, each)
            plan |= {"loses": self.who, "lose_at": rng.randrange(point, point + 3)}
        return plan | {"point": point}


def processes_of(scene: str) -> tuple[str, ...]:
    """The processes of a run, of a scene called like their only nodes."""
    return RINGS[scene] if scene in RINGS else tuple(node_names(load(scene).plan))


def cases(seed: int, short: bool) -> list[Case]:
    """All of them, or a few of each kind."""
    rng = random.Random(seed)
    found = []
    for scene in ("lift", *RINGS, "turnover"):
        of_scene = [
            Case(scene, who, act, phase, str(seed))
            for who in (*processes_of(scene), "keeper", "coordinator")
            for act in ACTS
            for phase in PHASES
        ]
        found += rng.sample(of_scene, FEW) if scene == "turnover" else of_scene
    if short:
        kinds = defaultdict(list)
        for case in found:
            if case.scene in (("lift",) if case.who == KERNEL or rng.random() < LIFTS else RINGS):
                kinds[kind(case.who), case.act].append(case)
        found = [rng.choice(of_kind) for of_kind in kinds.values()]
        found += rng.sample([case for case in cases(seed, False) if case.scene in RINGS], SHORT - len(found))
    rng.shuffle(found)
    return found


def kind(who: str) -> str:
    """Model, or what else it is."""
    return who if who in (KERNEL, "keeper", "coordinator") else "model"


class Trial:
    """One case in a folder of its own; `failure` says what is not well, "" if all is."""

    def __init__(self, case: Case, digests: dict[str, str]) -> None:
        self.case, self.digest = case, digests[case.scene]
        self.folder = Path(tempfile.mkdtemp(prefix="kill-", dir="/tmp"))
        self.output = self.folder / "run.mcap"
        self.environment = {
            **COMPILED,
            "TMPDIR": str(self.folder),
            "HEAVYLIFT_CASE": str(self.folder),
            "PYTHONPATH": f"{HERE}:{HERE.parent / 'coordinator/supervision'}",
        }
        self.times: list[tuple[float, ...]] = []  # detection, recovery, replay of each successor [s]
        self.struck = False
        began = time.monotonic()
        try:
            self.failure = self._failure()
        except subprocess.TimeoutExpired:
            self.failure = f"no end within {HANGS_s:g} s"
        except Exception as error:
            self.failure = f"{type(error).__name__}: {error}"
        self.took = time.monotonic() - began
        for pid in self._left():
            os.kill(pid, 9)
        shutil.rmtree(self.folder, ignore_errors=True)

    def _failure(self) -> str:
        code, said = self._run()
        self.struck = (self.folder / "struck").exists() or (self.folder / "own").exists()
        found = re.findall(MEASURED + r" ([\d.]+) ([\d.]+) ([\d.]+) ", said)
        self.times = [tuple(map(float, times)) for times in found]
        until = time.monotonic() + SOON_s
        while (left := [*self._left(), *self.folder.glob("heavylift-????????")]) and time.monotonic() < until:
            time.sleep(0.05)
        if left:
            return f"left behind: {left}"
        if self.case.who != "coordinator" or not self.struck:
            own = self.case.act == "exception" and self.case.phase == "run" and (self.folder / "own").exists()
            if own:
                told = said.strip().splitlines()[-1]
                return (
                    "" if code == 1 and re.search(r"^heavylift: .*ValueError: injected$", told) else f"{code}: {said}"
                )
            return self._compared(self.output) if code == 0 else f"exit code {code}: {said[-600:]}"
        part = self.output.with_name("run.mcap.part")
        rest = part if part.exists() else self.output
        if not rest.exists():  # nothing was recorded yet, and nothing is left
            return "" if os.listdir(self.folder) in ([], ["struck"]) else f"left behind: {os.listdir(self.folder)}"
        if rest != part and Recording(rest).result["status"] == "finished":
            return self._compared(rest)
        if self.case.scene in RINGS:  # it has no scene; who runs the model again has the same run
            return ""
        again = subprocess.run(
            [HEAVYLIFT, "resume", str(rest), "-o", str(self.folder / "new.mcap")],
            env=self.environment, capture_output=True, text=True, timeout=HANGS_s,
        )  # fmt: skip
        return self._compared(self.folder / "new.mcap") if again.returncode == 0 else f"resume: {again.stderr[-600:]}"

    def _run(self) -> tuple[int, str]:
        """Exit code and standard error; a coordinator that is stopped is killed."""
        case = self.case
        how = ["devs", NETWORK, *PLACES.get(case.scene, [])] if case.scene in RINGS else ["run", case.scene]
        with (self.folder / "said").open("w") as log:
            process = subprocess.Popen(
                [sys.executable, str(HERE / "injected.py"), *how, "--deadline", f"{DEADLINE_s:g} s", "-o", self.output],
                env={**self.environment, "HEAVYLIFT_INJECT": json.dumps(case.plan(self.folder))},
                cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=log,
            )  # fmt: skip
        until = time.monotonic() + HANGS_s
        while process.poll() is None:
            if _state(process.pid) == "T":
                time.sleep(0.3)
                process.kill()
            if time.monotonic() > until:
                process.kill()
                process.wait()
                raise subprocess.TimeoutExpired(how, HANGS_s)
            time.sleep(0.02)
        said = (self.folder / "said").read_text()
        (self.folder / "said").unlink()
        return process.returncode, said

    def _compared(self, path: Path) -> str:
        digest = Recording(path).result["digest"]
        return "" if digest == self.digest else f"another digest, {digest}"

    def _left(self) -> list[int]:
        """Processes of this case that are still there."""
        return [pid for pid, environment in _processes() if f"HEAVYLIFT_CASE={self.folder}".encode() in environment]


def _processes() -> Iterator[tuple[int, bytes]]:
    for entry in os.listdir("/proc"):
        if entry.isdigit() and int(entry) != os.getpid() and _state(int(entry)) not in ("", "Z"):
            try:
                yield int(entry), Path(f"/proc/{entry}/environ").read_bytes()
            except OSError:
                continue


def _state(pid: int) -> str:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return ""


def undisturbed(scene: str) -> str:
    """The digest of a scene that nobody disturbs."""
    trial = Trial(Case(scene, "nobody", "nothing", "run", ""), {scene: "?"})
    said, _, digest = trial.failure.rpartition(", ")
    assert said == "another digest", trial.failure
    return digest


def main() -> int:
    """Run all cases; print the table; the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--short", action="store_true", help=f"{SHORT} cases")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("-j", type=int, default=2, help="cases at once")
    parser.add_argument("--only", default="", help="cases whose 'scene who act phase' holds this")
    given = parser.parse_args()
    chosen = [c for c in cases(given.seed, given.short) if given.only in f"{c.scene} {c.who} {c.act} {c.phase}"]
    began = time.monotonic()
    digests = {scene: undisturbed(scene) for scene in {case.scene for case in chosen}}
    with ThreadPoolExecutor(given.j) as pool:
        trials = []
        for trial in pool.map(lambda case: Trial(case, digests), chosen):
            trials.append(trial)
            if trial.failure:
                c = trial.case
                print(
                    f"NOT WELL: --seed {c.seed} --only '{c.scene} {c.who} {c.act} {c.phase}': {trial.failure}",
                    flush=True,
                )
    rows: dict[tuple[str, str], list[Trial]] = defaultdict(list)
    for trial in trials:
        rows[kind(trial.case.who), trial.case.act].append(trial)
    print(f"{'process':<12} {'what':<10} cases  hit  well   detection recovery   replay     case, s at most")
    for (who, act), found in sorted(rows.items()):
        worst = "".join(f"{max(each):9.2f}" for each in zip(*(t for trial in found for t in trial.times), strict=True))
        hit, well = sum(t.struck for t in found), sum(not t.failure for t in found)
        took = max(t.took for t in found)
        print(f"{who:<12} {act:<10} {len(found):>5} {hit:>4} {well:>5}   {worst or '-':<27} {took:8.1f}")
    recoveries = sorted(times[1] for trial in trials for times in trial.times)
    slow = sum(t > RECOVERY_s for t in recoveries)
    print(f"{len(recoveries)} successors, {slow} of them later than {RECOVERY_s:g} s beyond detection and replay")
    well, hit = sum(not t.failure for t in trials), sum(t.struck for t in trials)
    print(f"{well} of {len(trials)} well, {hit} were hit; {time.monotonic() - began:.0f} s")
    return int(well < len(trials))


if __name__ == "__main__":
    sys.exit(main())
