"""The table of extremes: every one with every integrator is a right result, a result with a word, or a refusal.

    python tests/extremes/table.py [--peers] [--page]        prints all cells, or the rows of STABILITY.md

An `Extreme` runs a scene and returns what it measured beside what `independent` says, in units of the bound's scale.
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from math import cos, inf, nan, pi, radians, sin, sqrt
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "kernel"))

from heavylift.kernel.describe import Body, Joint, Line, Lock, Point, RigidRope, Rope, Stop, System
from heavylift.kernel.errors import KernelError
from heavylift.kernel.simulation import Simulation
from independent import bounce, chain, double_pendulum, hoisted, period, planar, turn
from small_scenes import EA, LENGTH, MASS, SECOND, G, X, Y, Z, cube, hung, slider, times

CONTROLLED, FIXED, FIRST_ORDER = 2e-3, 2e-2, 0.25  # bounds of an error relative to its scale, see STABILITY.md
MICROMETRE = 1e-6  # [m] place errors below are the tolerance's


@dataclass(frozen=True)
class Integrator:
    """A method with its tolerance or step, and the error that a result of it may have."""

    name: str
    options: dict
    bound: float


INTEGRATORS = (
    Integrator("dopri5", {"method": "dopri5", "tolerance": 1e-9}, CONTROLLED),
    Integrator("dop853", {"method": "dop853", "tolerance": 1e-9}, CONTROLLED),
    Integrator("radau5", {"method": "radau5", "tolerance": 1e-8}, CONTROLLED),
    Integrator("ros34pw2", {"method": "ros34pw2", "tolerance": 1e-8}, CONTROLLED),
    Integrator("rk4 5 ms", {"method": "rk4", "step": 5e-3}, FIXED),
    Integrator("radau5 5 ms", {"method": "radau5", "step": 5e-3}, FIXED),
    Integrator("ros34pw2 5 ms", {"method": "ros34pw2", "step": 5e-3}, FIXED),
    Integrator("euler 1 ms", {"method": "semi-implicit-euler", "step": 1e-3}, FIRST_ORDER),
)
PEERS = tuple(
    Integrator(f"scipy-{x}", {"method": f"scipy-{x}", "tolerance": 1e-8}, CONTROLLED)
    for x in ("dop853", "radau", "bdf", "lsoda")
)
LEAN = tuple(x for x in INTEGRATORS if x.name in ("dopri5", "radau5", "rk4 5 ms", "ros34pw2 5 ms"))


@dataclass(frozen=True)
class Extreme:
    """`run(options)` gives (error relative to its scale, the simulation)."""

    name: str
    run: Callable[[dict], tuple[float, Simulation]]


@dataclass(frozen=True)
class Cell:
    """What came out: the error of a result, what was said of it, or the sentence of a refusal."""

    error: float
    notes: tuple[str, ...]
    refusal: str

    def right(self, bound: float) -> bool:
        """No finite wrong answer without a word."""
        return bool(self.refusal) or self.error <= bound or bool(self.notes)

    def __str__(self) -> str:
        if self.refusal:
            return f"refused: {self.refusal}"
        said = f", and says: {'; '.join(self.notes)}" if self.notes else ""
        return f"error {self.error:.1e}{said}"


def cell(extreme: Extreme, integrator: Integrator) -> Cell:
    try:
        error, s = extreme.run(integrator.options)
    except KernelError as e:
        return Cell(inf, (), str(e))
    return Cell(error if np.isfinite(error) else inf, tuple(note.sentence for note in s.notes), "")


def go(s: Simulation, t_ns: int) -> Simulation:
    """Up to t_ns."""
    s.run(t_ns)
    s.interrupt(t_ns)
    s.settle()
    return s


def started(system: System, options: dict, **more) -> Simulation:
    s = Simulation(system, **{"sample_ns": SECOND // 20, "h_max": 0.05} | options | more)
    s.start()
    return s


# ---- ropes and masses ---------------------------------------------------------------------------------------


def stiffness(factor: float) -> Extreme:
    """A load let go on a straight rope; from 1e4 on it is 10 cm of rope, with the rest of the factor in EA."""
    L0 = LENGTH if factor < 1e3 else 0.1
    k = EA / LENGTH * factor
    scene = hung(L0, L0)
    scene = replace(scene, ropes=(replace(scene.ropes[0], EA=k * L0),))

    def run(options: dict):
        t = max(1.0, 4.0 / sqrt(k / MASS))
        s = go(started(scene, options), round(t * SECOND))
        down, _, most = bounce(MASS, k, t)
        peak = max(float(r[s.method.row_layout.at["peak"]][0]) for _, r in s.rows)
        place = abs(-float(s.state[0]) - L0 - down) / (2.0 * MASS * G / k + MICROMETRE)
        return max(place, abs(peak - most) / most), s

    return Extreme(f"rope stiffness x {factor:g}", run)


def ratio(r: float) -> Extreme:
    """A hook between rope and sling, and a load r times as heavy; the load is let go a tenth above its rest."""
    hook, load = (MASS / r, MASS) if r >= 1.0 else (MASS, MASS * r)
    scene = System(
        (Body("hook", hook), Body("load", load)),
        tuple(Joint(f"{n}-guide", "prismatic", "world", n, axis=Z) for n in ("hook", "load")),
        ropes=(
            Rope("rope", (Line(Point("world"), Point("hook")),), EA, LENGTH),
            Rope("sling", (Line(Point("hook"), Point("load")),), EA / 10.0, LENGTH / 10.0),
        ),
        gravity=G,
    )
    k = EA / LENGTH
    rest = np.array([LENGTH + (hook + load) * G / k, 0.0])
    rest[1] = rest[0] + 0.1 * LENGTH + load * G / k
    lift = 0.1 * load * G / k

    def run(options: dict):
        s = started(
            replace(
                scene, joints=tuple(replace(j, q0=(-x,)) for j, x in zip(scene.joints, rest - [0.0, lift], strict=True))
            ),
            options,
        )
        go(s, SECOND // 2)
        want = -rest + chain([hook, load], [k, k], np.array([0.0, lift]), 0.5)
        return float(np.abs(s.state[:2] - want).max()) / (lift + MICROMETRE), s

    return Extreme(f"load to hook {r:g}", run)


def empty_hook() -> Extreme:
    """The hook alone, 45 t less its load, with the sling hanging slack from it."""
    scene = hung(LENGTH)
    scene = replace(scene, bodies=(replace(scene.bodies[0], mass=500.0),))

    def run(options: dict):
        s = go(started(scene, options), SECOND)
        return abs(-float(s.state[0]) - LENGTH - bounce(500.0, EA / LENGTH, 1.0)[0]) / (1000.0 * G * LENGTH / EA), s

    return Extreme("empty hook, 0.5 t", run)


def massless(what: str) -> Extreme:
    """A body on which a force acts although nothing resists it."""
    mass, inertia = (0.0, cube(0.0)) if what == "mass" else (10.0, cube(0.0))
    body = Body("hook", mass, inertia=inertia)
    joint = Joint("float", "free", "world", "hook", q0=(0.0, 0.0, -LENGTH, 0.0, 0.0, 0.0, 1.0))
    line = Line(Point("world"), Point("hook", (0.1, 0.0, 0.0)))
    scene = System((body,), (joint,), ropes=(Rope("rope", (line,), EA, LENGTH),), gravity=G)

    def run(options: dict):
        return inf, go(started(scene, options), SECOND // 10)

    return Extreme(f"no {what}", run)


# ---- swing ---------------------------------------------------------------------------------------------------


def bar(length: float, angle: float, speed: float = 0.0, at=(0.0, 0.0, 0.0)) -> System:
    """A point load on a stiff bar, hinged; angle from straight down."""
    hinge = Joint("hinge", "revolute", "world", "bob", p_PJ=at, axis=Y, q0=(angle,), v0=(speed,))
    return System((Body("bob", 1e5, (0.0, 0.0, -length)),), (hinge,), gravity=G)


def swing(degrees: float, at=(0.0, 0.0, 0.0), name: str = "") -> Extreme:
    a, L = radians(degrees), 20.0

    def run(options: dict):
        T = period(a, L)
        s = go(started(bar(L, a, at=at), options), round(1.25 * T * SECOND))
        # at a quarter beyond a period it passes the bottom at full speed
        v = 2.0 * sqrt(G / L) * sin(0.5 * a)
        return max(abs(float(s.state[0])) / a, abs(abs(float(s.state[1])) - v) / v), s

    return Extreme(name or f"swing to {degrees:g} degrees", run)


def over_the_top() -> Extreme:
    L = 20.0
    v = 1.05 * sqrt(4.0 * G * L)

    def run(options: dict):
        s = go(started(bar(L, 0.0, v / L), options), round(3.0 * turn(v, L) * SECOND))
        return max(abs(float(s.state[0]) - 6.0 * pi) / (2.0 * pi), abs(float(s.state[1]) * L - v) / v), s

    return Extreme("three times over the top", run)


def on_a_rope(degrees: float) -> Extreme:
    """A block on one elastic rope swings; beyond 90 degrees the rope goes slack and snaps taut."""
    a, m, i, L = radians(degrees), 1e5, 1e5 * 4.0 / 6.0, 20.0
    ropes = [(0.0, 0.0, 0.0, 1.0, 1e8, L, 2e5)]
    reach = L + 1.0 + (m * G * cos(a) / 1e8 * L if degrees < 90 else -0.2)
    x, z = -reach * sin(a), -reach * cos(a)

    def run(options: dict):
        half = 0.5 * a
        q0 = (x, 0.0, z, 0.0, sin(half), 0.0, cos(half))
        line = Line(Point("world"), Point("block", (0.0, 0.0, 1.0)))
        scene = System(
            (Body("block", m, inertia=cube(m)),), (Joint("float", "free", "world", "block", q0=q0),),
            ropes=(Rope("rope", (line,), 1e8, L, 2e5),), gravity=G,
        )  # fmt: skip
        s = go(started(scene, options), 4 * SECOND)
        want = planar(m, i, ropes, [x, z, a, 0.0, 0.0, 0.0], 4.0)
        return float(np.hypot(s.state[0] - want[0], s.state[2] - want[1])) / L, s

    return Extreme(f"a rope let go at {degrees:g} degrees", run)


# ---- events ---------------------------------------------------------------------------------------------------


def caught(stiff: float = 1.0) -> Extreme:
    """A load falls into its rope; the peak between two samples is that of energy."""
    k = EA * stiff / LENGTH
    scene = hung(LENGTH - 1.0, v0=0.0)
    scene = replace(scene, ropes=(replace(scene.ropes[0], EA=EA * stiff),))

    def run(options: dict):
        s = go(started(scene, options, sample_ns=SECOND // 2), SECOND)
        peak = max(float(r[s.method.row_layout.at["peak"]][0]) for _, r in s.rows)
        want = MASS * G + sqrt((MASS * G) ** 2 + 2.0 * k * MASS * G * 1.0)
        when = times(s, "rope", "taut")[0]
        return max(abs(peak - want) / want, abs(when - sqrt(2.0 / G))), s

    return Extreme(f"falls 1 m into its rope x {stiff:g}", run)


def two_at_once() -> Extreme:
    """Two loads fall 1 m into two ropes in the same nanosecond."""
    one = hung(LENGTH - 1.0)
    other = replace(
        slider("other", MASS, Z, -(LENGTH - 1.0)),
        ropes=(Rope("second", (Line(Point("world"), Point("other")),), EA, LENGTH),),
    )
    scene = System(
        one.bodies + other.bodies, one.joints + other.joints, ropes=one.ropes + other.ropes, gravity=G,
    )  # fmt: skip

    def run(options: dict):
        s = go(started(scene, options), SECOND * 6 // 10)
        a, b = times(s, "rope", "taut")[0], times(s, "second", "taut")[0]
        assert a == b
        w = sqrt(EA / LENGTH / MASS)
        late, v = 0.6 - sqrt(2.0 / G), sqrt(2.0 * G)
        down = G / w**2 * (1.0 - cos(w * late)) + v / w * sin(w * late)
        return float(np.abs(-s.state[:2] - LENGTH - down).max()), s

    return Extreme("two events at one instant", run)


def reversal() -> Extreme:
    """The hoist lifts a load off springy ground and turns round in the moment of lift-off."""
    k, ground, v = 1e9, -LENGTH, 0.05
    d = 0.3 * 2.0 * sqrt(k * MASS)
    turned = round((MASS * G / EA * LENGTH + MASS * G / k) / v * SECOND)
    stop = Stop("ground", "load-guide", ground, 100.0, k, d)
    scene = replace(hung(LENGTH + MASS * G / k, LENGTH + MASS * G / k, winch=True), stops=(stop,))
    L0 = LENGTH + MASS * G / k

    def winch(t: float):
        return (L0 - v * t, -v) if t < turned * 1e-9 else (L0 - v * (2.0 * turned * 1e-9 - t), v)

    @cache
    def want() -> float:
        return float(hoisted(MASS, EA, L0, ground, k, d, winch, turned * 1e-9 + 1.0)[0])

    def run(options: dict):
        s = started(scene, options)
        s.references.set_profile("rope", 0, -v, 1e7, None)
        s.settle()
        s.run(turned)
        s.interrupt(turned)
        s.references.set_profile("rope", turned, v, 1e7, None)
        s.settle()
        go(s, turned + SECOND)
        return abs(float(s.state[0]) - want()) / (MASS * G / k), s

    return Extreme("hoist reversal at lift-off", run)


def freed() -> Extreme:
    """Two bars swing as one; after a second their locked hinge is freed in motion."""
    m, l, a = 1e4, 5.0, 1.0
    i = m * l * l / 12.0
    inertia = ((i, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, 0.0))
    scene = System(
        tuple(Body(n, m, (0.0, 0.0, -0.5 * l), inertia) for n in ("upper", "lower")),
        (
            Joint("top", "revolute", "world", "upper", axis=Y, q0=(a,)),
            Joint("elbow", "revolute", "upper", "lower", (0.0, 0.0, -l), axis=Y),
        ),
        locks=(Lock("lock", "elbow", True),),
        gravity=G,
    )

    def run(options: dict):
        s = started(scene, options)
        s.run(SECOND)
        s.interrupt(SECOND)
        at = s.state[:4].copy()
        s.set_lock("lock", False)
        s.settle()
        go(s, 2 * SECOND)
        want = double_pendulum(m, l, i, [at[0], at[0], at[2], at[2]], 1.0)
        return float(np.abs(s.state[:2] - [want[0], want[1] - want[0]]).max()), s

    return Extreme("a locked joint freed in motion", run)


def redundant() -> Extreme:
    """Three equal rigid ropes side by side hold a load on a guide and share its weight."""
    ropes = tuple(RigidRope(f"rope{n}", (Line(Point("world"), Point("load")),), LENGTH) for n in range(3))
    scene = replace(slider(q0=-LENGTH), rigid_ropes=ropes)

    def run(options: dict):
        s = go(started(scene, options), SECOND)
        T = s.row().pull
        return max(float(np.abs(np.array(T) - MASS * G / 3.0).max()) / (MASS * G), abs(float(s.state[0]) + LENGTH)), s

    return Extreme("three ropes for one load", run)


def collinear() -> Extreme:
    """Three points of a rope in one line with the load, pulled across: the sideways stiffness is that of tension."""
    h, pull, m = 10.0, 1e6, 1e3
    strain = pull / EA
    L0 = h / (1.0 + strain)
    lines = [Line(Point("world", (0.0, y, 0.0)), Point("load")) for y in (-h, h)]
    scene = replace(
        slider(mass=m, axis=X, q0=0.05),
        ropes=tuple(Rope(f"rope{n}", (line,), EA, L0) for n, line in enumerate(lines)), gravity=0.0,
    )  # fmt: skip
    w = sqrt(2.0 * pull / h / m)

    def run(options: dict):
        t = 0.75 * 2.0 * pi / w
        s = go(started(scene, options), round(t * SECOND))
        # Duffing: w' = w (1 + 3/8 a x0^2), of the stretch that the way aside adds; the phase is read at a zero
        a = (EA / L0 - pull / h) / (2.0 * pull / h) / h**2 * 1.0
        phase = 0.75 * 2.0 * pi * (1.0 + 3.0 / 8.0 * a * 0.05**2)
        return abs(float(s.state[0]) / 0.05 - cos(phase)), s

    return Extreme("collinear ropes, pulled across", run)


def meets() -> Extreme:
    """A rope whose ends meet has no direction."""
    return Extreme("ends of a rope meet", lambda options: (inf, go(started(hung(0.0), options), SECOND)))


def not_a_number(what: str, value: float) -> Extreme:
    """NaN or infinity in a description, a state or a command."""

    def run(options: dict):
        scene = hung(LENGTH, winch=True)
        if what in ("EA", "L0", "damping"):
            scene = replace(scene, ropes=(replace(scene.ropes[0], **{what: value}),))
        if what == "mass":
            scene = replace(scene, bodies=(replace(scene.bodies[0], mass=value),))
        if what in ("q0", "v0"):
            scene = replace(scene, joints=(replace(scene.joints[0], **{what: (value,)}),))
        s = started(scene, options)
        if what == "speed":
            s.references.set_profile("rope", 0, value, 0.1, None)
            s.settle()
        if what == "force":
            s.P[s.program.parameters.at["gravity", ""]] = value
        return inf, go(s, SECOND // 10)

    return Extreme(f"{what} is {value}", run)


EXTREMES = (
    *(stiffness(10.0**n) for n in range(-3, 5)),
    *(ratio(10.0**n) for n in (-6, -4, -2, 0, 2, 4, 6)),
    empty_hook(),
    massless("mass"),
    massless("inertia"),
    *(swing(x) for x in (60.0, 90.0, 179.0)),
    over_the_top(),
    swing(30.0, (1e5, -1e5, 1e5), "1e5 m from the origin"),
    on_a_rope(60.0),
    on_a_rope(120.0),
    caught(),
    caught(100.0),
    two_at_once(),
    reversal(),
    freed(),
    redundant(),
    collinear(),
    meets(),
    *(
        not_a_number(what, x)
        for what in ("mass", "EA", "L0", "damping", "q0", "v0", "speed", "force")
        for x in (nan, inf)
    ),
)

WORDS = {
    "does not follow": "refused: swing", "too long for method": "refused: step", "energy balance": "refused: energy",
    "a million steps": "refused: pace",
}  # fmt: skip


def short(c: Cell) -> str:
    """A cell of the page."""
    if c.refusal:
        return next((word for part, word in WORDS.items() if part in c.refusal), "refused")
    return f"{c.error:.1e}{'*' if c.notes else ''}"


if __name__ == "__main__":
    columns = (*INTEGRATORS, *(PEERS if "--peers" in sys.argv else ()))
    page = "--page" in sys.argv
    for x in EXTREMES:
        cells = [cell(x, i) for i in columns if not (page and x.name.endswith((" nan", " inf")))]
        if page and cells:
            print(f"| {x.name} | {' | '.join(map(short, cells))} |", flush=True)
        for i, c in zip(columns, () if page else cells, strict=False):
            print(f"{'ok ' if c.right(i.bound) else 'BAD'} {x.name:<34} {i.name:<14} {c}", flush=True)
