"""Cost of distributing a scene: forces held between two solvers, and its nodes in processes of their own.

Held: two bodies on one elastic rope, each integrated by a kernel of its own; every h seconds they exchange positions,
and the rope's force at that instant is held until the next exchange. Each solver is exact, yet the pair gains energy:
x'' = -w^2 x(nh) held over h has |lambda|^2 = 1 + (w h)^2 / 2, a damping ratio of -w h / 4 to first order. That is why
bodies connected by taut ropes are computed by one kernel.

Distributed: the same scene in one process, in two and with a process per node, as `heavylift run` runs it: all with the
same digest. Also with reductions for speed: fewer samples, and, if the scene has models of its own, delayed answers of
them (the delay is the lookahead of their ports). Wall time is that between the start and the last answer, with the
recording; processor time is that of all processes.
"""

import tempfile
import time
from dataclasses import dataclass, replace
from math import hypot, log, pi, sqrt
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage

import msgspec
from heavylift.coordinator.ladder.choosing import chosen
from heavylift.coordinator.ladder.tradeoff import Distributed, Held, MeasuredLadder
from heavylift.coordinator.participants import PRELOAD
from heavylift.coordinator.run import run
from heavylift.coordinator.supervision.processes import Processes
from heavylift.coordinator.transport.placement import Placement
from heavylift.kernel.description.forces import InputSignal, Load
from heavylift.kernel.description.mechanics import Body, Joint, Point, Rope, System
from heavylift.kernel.errors import SceneError
from heavylift.kernel.simulation.simulation import Simulation
from heavylift.nodes.models import node_names
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.scene import LoadedScene

EXCHANGES = (0.02, 0.01, 0.005, 0.002, 0.001)  # [s]
PERIODS = 6.0  # over which amplitudes are compared
BUDGET = 0.01  # growth of an amplitude over a run that somebody may accept
STRETCH = 0.01  # [m] at the start
LATER_ns = 100_000_000  # that models of a user may answer late


def hanging(scene: LoadedScene) -> "list[CoupledPair]":
    """Return, for each hook rope, the bodies above and below it; raises SceneError if no rope separates two bodies."""
    plan, found = scene.plan, list[CoupledPair]()
    for machine in plan.machines:
        bodies, ropes = {b.name: b.mass for b in machine.system.bodies}, {r.name: r for r in machine.system.all_ropes}
        for hook in machine.hooks:
            rope, upper = ropes.get(hook.rope), bodies.get(hook.on, 0.0)
            if isinstance(rope, Rope) and upper > 0.0:
                at_rest = scene.states[0].tensions if scene.states else {}
                most = max(
                    [at.tensions.get(hook.rope, 0.0) for at in scene.states], default=at_rest.get(hook.rope, 0.0)
                )
                lower = most / plan.gravity or hook.below
                found += [CoupledPair(hook.rope, upper, lower, rope.EA / rope.L0)] if lower > 0.0 else []
    if not found:
        raise SceneError(f"--coupling: nothing hangs on a hook rope in {scene.path.name}; leave out the option")
    return found


def communicating(scene: LoadedScene, measured: MeasuredLadder) -> MeasuredLadder:
    """Measure what it costs to run a scene in several processes; return `measured` with these costs added."""
    scene = chosen(scene)
    rows = distributed(scene)
    forces = [held(pair, h, rows[0].simulated_s) for pair in hanging(scene) for h in EXCHANGES]
    return replace(measured, held=forces, distributed=rows)


