"""Random lifts for the trade between speed and accuracy: one seed, one scene.

what            range
block           50 t to 380 t on one hook, 760 t on two, 840 t on three, 900 t on more
its centre      up or down by up to 10 % of the height; along the rails, where nothing is symmetric and there are two
                hooks or more, by up to 10 % of the 20 m over which they can hold it; across, where both trolleys carry,
                by up to 10 % of the 10 m that lie between them
hooks           1 to 6, on one crane or two
ropes           8 to 80 m, on a crane whose two trolleys both carry 18 to 80 m the longer and 8 to 70 m the shorter
lift-off        in two thirds of the scenes hoisting until lifted, else by a way, at a speed of its own up to 3 m/min
speeds          picking up 0.5 to 3 m/min, hoisting 1.5 to 3, traversing 4 to 20, travelling 5 to 30
slack           in 20 % of the scenes 50 to 300 mm; else 30 mm
symmetry        20 % have none: their centre lies aside, the cranes travel; nor has any lift on five hooks
"""

from __future__ import annotations

from math import exp, log
from random import Random

HOOKS = {1: ("H3",), 2: ("H1", "H2"), 3: ("H1", "H2", "H3")}
TWO = {4: (("H1", "H3"), ("H1", "H3")), 5: (("H1", "H2", "H3"), ("H1", "H3")), 6: (("H1", "H2", "H3"),) * 2}
SIDE = {"H1": -6.0, "H2": 6.0, "H3": 0.0}
HIGH = 8.0  # of the block [m]
APART = 36.0  # between two cranes [m]


def random_lift(seed: int) -> str:
    """The scene file of this seed."""
    r = Random(seed)
    n = r.randint(1, 6)
    cranes = [HOOKS[n]] if n <= 3 else list(TWO[n])
    skewed = r.random() < 0.2
    slack = r.uniform(0.05, 0.3) if r.random() < 0.2 else 0.03
    length = 54.0 if len(cranes) == 2 else 28.0
    width = 16.0
    largest = {1: 380.0, 2: 760.0, 3: 840.0}.get(n, 900.0)
    mass = exp(r.uniform(log(50.0), log(largest)))
    both = any("H3" in hooks for hooks in cranes) and any("H1" in hooks for hooks in cranes)
    gap = 10.0  # between the exits of the two trolleys
    rope = exp(r.uniform(log(8.0), log(80.0 - gap * both)))  # the shorter of them
    near, far = (-6.0, 6.0) if both else (0.0, 0.0)
    com = _centre(r, n, both, skewed, length, width)
    lines = [
        "heavylift: 1", f"name: lift-{seed}", "samples: 10 Hz",
        "block:", f"  mass: {mass:.3f} t", f"  size: [{length} m, {width} m, {HIGH} m]",
        f"  at: [0 m, 75 m, {2.0 + HIGH / 2:.3f} m]", f"  com: [{com[0]:.4f} m, {com[1]:.4f} m, {com[2]:.4f} m]",
        "  supports:", "    height: 2 m",
        f"    at: [{', '.join(f'[{x} m, {y} m]' for x in (-length / 2 + 2, length / 2 - 2) for y in (-6.0, 6.0))}]",
        "  lugs:",
    ]  # fmt: skip
    loaders, names = [], ("west", "east")
    middle = [0.0] if len(cranes) == 1 else [-APART / 2, APART / 2]
    sling = r.uniform(6.0, 14.0)
    upper = 2.0 + HIGH + 0.3 + sling + 3.0 + rope - slack + (gap if n == 1 or both else 0.0)
    for name, x, hooks in zip(names, middle, cranes, strict=False):
        for hook in hooks:
            y = near if hook != "H3" else far
            lugs = [f"{name[0].upper()}{hook[1]}{end}" for end in "ab"]
            for lug, side in zip(lugs, (-2.0, 2.0), strict=True):
                lines.append(f"    {lug}: [{x + SIDE[hook] + side} m, {y} m, {HIGH / 2 + 0.3} m]")
            held = f"lugs: [{', '.join(lugs)}], capacity: 900 t"
            loaders.append(f"    {name}-{hook}: {{hook: {name} {hook}, sling: {sling:.4f} m, {held}}}")
    lines.append("cranes:")
    for name, x, _ in zip(names, middle, cranes, strict=False):
        lines += [
            f"  {name}:", "    type: goliath-900", f"    at: {x} m", "    rails: [-200 m, 200 m]",
            f"    upper exit: {upper:.4f} m", f"    lower exit: {upper - gap:.4f} m",
            f"    highest hook: {upper - 2.0:.4f} m", "    shortest rope: 2 m", "    drum: 120 m",
        ]  # fmt: skip
    strong = max(1.0, 1.8 * mass / n / 230.0)  # slings for half as much again as an equal share
    sling_type = f"  sling: {{EA: {445.0 * strong:.1f} MN, breaking: {6.43 * strong:.3f} MN}}"
    lines += ["rig:", f"  slack: {slack * 1e3:.3f} mm", sling_type, "  loaders:", *loaders, "actions:"]
    pick = exp(r.uniform(log(0.5), log(3.0)))
    up, side = r.uniform(1.5, 3.0), r.uniform(4.0, 20.0)
    distance, far_ = r.uniform(0.5, 0.8), side / 60.0 * r.uniform(4.0, 12.0)
    lines += [
        "  - stage: take up slack", f"    all hooks: hoist {pick:.3f} m/min until all slings taut",
        "  - stage: lift off", f"    all hooks: hoist {_lifts(seed, pick)}",
        "  - stage: up", f"    all hooks: hoist {up:.3f} m/min by {distance:.3f} m",
        "  - stage: sideways", f"    trolleys: traverse {side:.3f} m/min by {far_:.3f} m",
    ]  # fmt: skip
    if skewed:
        along = r.uniform(5.0, 30.0)
        lines += [
            "  - stage: along",
            f"    cranes: travel {along:.3f} m/min by {along / 60.0 * r.uniform(4.0, 12.0):.3f} m",
        ]
    return "\n".join([*lines, "  - stage: swing", "    wait: 15 s"]) + "\n"


def awaits_lifting(seed: int) -> bool:
    """Whether the winches stop when the block is seen to be lifted, not after a way."""
    return Random(f"lift-off {seed}").random() >= 1.0 / 3.0


def _lifts(seed: int, pick: float) -> str:
    if awaits_lifting(seed):
        return f"{pick:.3f} m/min until lifted"
    r = Random(f"way {seed}")
    return f"{exp(r.uniform(log(0.5), log(3.0))):.3f} m/min by {r.uniform(0.5, 0.8):.3f} m"


def _centre(r: Random, n: int, both: bool, skewed: bool, length: float, width: float) -> tuple[float, float, float]:
    """A centre of mass that the hooks can hold: off the middle along x where two hooks stand in line, along y where
    both trolleys carry."""
    part = 0.1
    x = r.uniform(-part, part) * min(length, 20.0) if skewed and n > 1 else 0.0
    y = r.uniform(-part, part) * min(width, 10.0) if both else 0.0
    return x, y, r.uniform(-part, part) * HIGH
