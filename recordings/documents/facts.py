"""The data from which the tables of a report are made: a recording with its verdict, plan and peaks.

Also the description of a recorded lift as a table of names and values: block, machines, and how the run was computed.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format import machines
from heavylift.recordings.format.machines import settings
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.verdict import RecordedVerdict, recorded_peaks, recorded_verdict
from heavylift.recordings.write.sink import Peak


@dataclass(frozen=True)
class Facts:
    """Data from which a report is made: a recording, its verdict (if any), and its plan as plain data."""

    rec: Recording
    verdict: RecordedVerdict | None
    plan: dict[str, Any] = field(repr=False)

    @cached_property
    def peaks(self) -> dict[str, Peak]:
        """Recorded peak tension of each rope; the parts of ropes over sheaves are omitted."""
        return {name: peak for name, peak in recorded_peaks(self.rec).items() if "~" not in name}

    @cached_property
    def stages(self) -> list[tuple[float, str]]:
        """The begin [s] and the name of each stage of the run."""
        return [*self.rec.stages()]

    def stage_at(self, t: float) -> str:
        """Return the name of the stage of the run at a time [s]."""
        return next((name for at, name in reversed(self.stages) if at <= t), "")


def facts(rec: Recording, verdict: RecordedVerdict | None = None) -> Facts:
    """Return the data from which a report is made; raises RecordingError for a recording of a DEVS model.

    `verdict`: used if the recording contains no verdict.
    """
    with rec.reading():
        if "model" in rec.run:
            raise RecordingError(
                f"{rec.path}: a run of a DEVS model has no lift report; `heavylift info` prints its results"
            )
        return Facts(rec, verdict or recorded_verdict(rec), machines.plan_of(rec.attachments))


COMPUTED = ("samples_hz", "seed")


def scene_table(rec: Recording, plan: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the rows of the table that describes the recorded scene, as names and values."""
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
    """Return the properties of the block as rows (name, one or three numbers, unit); u, v, w are its axes."""
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
