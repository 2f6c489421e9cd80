"""Texts of new scenes: a copy of a bundled scene, or a crane of some type with the blocks in a table."""

import re
from math import ceil
from pathlib import Path
from typing import Any, NamedTuple

from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.errors import SceneError
from heavylift.nodes.scene.keys.parts.kinematics import place, poses
from heavylift.nodes.scene.text.files import scene_file, scene_text
from heavylift.nodes.scene.text.machine_types import machine_type
from heavylift.nodes.scene.text.source import read
from heavylift.nodes.scene.text.table_files import row_names
from heavylift.nodes.scene.text.tables import tabled
from heavylift.nodes.scene.text.units import LENGTH, MASS
from heavylift.recordings.format.spellings import BEAM, BEAMS

from .loading import parse

PORTAL_AT, SUPPORTS, BETWEEN = 60.0, 1.0, 4.0  # [m] x of a portal, height of supports, between the slings of a beam
INSIDE, PADS, STEEP = 0.3, 0.35, 2.0  # of a block's sides: lugs and supports; of a sling over its reach
LUG, SHORT = 0.1, 3.0  # [m] of a lug above the upper face; of a sling
G = 9.80665
LEG = 0.29  # of the load, on one of four legs at rest
ROPES = (*range(16, 30, 2), *range(32, 64, 4), *range(72, 156, 12))  # [mm] 6x36 IWRC 1770, in thimbles up to 60 mm
THIMBLES = 60
PROJECT = "# project: {name: ..., number: ..., author: ...}  # head of the report"
SHACKLES = {2.0: 0.36, 3.25: 0.72, 4.75: 1.23, 6.5: 1.79, 8.5: 2.57, 9.5: 3.75, 12.0: 5.31, 13.5: 7.18, 17.0: 9.43,
            25.0: 15.4, 35.0: 23.7, 55.0: 44.6, 85.0: 70.0, 120.0: 110.0, 150.0: 160.0, 200.0: 235.0,
            300.0: 340.0}  # fmt: skip  # [t] of makers' catalogues, with their masses [kg]
MORE = {"rope": 8.5, "shackle": 1.7, "lug": 2.3, "support": 2.0}  # over the share at rest: factors of design loads
ASSEMBLY = (
    10.6  # likewise, of a leg of four: three carry by EN 13414-1, with contingencies of weight and centre of mass
)
TEXT = """\
# A lift to start from: {crane} picks up {block}. Lugs, supports, gear, factors and limits are chosen to begin with; put
# yours in their place.
# See it: heavylift plot {name}.mcap --lift
heavylift: 1
name: {name}

block:
  from: {table}
  at: [{place}]
  lug capacity: {lug} t
  lugs:
{lugs}
  supports: {{height: {supports}, at: [{pads}], capacity: {support} t}}

ground: {{bearing: 400 kPa{mats}}}     # below tracks and outriggers

cranes:
  crane: {{type: {crane}{at}}}

{rigging}

gear:
  WR-{rope}:
    {{kind: sling, EA: {EA:.3g} MN, breaking: {breaking:.4g} kN, diameter: {rope} mm, termination: {end}, {mass}}}
  SH-{WLL:g}: {{kind: shackle, WLL: {WLL:g} t, standard: {standard}, mass: {shackle:g} kg}}

practice: 0027/ND              # factors from loads at rest to design loads
factors:
  {{weight: 1.03, cog: [{box}], tilt: 3 deg, heights: 1.05, dynamics: included, wind: 8 m/s, area: {area:.3g} m2}}
limits: {{clearance: 0.5 m, off-lead: 3 deg, touch: 2 m/min, impact: 1.5}}

actions:
  - stage: take up slack
    all hooks: hoist 0.3 m/min until all slings taut
  - stage: lift off
    all hooks: hoist 0.3 m/min until lifted
  - stage: up
    all hooks: hoist 1 m/min by 1 m
  - stage: down
    all hooks: lower 1 m/min by 0.8 m
  - stage: set down
    all hooks: lower 0.3 m/min until landed and all slings slack
"""


