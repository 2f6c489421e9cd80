"""Random lifts by one to three cranes of any bundled types: one block or several, each hook with a frame or slings."""

from __future__ import annotations

import re
from dataclasses import dataclass
from random import Random

Y = 76.0  # of the first hook of each crane [m]
APART = 60.0  # of cranes along x [m]
HIGH = 2.0  # of a block [m]
LOWER = 14.0  # by which a second trolley is behind the first [m]
FRAME, BAR = {"block-loader": 20.0, "bar": 2.0}, 1.0  # masses [t]; half the length of a bar [m]
TYPES = f"""types:
  bar:
    frame type: 1
    name: bar
    eye: {{body: bar, apart: 2 m}}
    slings: [{{body: bar, at: [{-BAR} m, 0 m, -1 m]}}, {{body: bar, at: [{BAR} m, 0 m, -1 m]}}]
    bodies: {{bar: {{mass: 2 t, com: [0 m, 0 m, -0.5 m], box: [3 m, 0.5 m, 1 m]}}}}
"""
RAILS = "at: {x} m, rails: [-300 m, 300 m], upper trolley: {y} m, lower trolley: {low} m"
TWIN = "at: {x} m, span: 150 m, girder: [6 m, 144 m], rails: [-300 m, 300 m], upper: {y} m, lower: {low} m"
HALL = "at: {x} m, span: 200 m, trolley: {y} m, reach: [2 m, 198 m], runway: [-300 m, 300 m]"
Places = dict[str, tuple[float, float]]


def _three(apart: float) -> Places:
    return {"H1": (-apart, 0.0), "H2": (apart, 0.0), "H3": (0.0, -LOWER)}


def _jib(radius: float) -> tuple[str, Places]:
    return f"at: [{{x}} m, {{y}} m, 0 m], radius: {radius} m", {"main": (radius, 0.0)}


CORNERS = {f"{a}-{b}": (x, y) for a, x in (("front", 8.0), ("rear", -8.0)) for b, y in (("left", 4.0), ("right", -4.0))}
CRANES: dict[str, tuple[str, Places, float]] = {  # parameters, hooks about the crane, what each can lift [t]
    "crawler-250": (*_jib(12.0), 24.0),
    "jib-60": (*_jib(20.0), 12.0),
    "pedestal-400": (*_jib(30.0), 36.0),
    "rough-terrain-59": (*_jib(6.0), 3.0),
    "mobile-gantry-600": ("at: [{x} m, {y} m, 0 m]", CORNERS, 24.0),
    "overhead-100": (HALL, {"main": (0.0, 0.0)}, 36.0),
    "twin-hook-600": (TWIN, _three(6.0), 70.0),
    "goliath-840": (RAILS, _three(6.0), 120.0),
    "goliath-900": (RAILS, _three(6.0), 120.0),
    "goliath-1200": (RAILS, _three(7.0), 120.0),
    "goliath-1600": (RAILS, _three(8.0), 120.0),
}


@dataclass(frozen=True)
class Mix:
    """A scene; masses of its blocks and frames [t]; its hooks, those with a frame."""

    text: str
    mass: float
    hooks: frozenset[str]
    framed: frozenset[str]


@dataclass(frozen=True)
class _Hook:
    crane: str
    name: str
    x: float
    y: float
    most: float


