"""The scene `turnover` written with plain parts under other names gives the same lift."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.record import Played, boxes, play
from heavylift.nodes.scene import load
from heavylift.nodes.scene.text import expand, read
from heavylift.nodes.scenes import bundled, frames_folder

SCENE = "turnover"
NAMES = {  # that are in the same order
    "east": "ebb", "west": "way", "loader": "hanger", "main": "mid", "gantry": "along", "hinge": "pin",
    "upper": "top", "lower": "low",
}  # fmt: skip


TROLLEYS = {"lower trolleys": ["low-slide"], "trolleys": ["low-slide", "top-slide"]}  # which types call so


def renamed(text: str) -> str:
    return re.sub(r"\b(" + "|".join(NAMES) + r")\b", lambda found: NAMES[found[0]], text)


def plain(text: str, folder: Path) -> Path:
    """The scene of a text with no type of a crane and another type of frame."""
    source = read(text, "scene.yaml")
    actions, rig = source.data["actions"], source.data["rig"]
    assert isinstance(actions, list)
    assert isinstance(rig, dict)
    loaders = {name: {"type": "hanger.yaml", **given} for name, given in dict(rig["loaders"]).items()}
    rig = json.loads(renamed(json.dumps({key: x for key, x in rig.items() if key != "loaders"})))
    rig["loaders"] = json.loads(renamed(json.dumps(loaders)))
    assert expand(source)
    machines = renamed(json.dumps(source.data["machines"]))
    assert "goliath" not in machines
    cranes = [*json.loads(machines)]
    for action in actions:
        for target, slides in TROLLEYS.items():
            if phrase := action.pop(target, None):
                action |= {f"{crane} {slide}.drive": phrase for slide in slides for crane in cranes}
    frame = (frames_folder() / "block-loader.yaml").read_text()
    (folder / "hanger.yaml").write_text(renamed(frame.replace("name: block-loader", "name: hanger")))
    data = {key: source.data[key] for key in ("heavylift", "name", "block")}
    data |= {key: source.data[key] for key in ("samples",) if key in source.data}
    data |= {"machines": json.loads(machines), "rig": rig, "actions": actions}
    (folder / "plain.yaml").write_text(json.dumps(data))
    return folder / "plain.yaml"


def findings(run: Played) -> list[tuple[str, str, float | None]]:
    rows = ((renamed(use.limit.subject), use.limit.quantity, use.value) for use in run.uses)
    return sorted(rows, key=repr)


@pytest.mark.large
def test_renaming_parts_of_machine_types_changes_no_result(tmp_path: Path) -> None:
    old, new = load(SCENE).plan, load(plain(bundled()[SCENE].read_text(), tmp_path)).plan
    one, other = play(old), play(new)
    assert one.times.tolist() == other.times.tolist()
    assert np.array_equal(one.rows, other.rows)
    assert [(t, stage) for t, _, stage in one.conduct.stages] == [(t, stage) for t, _, stage in other.conduct.stages]
    assert findings(one) == findings(other)
    assert [(renamed(x.body), x.centre, x.size, x.colour) for x in boxes(old)] == [
        (x.body, x.centre, x.size, x.colour) for x in boxes(new)
    ]


def test_words_for_crane_types_such_as_goliath_occur_in_one_table_of_the_product_only() -> None:
    """No plan, model, builder or check knows a goliath or a block loader; importlib has loaders of its own."""
    root = Path(__file__).parents[3]
    files = [file for room in ("kernel", "nodes", "recordings", "coordinator") for file in (root / room).rglob("*.py")]
    words = re.compile("goliath|loader", re.I)
    found = {file.relative_to(root).as_posix() for file in files if words.search(file.read_text(encoding="utf-8"))}
    assert found == {"recordings/format/spellings.py", "kernel/description/user_code.py"}
    assert len((root / "recordings/format/spellings.py").read_text(encoding="utf-8").splitlines()) <= 150