def new_scene(name: str, like: str) -> str:
    """Return the text of a new scene, which is a copy of a bundled scene under a new name.

    The name of its recording follows from the new name."""
    path = scene_file(like)
    text = re.sub(r"^name: \S+", lambda _: f"name: {name}", scene_text(path, like), count=1, flags=re.M)
    text = re.sub(r"^project:.*", PROJECT, text, flags=re.M)  # it names the other lift
    return re.sub(rf"(?<!\S){re.escape(path.stem)}\.mcap\b", lambda _: f"{name}.mcap", text)


def new_scene_with(name: str, crane: str, blocks: str) -> dict[str, str]:
    """Return the texts of new scenes by name, in which a crane lifts a block from a table (`blocks.csv#B17`).

    There is one scene for the named row, or one for each row of the table."""
    file, _, row = blocks.partition("#")
    rows = [row] if row else row_names(Path(), file)
    names = [name] if len(rows) == 1 else [f"{name}-{row}" for row in rows]
    return {made: _text(made, crane, f"{file}#{row}") for made, row in zip(names, rows, strict=True)}


class ChosenGear(NamedTuple):
    """Slings, shackles, lugs and supports chosen for a lift, as they are written in the scene."""

    rope: int
    EA: float
    breaking: float
    end: str
    mass: str
    WLL: float
    shackle: float
    standard: str
    lug: int
    support: int


def _gear(mass: float, share: float, length: float) -> ChosenGear:
    """Choose the gear for a block of a mass [t] of which one sling, of a length [m], carries a share at rest."""
    leg, more = mass * share, ASSEMBLY if share == LEG else MORE["rope"]
    rope = next((d for d in ROPES if 0.356e-3 * d * d * 1770.0 >= more * leg * G), ROPES[-1])
    WLL = next((x for x in SHACKLES if x >= MORE["shackle"] * leg), max(SHACKLES))
    return ChosenGear(
        rope, 0.0483 * rope * rope, 0.356e-3 * rope * rope * 1770.0, "ferrule" if rope <= THIMBLES else "resin",
        f"mass: {0.00409 * rope * rope * length:.3g} kg", WLL, SHACKLES[WLL], "EN 13889" if WLL <= 25.0 else "RR-C-271",
        ceil(MORE["lug"] * leg), ceil(MORE["support"] * mass / 4.0),
    )  # fmt: skip


