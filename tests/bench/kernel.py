"""What the kernel costs, beside MuJoCo and Pinocchio in one process on one core.

    python tests/bench/kernel.py [--json] [--quick]

Every time is the least of several and free of calls from Python: functions of all three are called in loops of machine
code or by their own batch calls (`native_loops`, `peers`).  Ratios are ours to the peer's; a target that is missed is
printed as missed.  The cost of the formulations is measured in `formulations.py`, whole processes in `turnover.py`.
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

sys.path.insert(0, str(Path(__file__).parents[1] / "kernel"))

import native_loops
import numpy as np
import peers
from goliath import scene
from heavylift.kernel.describe import WORLD, Joint, System
from heavylift.kernel.simulation import Simulation
from recorded_commands import kernel_alone, pruned_alone

REFERENCE = json.loads((Path(__file__).parents[1] / "data" / "goliath_reference.json").read_text())
SCALE = 5.5e5  # [N] static tension, to which errors refer
SECONDS = 10
COMPILED = {24: 0.7, 100: 1.5, 400: 5.0}  # degrees of freedom -> seconds of a cold start
CACHED_s = 0.12
PRUNED = "dop853"  # without the hinges' fast modes steps grow, and a higher order pays
COPIES = (1, 2, 5, 10, 20, 40)
QUICK = "--quick" in sys.argv  # neither growth nor large scenes


def row(name, value, unit, peer=None, peer_value=None, target=None, ratio=None, most=True):
    """One line; `target` bounds the ratio if there is a peer, else the value, from above (`most`) or from below."""
    if peer and ratio is None:
        ratio = value / peer_value
    measured = ratio if peer else value
    met = None if target is None else bool(measured <= target if most else measured >= target)
    digits = {"value": value, "peer_value": peer_value, "ratio": ratio, "target": target}
    numbers = {k: x if x is None else float(f"{x:.4g}") for k, x in digits.items()}
    line = {"name": name, "value": numbers["value"], "unit": unit, "peer": peer, **numbers, "met": met}
    if "--json" in sys.argv:
        print(json.dumps(line), flush=True)
        return
    told = f"{name:<60} {line['value']:>9} {unit:<4}"
    if peer:
        told += f"  {peer} {line['peer_value']} {unit}, ratio {line['ratio']}"
    if target is not None:
        told += f"  target {'<=' if most else '>='} {line['target']}: {'met' if met else 'MISSED'}"
    print(told, flush=True)


def forward_dynamics():
    s = Simulation(scene())
    s.start()
    strict, fused = (native_loops.evaluation(s, fused)[0] * 1e6 for fused in (False, True))
    mj, aba = peers.MuJoCo(scene()).forward() * 1e6, peers.pinocchio_aba(s.program.graph) * 1e6
    name = "forward dynamics, 24 DOF, six ropes"
    row(f"{name}, strict", strict, "us", "MuJoCo mj_forward", mj, 1 / 4.5)
    row(f"{name}, strict", strict, "us", "Pinocchio aba without ropes", aba, 1 / 6)
    row(f"{name}, fused", fused, "us", "MuJoCo mj_forward", mj, 1 / 5.5)


def tensions(at):
    """(ropes,) of the reference at a whole second."""
    return np.array(REFERENCE["tension"][REFERENCE["t"].index(float(at))])


def own_run(method, tolerance):
    """Largest error of the tensions at whole seconds, CPU milliseconds, and what was chosen."""
    least = np.inf
    for _ in range(3):
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
    peer = peers.MuJoCo(scene(), "RK4", 1.0 / steps)
    error = spent = 0.0
    for t in range(1, SECONDS + 1):
        began = time.thread_time()
        peers.mujoco.mj_step(peer.model, peer.data, steps)
        spent += time.thread_time() - began
        error = max(error, np.abs(peer.tensions() - tensions(t)).max() / SCALE)
    return error, spent * 1e3, f"{steps} steps a second"


def whole_runs():
    """Each side's fastest run that is as exact as asked for, whatever its method, tolerance or step."""
    ours = [own_run(method, 10.0**-k) for method in ("dopri5", "dop853") for k in np.arange(3.0, 12.1, 0.25)]
    theirs = [mujoco_run(n) for n in (20, 30, 40, 60, 80, 120, 200, 300, 500, 800, 1200, 2000, 3000)]
    for error in (1e-3, 1e-6, 1e-9):
        (a, own), (b, peer) = (min((ms, how) for e, ms, how in runs if e <= error) for runs in (ours, theirs))
        row(f"{SECONDS} s at a tension error of {error:g}, {own}", a, "ms", f"MuJoCo RK4 ({peer})", b, 1 / 5)


def pinned():
    """The reference scene with each loader on two pins in line: 36 redundant rows of rank 30 among bodies cut loose,
    of which the kernel's spanning tree leaves 18."""
    one, joints = scene(), []
    for j in one.joints:
        x, y, z = j.p_PJ
        ends = ((f"{j.name}-{d}", d) for d in (-0.5, 0.5))
        pins = [Joint(name, "spherical", "block", j.child, (x + d, y, z), p_CJ=(d, 0.0, 0.0)) for name, d in ends]
        joints += pins if j.parent == "block" else [j]
    springs = tuple(x for x in one.springs if not x.joint.startswith("low"))  # pins have no friction
    return replace(one, joints=tuple(joints), springs=springs)


