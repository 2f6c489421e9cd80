"""What was lifted, with what, and how it was computed: the scene of a recording as a table of names and values."""

from __future__ import annotations

from typing import Any

from heavylift.recordings.format.settings import settings
from heavylift.recordings.read.reader import Recording

COMPUTED = ("samples_hz", "seed")


def scene_table(rec: Recording, plan: dict[str, Any]) -> list[tuple[str, str]]:
    """Rows of the table."""
    rows: list[tuple[str, str]] = [("scene", rec.run.get("scene", rec.path.stem))]
    block = plan.get("block")
    if block:
        x, y, z = block["pose"][:3]
        told = f"{block['body']['mass'] / 1e3:g} t, centre at {x:g}, {y:g}, {z:.3g} m, {len(block['lugs'])} lugs"
        rows.append((f"block {block.get('name', '')}".strip(), told))
    tandem: dict[str, float] = rec.fact("tandem", {})
    for crane in plan.get("cranes", []):
        share = tandem.get(crane["name"], 1.0)
        told = (
            f"at {crane['gantry']['start']:g} m, carries {crane['capacity'] / 1e3:g} t on {len(crane['hooks'])} hooks"
        )
        if share < 1.0:
            told += f" ({100 * share:g} % of {crane['capacity'] / share / 1e3:g} t, as cranes lift together)"
        rows.append((f"crane {crane['name']}", told))
    slings = plan.get("rig", {}).get("slings", [])
    if slings:
        hooked = sum(1 for s in slings if s["lug"])
        rows.append(
            ("rig", f"{len(plan['loaders'])} block loaders, {len(slings)} slings, {hooked} hooked at the start")
        )
    for mechanism in plan.get("mechanisms", []):
        system = mechanism["system"]
        told = f"{len(system['bodies'])} bodies, {len(system['joints'])} joints"
        rows.append((f"mechanism {mechanism['name']}", told))
    if plan:
        rows.append(("gravity", f"{plan.get('gravity', 9.80665):g} m/s2"))
    rows += settings(rec.run).items()
    fidelity = rec.fact("fidelity", {})
    if plan.get("block") and isinstance(fidelity, dict):
        rows.append(("fidelity", ", ".join(f"{k.replace('_', ' ')} {_told(v)}" for k, v in fidelity.items())))
    return rows + [(name.replace("_", " "), rec.run[name]) for name in COMPUTED if name in rec.run]


def block_table(plan: dict[str, Any]) -> list[tuple[str, str]]:
    """The block's data: mass, size, centre of mass, inertia, where it stands, its lugs; u, v, w are its own axes."""
    block = plan.get("block")
    if not block:
        return []
    body = block["body"]
    x, y, z = block["pose"][:3]
    rows = [
        ("mass", f"{body['mass'] / 1e3:g} t"),
        ("weight", f"{body['mass'] * plan.get('gravity', 9.80665) / 1e3:.0f} kN"),
    ]
    if any(size := block.get("size", ())):
        rows += [("size along u, v, w", " x ".join(f"{length:g}" for length in size) + " m")]
    rows += [
        ("centre of gravity at u, v, w", ", ".join(f"{length:g}" for length in body.get("com", (0.0, 0.0, 0.0))) + " m")
    ]
    told = ", ".join(f"{moment / 1e3:.0f}" if moment >= 1e6 else f"{moment / 1e3:.3g}" for moment in body["moments"])
    rows += [("moments of inertia about it", f"{told} t m2")]
    rows += [("begins at x, y, z", f"{x:g}, {y:g}, {z:.4g} m")]
    return [*rows, ("lugs", f"{len(block['lugs'])}"), ("stools", f"{len(block['pads'])} places")]


def _told(value: object) -> str:
    return ", ".join(map(str, value)) or "none" if isinstance(value, list) else str(value)