def _text(name: str, crane: str, table: str) -> str:
    (u, v, w), mass = _block(table)
    elastic: Any = machine_type(crane).data.get("elastic") or {}
    if any("span" in x for x in elastic.values()):
        lugs, (x, y), at = _above(crane, v), (PORTAL_AT, _middle(crane)), f", at: {PORTAL_AT:g} m"
        length, share = 10.0, 0.25
        own = "hook: crane {0}, sling: 10 m, lugs: [{1}], capacity: 300 t"
        hung = f"rig:\n{{0}}  {BEAMS}:\n", f"    {BEAM}-{{0}}: {{{{{own}}}}}"
    else:
        hooks, at = _hooks(crane), ""
        x, y = (sum(places) / len(hooks) for places in zip(*hooks.values(), strict=True))
        lugs, length, share = {hook: [(a - x, b - y)] for hook, (a, b) in hooks.items()}, SHORT, 1.0 / len(hooks)
        if len(hooks) == 1:
            lugs = {hook: [(a * INSIDE * u, b * INSIDE * v) for a in (-1, 1) for b in (-1, 1)] for hook in hooks}
            length, share = max(SHORT, ceil(2.0 * STEEP * norm([INSIDE * u, INSIDE * v])) / 2.0), LEG
        hung = "rigging:\n", f"  legs-{{0}}: {{{{on: crane {{0}}, to: [{{1}}], length: {length:g} m, {{2}}}}}}"
    if any(abs(a) > u / 2 or abs(b) > v / 2 for each in lugs.values() for a, b in each):
        raise SceneError(
            f"{table}: the hooks of {crane} are further apart than the block is long or wide; choose another crane"
        )
    named = {hook: {f"{hook}-{i}": place for i, place in enumerate(each, 1)} for hook, each in lugs.items()}
    top, pads = w / 2 + LUG, [(a * PADS * u, b * PADS * v) for a in (-1, 1) for b in (-1, 1)]
    gear, stands = _gear(mass, share, length), str(machine_type(crane).data.get("stands"))
    pins = f", pin: {3 * gear.rope} mm" if gear.end == "ferrule" else ""
    held = f"sling: {{gear: WR-{gear.rope}{pins}}}", f"shackle: {{gear: SH-{gear.WLL:g}}}"
    return TEXT.format(
        **gear._asdict(),
        mats=", mats: {crane: {area: 1.5 m2, mass: 600 kg}}" if "outriggers" in stands else "",
        box=", ".join(f"{0.02 * side:.2g} m" for side in (u, v)) + ", 0 m",
        area=max(u, v) * w,
        name=name,
        crane=crane,
        block=table.partition("#")[2],
        table=table,
        place=f"{x:.6g} m, {y:.6g} m, {SUPPORTS + w / 2:.6g} m",
        lugs="\n".join(
            f"    {lug}: [{a:.4g} m, {b:.4g} m, {top:.4g} m]" for each in named.values() for lug, (a, b) in each.items()
        ),
        supports=f"{SUPPORTS:g} m",
        pads=", ".join(f"[{a:.4g} m, {b:.4g} m]" for a, b in pads),
        at=at,
        rigging=hung[0].format("".join(f"  {line}\n" for line in held))
        + "\n".join(hung[1].format(hook, ", ".join(each), ", ".join(held)) for hook, each in named.items()),
    )


def _block(table: str) -> tuple[tuple[float, float, float], float]:
    """Return length, width, height [m] and mass [t] of the block in a row of a table."""
    source = read(f"block: {{from: '{table}'}}\n", "new")
    source.root = Path()
    tabled(source)
    block = source.data["block"]
    size = block.get("size") if isinstance(block, dict) else None
    if not isinstance(size, list):
        raise SceneError(f"{table}: the row gives no size; add the columns 'size x [m]', 'size y [m]', 'size z [m]'")
    u, v, w = (LENGTH.read(str(side).partition("+-")[0].strip()) for side in size)
    assert isinstance(block, dict)
    mass = MASS.read(str(block["mass"]).partition("+-")[0].strip()) if "mass" in block else 0.0
    return (u, v, w), mass / 1e3


def _hooks(crane: str) -> dict[str, tuple[float, float]]:
    """Return the horizontal positions x, y of the hooks at the start [m]."""
    scene = parse(
        f"heavylift: 1\nname: new\nend: 1 s\ncranes: {{crane: {{type: {crane}}}}}\n", "new.yaml", passing=True
    )
    (machine,) = scene.plan.machines
    at, found = poses(machine.system), {}
    for hook in machine.hooks:
        x, y, _ = place(hook.eye, at)
        found[hook.rope.partition(".")[2]] = (round(float(x), 3), round(float(y), 3))
    return found


def _above(crane: str, width: float) -> dict[str, list[tuple[float, float]]]:
    """Return the positions [m], relative to the middle of the block, of lugs below the hooks of a rail crane, two for
    each beam."""
    apart = LENGTH.read(str(machine_type(crane).parameters["hook spacing"]))
    places = {"H1": (-apart, -INSIDE * width), "H2": (apart, -INSIDE * width), "H3": (0.0, INSIDE * width)}
    return {hook: [(a - BETWEEN / 2, b), (a + BETWEEN / 2, b)] for hook, (a, b) in places.items()}


def _middle(crane: str) -> float:
    """Return the coordinate y of the middle of the girder [m]."""
    girder = machine_type(crane).parameters["girder"]
    assert isinstance(girder, list)
    return sum(LENGTH.read(str(end)) for end in girder) / 2
