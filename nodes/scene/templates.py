"""Texts of scenes to start from: a copy of a bundled one, or a crane of a type with the blocks of a table."""

from __future__ import annotations

import re
from math import ceil
from pathlib import Path

from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.errors import SceneError
from heavylift.nodes.plan.spellings import BEAM, BEAMS
from heavylift.nodes.scene.keys.parts.kinematics import place, poses
from heavylift.nodes.scene.text.files import scene_file, scene_text
from heavylift.nodes.scene.text.machine_types import machine_type
from heavylift.nodes.scene.text.source import read
from heavylift.nodes.scene.text.table_files import row_names
from heavylift.nodes.scene.text.tables import tabled
from heavylift.nodes.scene.text.units import LENGTH

from .loading import parse

PORTAL_AT, STOOLS, BETWEEN = 60.0, 1.0, 4.0  # [m] x of a portal, height of stools, between the slings of a beam
INSIDE, PADS, STEEP = 0.3, 0.35, 2.0  # of a block's sides: lugs and stools; of a sling over its reach
LUG, SHORT = 0.1, 3.0  # [m] of a lug above the upper face; of a sling
TEXT = """\
# A lift to start from: {crane} picks up {block}. Lugs and stools are assumed; put yours in their place.
# See it: heavylift plot {name}.mcap --lift
heavylift: 1
name: {name}

block:
  from: {table}
  at: [{place}]
  lugs:
{lugs}
  supports: {{height: {stools}, at: [{pads}]}}

ground: {{bearing: 400 kPa}}     # assumed, below tracks and outriggers

cranes:
  crane: {{type: {crane}{at}}}

{rigging}

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
    """The text of a scene of this name that begins as a copy of a bundled one; its recording has that name, too."""
    path = scene_file(like)
    text = re.sub(r"^name: \S+", lambda _: f"name: {name}", scene_text(path, like), count=1, flags=re.M)
    return re.sub(rf"(?<!\S){re.escape(path.stem)}\.mcap\b", lambda _: f"{name}.mcap", text)


def new_scene_with(name: str, crane: str, blocks: str) -> dict[str, str]:
    """Texts of scenes by name: a crane of a type lifts the block of a row, `blocks.csv#B17`, or that of each row."""
    file, _, row = blocks.partition("#")
    rows = [row] if row else row_names(Path(), file)
    names = [name] if len(rows) == 1 else [f"{name}-{row}" for row in rows]
    return {made: _text(made, crane, f"{file}#{row}") for made, row in zip(names, rows, strict=True)}


def _text(name: str, crane: str, table: str) -> str:
    u, v, w = _size(table)
    if "girders" in machine_type(crane).data:
        lugs, (x, y), at = _above(crane, v), (PORTAL_AT, _middle(crane)), f", at: {PORTAL_AT:g} m"
        hung = f"rig:\n  {BEAMS}:\n", f"    {BEAM}-" + "{0}: {{hook: crane {0}, sling: 10 m, lugs: [{1}]}}"
    else:
        hooks, at = _hooks(crane), ""
        x, y = (sum(places) / len(hooks) for places in zip(*hooks.values(), strict=True))
        lugs, length = {hook: [(a - x, b - y)] for hook, (a, b) in hooks.items()}, SHORT
        if len(hooks) == 1:
            lugs = {hook: [(a * INSIDE * u, b * INSIDE * v) for a in (-1, 1) for b in (-1, 1)] for hook in hooks}
            length = max(SHORT, ceil(2.0 * STEEP * norm([INSIDE * u, INSIDE * v])) / 2.0)
        hung = "rigging:\n", f"  legs-{{0}}: {{{{on: crane {{0}}, to: [{{1}}], length: {length:g} m}}}}"
    if any(abs(a) > u / 2 or abs(b) > v / 2 for each in lugs.values() for a, b in each):
        raise SceneError(f"{table}: the hooks of {crane} are further apart than the block is long or wide")
    named = {hook: {f"{hook}-{i}": place for i, place in enumerate(each, 1)} for hook, each in lugs.items()}
    top, pads = w / 2 + LUG, [(a * PADS * u, b * PADS * v) for a in (-1, 1) for b in (-1, 1)]
    return TEXT.format(
        name=name,
        crane=crane,
        block=table.partition("#")[2],
        table=table,
        place=f"{x:.6g} m, {y:.6g} m, {STOOLS + w / 2:.6g} m",
        lugs="\n".join(
            f"    {lug}: [{a:.4g} m, {b:.4g} m, {top:.4g} m]" for each in named.values() for lug, (a, b) in each.items()
        ),
        stools=f"{STOOLS:g} m",
        pads=", ".join(f"[{a:.4g} m, {b:.4g} m]" for a, b in pads),
        at=at,
        rigging=hung[0] + "\n".join(hung[1].format(hook, ", ".join(each)) for hook, each in named.items()),
    )


def _size(table: str) -> tuple[float, float, float]:
    """Length, width, height of the block of a row [m]."""
    source = read(f"block: {{from: '{table}'}}\n", "new")
    source.root = Path()
    tabled(source)
    block = source.data["block"]
    size = block.get("size") if isinstance(block, dict) else None
    if not isinstance(size, list):
        raise SceneError(f"{table}: the row gives no size; add the columns 'size x [m]', 'size y [m]', 'size z [m]'")
    u, v, w = (LENGTH.read(str(side).partition("+-")[0].strip()) for side in size)
    return u, v, w


def _hooks(crane: str) -> dict[str, tuple[float, float]]:
    """Where the hooks of a machine hang at the start, x and y [m]."""
    scene = parse(
        f"heavylift: 1\nname: new\nend: 1 s\ncranes: {{crane: {{type: {crane}}}}}\n", "new.yaml", passing=True
    )
    (machine,) = scene.plan.mechanisms
    at, found = poses(machine.system), {}
    for hook in machine.hooks:
        x, y, _ = place(hook.eye, at)
        found[hook.rope.partition(".")[2]] = (round(float(x), 3), round(float(y), 3))
    return found


def _above(crane: str, width: float) -> dict[str, list[tuple[float, float]]]:
    """Lugs below the hooks of a crane on rails, two for each beam, from the middle of the block [m]."""
    apart = LENGTH.read(str(machine_type(crane).parameters["hook spacing"]))
    places = {"H1": (-apart, -INSIDE * width), "H2": (apart, -INSIDE * width), "H3": (0.0, INSIDE * width)}
    return {hook: [(a - BETWEEN / 2, b), (a + BETWEEN / 2, b)] for hook, (a, b) in places.items()}


def _middle(crane: str) -> float:
    """The middle of its girder, y [m]."""
    girder = machine_type(crane).parameters["girder"]
    assert isinstance(girder, list)
    return sum(LENGTH.read(str(end)) for end in girder) / 2