def random_mix(seed: int) -> Mix:
    """The scene of this seed."""
    r = Random(f"mix {seed}")
    kinds = [r.choice([*CRANES]) for _ in range(r.choice((1, 2, 2, 3)))]
    cranes, hooks, lines = [], list[_Hook](), ["heavylift: 1", f"name: mix-{seed}"]
    for i, kind in enumerate(kinds):
        given, places, most = CRANES[kind]
        cranes.append(f"  c{i}: {{type: {kind}, {given.format(x=i * APART, y=Y, low=Y - LOWER)}}}")
        used = r.sample(sorted(places), r.randint(1, len(places)))
        hooks += [_Hook(f"c{i}", x, i * APART + places[x][0], Y + places[x][1], most) for x in used]
    groups = list[list[_Hook]]()
    for hook in sorted(hooks, key=lambda x: (x.x, x.y)):
        if groups and r.random() < 0.5:
            groups[-1].append(hook)
        else:
            groups.append([hook])
    blocks, frames, slings, total, framed = [], [], [], 0.0, set[str]()
    low = "mobile-gantry-600" in kinds  # below which no block loader has room
    for b, group in enumerate(groups):
        cx, cy = (sum(x) / len(group) for x in ([h.x for h in group], [h.y for h in group]))
        long, wide = (2 * max(map(abs, x)) + 6 for x in ([h.x - cx for h in group], [h.y - cy for h in group]))
        mass = len(group) * min(h.most for h in group) * r.uniform(0.2, 0.9)
        lugs, total = [], total + mass
        for j, hook in enumerate(group):
            hold, where = r.choice(("bar", "slings", "slings" if low else "block-loader")), f"{hook.crane} {hook.name}"
            half = 2.0 if hold == "block-loader" else BAR
            ends = ((f"P{j}", -half), (f"Q{j}", half))
            lugs += [f"{lug}: [{hook.x - cx + d} m, {hook.y - cy} m, {HIGH / 2 + 0.3} m]" for lug, d in ends]
            to = ", ".join(f"b{b}.{lug}" for lug, _ in ends)
            if hold == "slings":
                slings.append(f"  s{b}{j}: {{on: {where}, to: [{to}], length: 4 m, slack: 0.05 m}}")
            else:
                frames.append(f"    f{b}{j}: {{type: {hold}, hook: {where}, sling: 4 m, lugs: [{to}]}}")
                total, framed = total + FRAME[hold], framed | {where.replace(" ", ".")}
        corners = ", ".join(f"[{x * (long / 2 - 1)} m, {y * (wide / 2 - 1)} m]" for x in (-1, 1) for y in (-1, 1))
        blocks.append(
            f"  b{b}: {{mass: {mass} t, size: [{long} m, {wide} m, {HIGH} m], at: [{cx} m, {cy} m, {1 + HIGH / 2} m], "
            f"lugs: {{{', '.join(lugs)}}}, supports: {{height: 1 m, at: [{corners}]}}}}"
        )
    lines += ["blocks:", *blocks, "cranes:", *cranes]
    lines += ["rig:", "  slack: 0.05 m", "  loaders:", *frames] if frames else []
    lines += ["rigging:", *slings] if slings else []

    def each(order: str) -> str:
        return "  - " + "\n    ".join(
            f"{h.crane} {h.name}: {order.format(b=b)}" for b, g in enumerate(groups) for h in g
        )

    actions = [each("hoist 0.3 m/min until all slings taut"), each("hoist 0.3 m/min until b{b} lifted")]
    actions.append(f"  - stage: up\n{each('hoist 1 m/min by 0.5 m').replace('  - ', '    ', 1)}")
    names = frozenset(f"{h.crane}.{h.name}" for h in hooks)
    return Mix("\n".join([*lines, "actions:", *actions, TYPES]), total, names, frozenset(framed))


def reversed_entries(text: str) -> str:
    """The scene with the entries of each of its sections but the action list in reverse order."""
    sections = [(head, body.splitlines()) for head, body in re.findall(r"^(\S.*)\n((?: .*\n)*)", text, re.M)]
    out = []
    for head, body in sections:
        if head in ("blocks:", "cranes:", "rigging:"):
            body = body[::-1]
        elif head == "rig:":
            body = [*body[:2], *body[:1:-1]]
        out.append("".join(f"{line}\n" for line in (head, *body)))
    return "".join(out)


NAMES = {"c": "zeta", "b": "alpha", "f": "omega", "s": "mu"}


def renamed(text: str) -> str:
    """The scene with other names of cranes, blocks, frames and slings, which sort otherwise."""
    return re.sub(r"\b([cbfs])(\d+)\b", lambda x: f"{NAMES[x[1]]}{x[2]}", text)


def back(name: str) -> str:
    """The name of a subject before `renamed`."""
    return re.sub(r"\b(zeta|alpha|omega|mu)(\d+)\b", lambda x: {v: k for k, v in NAMES.items()}[x[1]] + x[2], name)
