"""The measured map of stability: longest stable step against stiffness, mass ratio and rope length, beside theory.

    python tests/bench/stability_map.py [--json] [--short] [-o kernel/stability.png]

For each scene and method the longest fixed step that the kernel lets run is found by halving, each trial being a real
run: 400 steps of a small push, after which the motion must not have grown.  The guard is switched off for that, so that
the map shows the methods themselves; rings are the guard's own limit.  Lines are those of theory, 2/w for
semi-implicit Euler and 2.828/w for Runge-Kutta, w being the scene's largest frequency in closed form.
Methods that are stable at every step are drawn at the longest step tried.
"""

import io
import sys
from dataclasses import replace
from math import sqrt
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "kernel"))

import matplotlib
import numpy as np
from heavylift.kernel import KernelError
from heavylift.kernel.description import Body, Joint, Line, Point, Rope, System
from heavylift.kernel.simulation import Simulation
from heavylift.kernel.simulation.safeguards import StepCheck
from shared.rows import SHORT, options, row
from small_scenes import EA, LENGTH, MASS, SECOND, G, Z, hung

matplotlib.use("Agg")
import matplotlib.pyplot as plt

METHODS = {"semi-implicit-euler": 2.0, "rk4": 2.0 * sqrt(2.0), "radau5": None}
COLOURS = dict(zip(METHODS, ("#b5541c", "#1f5fa8", "#7a3fa0"), strict=True))
STEPS = 40 if SHORT else 400  # of a trial
GROWN, LONGEST = 3.0, 3.0  # how much may be a beat of two modes; steps [s] tried at most
HALVINGS = 1 if SHORT else 8  # of the ratio between a stable and an unstable step: 2 % in the end


def hanging(k: float, L: float = LENGTH) -> tuple[System, float]:
    """A load at rest on its rope; the largest frequency [rad/s]."""
    scene = hung(L + MASS * G / k, L)
    return replace(scene, ropes=(replace(scene.ropes[0], EA=k * L),)), sqrt(k / MASS)


def two(ratio: float) -> tuple[System, float]:
    """A hook between rope and sling of equal stiffness, with a load so many times as heavy."""
    k, hook = EA / LENGTH, MASS / ratio
    x = LENGTH + (hook + MASS) * G / k
    places = (x, x + 6.0 + MASS * G / k)
    scene = System(
        (Body("hook", hook), Body("load", MASS)),
        tuple(
            Joint(f"{n}-guide", "prismatic", "world", n, axis=Z, q0=(-q,))
            for n, q in zip(("hook", "load"), places, strict=True)
        ),
        ropes=(
            Rope("rope", (Line(Point("world"), Point("hook")),), EA, LENGTH),
            Rope("sling", (Line(Point("hook"), Point("load")),), EA * 6.0 / LENGTH, 6.0),
        ),
        gravity=G,
    )
    half = 0.5 * k * (2.0 / hook + 1.0 / MASS)
    return scene, sqrt(half + sqrt(half * half - k * k / hook / MASS))


POINTS = 1 if SHORT else 0  # of each axis, 0: enough to see its law
AXES = {
    "stiffness of the rope, 1/60 m of steel = 1": (np.logspace(-3, 4, POINTS or 8), lambda x: hanging(EA / LENGTH * x)),
    "load / hook": (np.logspace(-4, 6, POINTS or 6), two),
    "length of the rope [m]": (np.logspace(-1, 2, POINTS or 7), lambda x: hanging(EA / x, x)),
}


def runs(scene: System, method: str, step: float, guarded: bool) -> bool:
    """Whether a push dies or stays; or, `guarded`, whether the kernel would begin at all."""
    check = StepCheck.check
    if not guarded:
        StepCheck.check = lambda self, *_: None
    try:
        s = Simulation(scene, method=method, step=step, sample_ns=max(100_000, round(step * STEPS * SECOND)))
        s.start()
        if guarded:
            return True
        n = s.program.nq
        rest = s.state[:n].copy()
        push = 1e-3 * MASS * G / max(r.EA / r.L0 for r in scene.ropes)
        s.state[:n] += push * np.arange(1, n + 1)
        s.settle()
        s.run(round(step * STEPS * SECOND))
        return bool(np.abs(s.state[:n] - rest).max() <= GROWN * push * n) and not s.log
    except KernelError:
        return False
    finally:
        StepCheck.check = check


def longest(scene: System, method: str, w: float, guarded: bool = False) -> float:
    """Longest step [s] that runs, from LONGEST periods of the fastest mode downwards."""
    high = LONGEST * 2.0 * np.pi / w
    if runs(scene, method, high, guarded):
        return high
    low = high
    while low > 1e-3 * high and not runs(scene, method, low, guarded):
        high, low = low, 0.5 * low
    for _ in range(HALVINGS):
        middle = sqrt(low * high)
        low, high = (middle, high) if runs(scene, method, middle, guarded) else (low, middle)
    return low


def main() -> None:
    output = {"dest": "output", "default": io.BytesIO(), "help": "where the map is drawn, else nowhere"}
    given = options(__doc__ or "", {"-o": output})
    figure, panels = plt.subplots(1, 3, figsize=(13.5, 4.6), layout="constrained")
    for panel, (label, (values, scene_of)) in zip(panels, AXES.items(), strict=True):
        scenes = [scene_of(float(x)) for x in values]
        fine = np.logspace(np.log10(values[0]), np.log10(values[-1]), 100)
        frequency = np.array([scene_of(float(x))[1] for x in fine])
        for method, limit in METHODS.items():
            found = np.array([longest(scene, method, w) for scene, w in scenes])
            guard = np.array([longest(scene, method, w, guarded=True) for scene, w in scenes])
            everywhere = limit is None
            message = f"{method}: stable at every step tried" if everywhere else method
            shape = {"marker": "^" if everywhere else "o", "ms": 5}
            panel.loglog(values, found, ls="", color=COLOURS[method], label=message, **shape)
            if not everywhere:
                panel.loglog(values, guard, "o", ms=10, mfc="none", color=COLOURS[method])
                panel.loglog(fine, limit / frequency, "-", lw=1.0, color=COLOURS[method], label=f"{limit:.3g}/w")
            for x, h, g, (_, w) in zip(values, found, guard, scenes, strict=True):
                theory = () if everywhere else (f"{limit:.3g}/w", limit / w)
                row(f"{label} {x:g}, {method}", h, "s", *theory)
                row(f"{label} {x:g}, {method}: the guard's limit", g, "s", "measured", h)
        panel.set_xlabel(label)
        panel.grid(True, which="major", lw=0.3)
    panels[0].set_ylabel("longest stable step [s]")
    panels[0].legend(fontsize=8, loc="lower left")
    figure.suptitle("Longest stable fixed step, measured (dots), allowed by the guard (rings), by theory (lines)")
    figure.savefig(given.output, dpi=110)


if __name__ == "__main__":
    main()
