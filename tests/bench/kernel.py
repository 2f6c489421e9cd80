"""Times of the kernel beside MuJoCo and Pinocchio in one process on one core.

    python tests/bench/kernel.py [--json] [--short]

Every time is the least of several and free of calls from Python: functions of all three are called in loops of machine
code or by their own batch calls (`shared/native_loops.py`, `shared/peers.py`).  Whole runs are CPU time over the
tension error against a reference trajectory: at each error the fastest run that is at least as exact counts, whatever
its method, tolerance or step.  The cost of the formulations is measured in `formulations.py`, whole processes in
`wait.py`.
"""

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from heavylift.kernel.simulation import Simulation
from shared import native_loops, peers
from shared.recorded_commands import kernel_alone, pruned_alone
from shared.reference_scenes import HOOK_Y, copies, pinned, scene
from shared.rows import SHORT, options, row

REFERENCE = json.loads((Path(__file__).parents[1] / "data" / "goliath_reference.json").read_text())
SCALE = 5.5e5  # [N] static tension, to which errors refer
HOOKS = HOOK_Y[:1] if SHORT else HOOK_Y  # of each of the two cranes
DOFS, LOADERS = 12 + 4 * len(HOOKS), 2 * len(HOOKS)
SECONDS, REPEATS = (2, 1) if SHORT else (10, 3)
TOLERANCES = 10.0 ** -(np.arange(3.0, 8.1, 2.5) if SHORT else np.arange(2.0, 12.1, 0.25))
STEPS = (100, 1000) if SHORT else (10, 14, 20, 30, 40, 60, 80, 120, 200, 300, 500, 800, 1200, 2000, 3000)  # a second
ERRORS = 10.0 ** -(np.arange(2.0, 4.1) if SHORT else np.arange(2.0, 10.6, 0.5))
PROMISED, FIFTH = (1e-3, 1e-6, 1e-9), 0.2  # at these errors in a fifth of the peer's time; nowhere slower
COMPILED = {24: 0.7} if SHORT else {24: 0.7, 100: 1.5, 400: 5.0}  # degrees of freedom -> seconds of a cold start
CACHED_s = 0.12
LIFT = ("lift", "end=20 s") if SHORT else ("turnover",)
PRUNED = "dop853"  # without the hinges' fast modes steps grow, and a higher order pays
COPIES = (1,) if SHORT else (1, 2, 5, 10, 20, 40)


def forward_dynamics():
    s = Simulation(scene(HOOKS))
    s.start()
    strict, fused = (native_loops.evaluation(s, fused)[0] * 1e6 for fused in (False, True))
    mj = peers.MuJoCo(scene(HOOKS)).forward() * 1e6 if peers.mujoco else None
    aba = peers.pinocchio_aba(s.program.graph) * 1e6 if peers.pin else None
    name = f"forward dynamics, {DOFS} DOF, {LOADERS} ropes"
    row(f"{name}, strict", strict, "us", "MuJoCo mj_forward", mj, at_most=1 / 4.5)
    row(f"{name}, strict", strict, "us", "Pinocchio aba without ropes", aba, at_most=1 / 6)
    row(f"{name}, fused", fused, "us", "MuJoCo mj_forward", mj, at_most=1 / 5.5)


def tensions(at):
    """(ropes,) of the reference at a whole second."""
    return np.array(REFERENCE["tension"][REFERENCE["t"].index(float(at))])


