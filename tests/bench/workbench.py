"""Waiting times of a planner beside the workbench, from a save in any editor to the messages drawn by its page.

    python tests/bench/workbench.py [--json] [--short]

A copy of `turnover` is open; each save changes the mass, so nothing of it is known yet, while compiled code is
warm.  Least of several, as other work on the machine only ever adds; no peer does this.
"""

import tempfile
import time
from collections import defaultdict
from pathlib import Path

import msgspec
from heavylift.coordinator.workbench import OpenScene, version_of
from heavylift.nodes.scene import bundled
from shared.rows import SHORT, options, row

SCENE, TONS, TIMES = ("lift", 300, 2) if SHORT else ("turnover", 900, 5)
PICTURE_s, FAULT_s, CHECKS_s = 0.5, 0.5, 2.0
PATIENCE_s = 60.0
KINDS = {"start": "start pose and drawings", "path": "path at rest", "checks": "checks"}


def saved(opened: OpenScene, text: str, *wanted: str) -> dict[str, float]:
    """Seconds from a save until each of these messages of the text is there."""
    assert opened.scene is not None
    found, began = dict[str, float](), time.perf_counter()
    opened.scene.write_text(text)
    while wanted != tuple(kind for kind in wanted if kind in found):
        for message in opened.since(0):
            data = msgspec.json.decode(message.data)
            kind = data.get("what", message.kind)
            if data.get("version") == version_of(text) and (kind != "faults" or data["faults"]):
                found.setdefault(kind, time.perf_counter() - began)
        assert time.perf_counter() - began < PATIENCE_s, found
        time.sleep(0.002)
    return found


def main() -> None:
    options(__doc__ or "")
    waits: dict[str, list[float]] = defaultdict(list)
    with tempfile.TemporaryDirectory() as name:
        path, text = Path(name) / "scene.yaml", bundled()[SCENE].read_text()
        path.write_text(text)
        with OpenScene(path.parent, path) as opened:
            time.sleep(0.5)  # until the folder is watched
            for number in range(TIMES + 1):
                changed = text.replace(f"mass: {TONS} t", f"mass: {TONS - 1 - number} t")
                for kind, seconds in saved(opened, changed, "start", "path", "checks").items():
                    waits[kind].append(seconds)
                waits["fault"].append(saved(opened, changed.replace(" t\n", " x\n", 1), "faults")["faults"])
    for kind, what in KINDS.items():
        row(f"{SCENE}, save to {what}", min(waits[kind][1:]), "s", at_most=PICTURE_s if kind == "start" else CHECKS_s)
    row(f"{SCENE}, save to faults", min(waits["fault"][1:]), "s", at_most=FAULT_s)


if __name__ == "__main__":
    main()