def distributed(scene: LoadedScene) -> list[Distributed]:
    """Measure the cost of running a scene in one process, two processes and one per node, also with fewer samples."""
    plan, nodes = scene.plan, node_names(scene.plan)
    apart = Placement.apart(nodes)
    rows: list[tuple[str, str, Plan, Placement | None]] = [
        ("one process", "least overhead", plan, None),
        ("two processes", "the kernel has a core of its own", plan, Placement.spread(nodes, 2)),
        ("a process per node, a tenth of the samples", "a shorter recording, with the peaks all the same",
         msgspec.structs.replace(plan, samples_hz=0.1 * plan.samples_hz), apart),
    ]  # fmt: skip
    if any(own.delay < LATER_ns for own in plan.models):
        late = tuple(msgspec.structs.replace(own, delay=max(own.delay, LATER_ns)) for own in plan.models)
        message = f"own models answer {LATER_ns * 1e-6:g} ms later: no waiting for them at each sample"
        rows.append(("a process per node, lookahead", message, msgspec.structs.replace(plan, models=late), apart))
    rows.append(("a process per node", "each dies and is replaced alone; other hosts, other programs", plan, apart))
    with tempfile.TemporaryDirectory(prefix="heavylift-") as folder:
        path = Path(folder) / "run.mcap"
        return [_run(replace(scene, plan=changed), path, where, buys, at) for where, buys, changed, at in rows]


@dataclass(frozen=True)
class CoupledPair:
    """Two bodies (masses [kg]) connected by a rope (stiffness [N/m]), each with a solver of its own: a test case of
    co-simulation."""

    name: str
    upper: float
    lower: float
    stiffness: float

    @property
    def omega(self) -> float:
        """Angular frequency [rad/s] of the relative motion of the two bodies."""
        return sqrt(self.stiffness * (1.0 / self.upper + 1.0 / self.lower))


def held(pair: CoupledPair, h: float, lasts: float) -> Held:
    """Measure the stability of two bodies whose solvers exchange forces every `h` [s]; `lasts`: duration of the scene's
    run [s]."""
    omega = pair.omega
    first, second = (
        _alone("upper", pair.upper, STRETCH * _part(pair)),
        _alone("lower", pair.lower, -STRETCH * (1.0 - _part(pair))),
    )
    steps = max(1, round(PERIODS * 2.0 * pi / omega / h))
    h_ns = round(h * 1e9)

    def apart() -> tuple[float, float]:
        (x1, v1), (x2, v2) = first.state[:2], second.state[:2]
        return float(x1 - x2), float(v1 - v2)

    before = hypot(apart()[0], apart()[1] / omega)
    for k in range(steps):
        for solver in (first, second):
            solver.interrupt(k * h_ns)
        pull = pair.stiffness * apart()[0]
        for solver, force in ((first, -pull), (second, pull)):
            solver.references.set_value("pull", solver.epoch, force)
            solver.settle()
    for solver in (first, second):
        solver.interrupt(steps * h_ns)
    x, v = apart()
    growth = log(hypot(x, v / omega) / before) / (steps * h)  # of the amplitude, per second
    return Held(pair.name, omega, h, -growth / omega, -omega * h / 4.0, 4.0 * log(1.0 + BUDGET) / (omega**2 * lasts))


def _part(pair: CoupledPair) -> float:
    """Return the share of the upper body in an elongation about the common centre of mass."""
    return pair.lower / (pair.upper + pair.lower)


def _alone(name: str, mass: float, x: float) -> Simulation:
    """Return a solver of one body on a rail, under an external force."""
    pull = Load("pull", Point(name), force=(1.0, 0.0, 0.0), signal=InputSignal(0.0, driven=True))
    rail = Joint("rail", "prismatic", "world", name, axis=(1.0, 0.0, 0.0), q0=(x,))
    solver = Simulation(System((Body(name, mass),), (rail,), forces=(pull,), gravity=0.0))
    solver.start()
    return solver


def _run(scene: LoadedScene, output: Path, where: str, buys: str, at: Placement | None) -> Distributed:
    crew = None if at is None else Processes(PRELOAD)
    began, before = time.perf_counter(), _processors()
    try:
        result = run(scene, output, in_process=at is None, processes=crew, placement=at, force=True)
    finally:
        if crew is not None:
            crew.end()
    wall, spent = time.perf_counter() - began, result.budget
    size, cpu = result.recording.stat().st_size, _processors() - before
    around = spent.start + spent.exit
    return Distributed(where, buys, result.sim_s, wall, spent.kernel, around, cpu, result.grants, size, result.digest)


def _processors() -> float:
    """Return the processor time of this process and of its ended children [s]."""
    spent = [getrusage(who) for who in (RUSAGE_SELF, RUSAGE_CHILDREN)]
    return sum(x.ru_utime + x.ru_stime for x in spent)