def own_run(method, tolerance):
    """Largest error of the tensions at whole seconds, CPU milliseconds, and what was chosen."""
    least = np.inf
    for _ in range(REPEATS):
        s = Simulation(scene(), tolerance, 1_000_000_000, h_max=1.0, method=method)
        began = time.thread_time()
        s.start()
        s.run(SECONDS * 10**9 + 1)
        s.interrupt(SECONDS * 10**9 + 1)
        least = min(least, time.thread_time() - began)
    columns = s.method.row_layout.at["tension"]
    rows = {t // 10**9: r[columns] for t, r in s.rows if t % 10**9 == 0 and t}
    assert len(rows) == SECONDS, rows.keys()
    return (
        max(np.abs(T - tensions(t)).max() for t, T in rows.items()) / SCALE,
        least * 1e3,
        f"{method} at {tolerance:.1e}",
    )


def mujoco_run(steps):
    """The same with RK4 and so many steps a second."""
    least = np.inf
    for _ in range(REPEATS):
        peer = peers.MuJoCo(scene(), "RK4", 1.0 / steps)
        error = spent = 0.0
        for t in range(1, SECONDS + 1):
            began = time.thread_time()
            peers.mujoco.mj_step(peer.model, peer.data, steps)
            spent += time.thread_time() - began
            error = max(error, np.abs(peer.tensions() - tensions(t)).max() / SCALE)
        least = min(least, spent)
    return error, least * 1e3, f"{steps} steps a second"


def whole_runs():
    """Work over precision."""
    ours = [own_run(method, tolerance) for method in ("dopri5", "dop853") for tolerance in TOLERANCES]
    theirs = [mujoco_run(n) for n in STEPS] if peers.mujoco else []
    ratios = []
    for error in ERRORS:
        own, peer = (
            min(((ms, how) for e, ms, how in runs if e <= error), default=(None, "none so exact"))
            for runs in (ours, theirs)
        )
        if own[0] is None or (theirs and peer[0] is None):
            continue
        target = FIFTH if np.isclose(error, PROMISED, rtol=1e-6, atol=0.0).any() else 1.0
        name = f"{SECONDS} s at a tension error of {error:.0e}, {own[1]}"
        row(name, own[0], "ms", f"MuJoCo RK4 ({peer[1]})" if theirs else "MuJoCo RK4", peer[0], at_most=target)
        ratios += [own[0] / peer[0]] if theirs else []
    if ratios:
        row(f"work-precision curve: worst ratio at {len(ratios)} errors", max(ratios), at_most=1.0)
    tightest = min((e for e, *_ in theirs), default=None)
    row("the tightest error that either reaches, ours", min(e for e, *_ in ours), "", "MuJoCo RK4", tightest)


def loops():
    plain, pins = scene(HOOKS), pinned(scene(HOOKS))
    s = Simulation(pins)
    s.start()
    own, name = native_loops.evaluation(s)[0] * 1e6, f"redundant loop rows ({6 * LOADERS}, rank {5 * LOADERS})"
    row(name, own, "us", at_most=9.0)
    loose, welds = peers.cut_loose(plain)
    mj = peers.MuJoCo(loose, pins=welds).forward() * 1e6 if peers.mujoco else None
    row(name, own, "us", "MuJoCo mj_forward, as equality rows", mj)
    for what, seconds in peers.pinocchio_constrained(plain).items():
        row(name, own, "us", f"Pinocchio {what} without ropes", seconds and seconds * 1e6)
    as_tree = replace(plain, springs=pins.springs)
    ends = []
    for system in (pins, as_tree):
        s = Simulation(system, 1e-10)
        s.start()
        s.run(10**9)
        s.interrupt(10**9)
        ends.append(s.row().tension)
    row("the same after 1 s: tensions against the tree", np.abs(ends[0] / ends[1] - 1.0).max(), at_most=1e-8)


def lift():
    noted, (t, full), steps, kernel, spent = kernel_alone(*LIFT)
    simulated, dofs, lift = noted.end.t * 1e-9, noted.simulation.program.nv, LIFT[0]
    row(f"{lift}, {dofs} DOF, kernel alone: real-time factor", simulated / kernel, at_least=1000.0)
    row(f"{lift}, one attempted step", spent["kernel, machine code"] / steps * 1e6, "us")
    for what, seconds in spent.items():
        row(f"{lift}, CPU of {what}", seconds, "s")
    (t_pruned, T), dofs, kernel = pruned_alone(noted, PRUNED)
    name = f"{lift}, {dofs} DOF (hinges locked), {PRUNED}"
    row(f"{name}: real-time factor", simulated / kernel, at_least=3000.0)
    grid = np.arange(0.0, simulated, 0.5)
    ropes = range(full.shape[1])
    off = [np.abs(np.interp(grid, t_pruned, T[:, i]) - np.interp(grid, t, full[:, i])).max() for i in ropes]
    row(f"{name}: tensions, of each rope's largest", max(off / full.max(axis=0)), at_most=0.01)


_START = """
import sys, time
sys.path.insert(0, {here!r})
from shared.reference_scenes import copies
from heavylift.kernel.simulation.simulation import Simulation
system = copies({n}, {hooks})
began = time.process_time()
Simulation(system)
print(time.process_time() - began)
"""


def starts():
    """CPU of fresh processes, without the imports."""
    for dofs, target in COMPILED.items():
        n = round(dofs / 24)
        with tempfile.TemporaryDirectory() as cache:
            environment = {**os.environ, "HEAVYLIFT_CACHE": cache}
            code = _START.format(here=str(Path(__file__).parent), n=n, hooks=HOOKS)

            def start(code=code, environment=environment):
                return float(subprocess.check_output([sys.executable, "-c", code], env=environment))

            row(f"compile {DOFS * n} DOF", start(), "s", at_most=target)
            row(f"the same from the cache, {DOFS * n} DOF", min(start() for _ in range(REPEATS)), "s", at_most=CACHED_s)


def growth():
    """Evaluations and machine code of n copies against n times one copy."""
    costs = {}
    for n in COPIES:
        s = Simulation(copies(n, HOOKS))
        s.start()
        costs[n] = (*native_loops.evaluation(s, times=max(20, 2000 // n), runs=7), len(s.X) + len(s.P))
        seconds, code, numbers = costs[n]
        row(f"{n} copies ({DOFS * n} DOF), one evaluation", seconds * 1e6, "us")
        row(f"{n} copies, machine code and state", code / 1e3 + numbers * 8e-3, "kB")
    one, code, numbers = costs[1]
    evaluations = max(c[0] / n / one for n, c in costs.items())
    memory = max((c[1] + 8 * c[2]) / n / (code + 8 * numbers) for n, c in costs.items())
    row("growth of an evaluation over linear, worst", evaluations, at_most=1.5)
    row("growth of memory over linear, worst", memory, at_most=1.5)
    row("peak memory of this process", resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3, "MB")


def main():
    options(__doc__)
    forward_dynamics()
    whole_runs()
    loops()
    lift()
    starts()
    growth()


if __name__ == "__main__":
    main()