def loops():
    s = Simulation(pinned())
    s.start()
    own, name = native_loops.evaluation(s)[0] * 1e6, "redundant loop rows (36, rank 30)"
    row(name, own, "us", target=9.0)
    loose, pins = peers.cut_loose(scene())
    row(name, own, "us", "MuJoCo mj_forward, 36 equality rows", peers.MuJoCo(loose, pins=pins).forward() * 1e6)
    for what, seconds in peers.pinocchio_constrained(scene()).items():
        row(name, own, "us", f"Pinocchio {what} without ropes", seconds * 1e6)
    as_tree = replace(scene(), springs=pinned().springs)
    ends = []
    for system in (pinned(), as_tree):
        s = Simulation(system, 1e-10)
        s.start()
        s.run(10**9)
        s.interrupt(10**9)
        ends.append(s.row().tension)
    row("the same after 1 s: tensions against the tree", np.abs(ends[0] / ends[1] - 1.0).max(), "", target=1e-8)


def lift():
    noted, (t, full), steps, kernel, spent = kernel_alone("turnover")
    simulated, dofs = noted.end.t * 1e-9, noted.simulation.program.nv
    row(f"turnover, {dofs} DOF, kernel alone: real-time factor", simulated / kernel, "", target=1000.0, most=False)
    row("turnover, one attempted step", spent["kernel, machine code"] / steps * 1e6, "us")
    for what, seconds in spent.items():
        row(f"turnover, CPU of {what}", seconds, "s")
    (t_pruned, T), dofs, kernel = pruned_alone(noted, PRUNED)
    name = f"turnover, {dofs} DOF (hinges locked), {PRUNED}"
    row(f"{name}: real-time factor", simulated / kernel, "", target=3000.0, most=False)
    grid = np.arange(0.0, simulated, 0.5)
    ropes = range(full.shape[1])
    off = [np.abs(np.interp(grid, t_pruned, T[:, i]) - np.interp(grid, t, full[:, i])).max() for i in ropes]
    row(f"{name}: tensions, of each rope's largest", max(off / full.max(axis=0)), "", target=0.01)


def copies(n):
    """n reference scenes side by side."""
    one = scene()

    def renamed(part, i):
        if isinstance(part, tuple):
            return tuple(renamed(x, i) for x in part)
        fields = getattr(part, "__dataclass_fields__", None)
        if fields is None:
            return part
        names = {"name", "parent", "child", "joint", "body", "of"} & set(fields)
        own = {k: renamed(getattr(part, k), i) for k in fields}
        own |= {k: f"{getattr(part, k)}-{i}" for k in names if getattr(part, k) != WORLD}
        return type(part)(**own)

    groups = ("bodies", "joints", "springs", "drives", "ropes")
    return System(
        **{g: tuple(renamed(x, i) for i in range(n) for x in getattr(one, g)) for g in groups}, gravity=one.gravity
    )


_START = """
import sys, time
sys.path[:0] = {paths!r}
from kernel import copies
from heavylift.kernel.simulation import Simulation
system = copies({n})
began = time.process_time()
Simulation(system)
print(time.process_time() - began)
"""


def starts():
    """CPU of fresh processes, without the imports."""
    paths = [str(Path(__file__).parent), str(Path(__file__).parents[1] / "kernel")]
    for dofs, target in COMPILED.items():
        n = round(dofs / 24)
        with tempfile.TemporaryDirectory() as cache:
            environment = {**os.environ, "HEAVYLIFT_CACHE": cache}
            code = _START.format(paths=paths, n=n)

            def start(code=code, environment=environment):
                return float(subprocess.check_output([sys.executable, "-c", code], env=environment))

            row(f"compile {24 * n} DOF", start(), "s", target=target)
            row(f"the same from the cache, {24 * n} DOF", min(start() for _ in range(3)), "s", target=CACHED_s)


def growth():
    """Evaluations and machine code of n copies against n times one copy."""
    costs = {}
    for n in COPIES:
        s = Simulation(copies(n))
        s.start()
        costs[n] = (*native_loops.evaluation(s, times=max(20, 2000 // n), runs=7), len(s.X) + len(s.P))
        seconds, code, numbers = costs[n]
        row(f"{n} copies ({24 * n} DOF), one evaluation", seconds * 1e6, "us")
        row(f"{n} copies, machine code and state", code / 1e3 + numbers * 8e-3, "kB")
    one, code, numbers = costs[1]
    row("growth of an evaluation over linear, worst", max(c[0] / n / one for n, c in costs.items()), "", target=1.5)
    row(
        "growth of memory over linear, worst",
        max((c[1] + 8 * c[2]) / n / (code + 8 * numbers) for n, c in costs.items()),
        "",
        target=1.5,
    )
    row("peak memory of this process", resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3, "MB")


def main():
    forward_dynamics()
    whole_runs()
    loops()
    lift()
    if not QUICK:
        starts()
        growth()


if __name__ == "__main__":
    main()
