"""What was lifted, with what, and how it was computed: the scene of a recording as a table of names and values."""

from __future__ import annotations

from typing import Any

from heavylift.recordings.format import machines
from heavylift.recordings.format.machines import settings
from heavylift.recordings.read.reader import Recording

COMPUTED = ("samples_hz", "seed")


def scene_table(rec: Recording, plan: dict[str, Any]) -> list[tuple[str, str]]:
    """Rows of the table."""
    rows: list[tuple[str, str]] = [("scene", rec.run.get("scene", rec.path.stem))]
    if message := machines.unread(plan):
        rows.append(("plan", message))
    block = machines.block(plan)
    if block:
        x, y, z = block["pose"][:3]
        message = f"{block['mass'] / 1e3:g} t, centre at {x:g}, {y:g}, {z:.3g} m, {len(block.get('lugs', ()))} lugs"
        rows.append(("block" if block["body"] == "block" else f"block {block['body']}", message))
    machined, slings = machines.cranes(plan), machines.ties(plan)
    cranes = [crane.name for crane in machined]
    rows += [("cranes", ", ".join(cranes))] if cranes else []
    for crane in machined:
        if crane.configuration:
            rows.append((f"set-up of {crane.name}", ", ".join(f"{k} {x}" for k, x in crane.configuration.items())))
    if slings:
        hooked = sum(1 for tie in slings if tie.get("lug"))
        rows.append(("rig", f"{len(slings)} slings, {hooked} hooked at the start"))
    named = {*cranes, block.get("name", "")}
    for machine in (x for x in plan.get("machines", []) if x["name"] not in named and not x.get("ties")):
        system = machine["system"]
        message = f"{len(system['bodies'])} bodies, {len(system['joints'])} joints"
        rows.append((f"mechanism {machine['name']}", message))
    if plan:
        rows.append(("gravity", f"{plan.get('gravity', 9.80665):g} m/s2"))
    rows += settings(rec.run).items()
    fidelity = rec.fact("fidelity", {})
    if any(x.get("hooks") for x in plan.get("machines", [])) and isinstance(fidelity, dict):
        rows.append(("fidelity", ", ".join(f"{k.replace('_', ' ')} {_described(v)}" for k, v in fidelity.items())))
    return rows + [(name.replace("_", " "), rec.run[name]) for name in COMPUTED if name in rec.run]


def block_rows(plan: dict[str, Any]) -> list[tuple[str, list[float], str]]:
    """Data of the block: name, one or three numbers, unit; u, v, w are its axes."""
    block = machines.block(plan)
    if not block:
        return []
    rows = [
        ("mass", [block["mass"] / 1e3], "t"),
        ("weight", [block["mass"] * plan.get("gravity", 9.80665) / 1e3], "kN"),
        ("size along u, v, w", [*block.get("size", ())], "m"),
        ("centre of gravity at u, v, w", [*block.get("com", (0.0, 0.0, 0.0))], "m"),
        ("moments of inertia about it", [x / 1e3 for x in block.get("moments", (0.0, 0.0, 0.0))], "t m2"),
        ("begins at x, y, z", [*block["pose"][:3]], "m"),
    ]
    return [row for row in rows if any(row[1]) or row[0].startswith("centre")]


def _described(value: object) -> str:
    return ", ".join(map(str, value)) or "none" if isinstance(value, list) else str(value)
