"""The recipes of CONTRIBUTING, followed in a copy of the sources: files that each touches, and what then works."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from math import radians, sin
from pathlib import Path

import pytest
from test_a_frame_is_one_file import FOUR, HUNG
from test_a_verb_is_one_row import SCENE as JIB

ROOT = Path(__file__).parents[3]
ROOMS = ("kernel", "nodes", "recordings", "coordinator")
TYPE = ROOT / "tests/data/bending-boom.yaml"
VERBS, STANDARDS = "nodes/plan/verbs.py", "nodes/limits/standards.py"
LAST = '        Verb("begin", ("lift",), "begin"),\n'
TABLE = "STRENGTHS = (  # a limit by another standard is one row\n"
TILT = '''
"""A verb of a block with a meaning of its own: `tilt 10 deg` turns it slowly, and all hooks follow."""

from math import radians

from heavylift.nodes.plan.actions import Turn
from heavylift.nodes.scene.language.phrases import OrderPhrase
from heavylift.nodes.scene.text.units import ANGLE


def phrase(reader):
    return OrderPhrase("tilt", turning=True, to=reader.quantity(ANGLE))


def orders(actors, phrase, where):
    yield from (Turn(block=x.model, rate=radians(0.1), accel=radians(0.02), to=phrase.to, where=where) for x in actors)
'''
ROW = 'Verb("{}", ({!r},), {!r}, units="turning", module={!r}),'
RECIPES = {
    "crane type with a boom that bends": {"nodes/scenes/types/bending-boom.yaml": TYPE.read_text(encoding="utf-8")},
    "type of frame": {"nodes/scenes/frames/four-slings.yaml": FOUR},
    "verb of one actuator": {VERBS: (LAST, ROW.format("swivel", "drive", "move", ""))},
    "verb with a meaning": {
        VERBS: (LAST, ROW.format("tilt", "block", "own", "heavylift.nodes.scene.language.tilt")),
        "nodes/scene/language/tilt.py": TILT,
    },
    "standard": {STANDARDS: (TABLE, '    Strength("hoist rope", "rope peak", 9.0, "a works standard"),')},
}
LIFT = HUNG.replace("type: four.yaml", "type: four-slings")
SINGLE_TURN = (ROOT / "nodes/scenes/single-turn.yaml").read_text(encoding="utf-8")
TURN = SINGLE_TURN.partition("turn 0.18 deg/s")[0] + "tilt 10 deg\n"
BOOM = "heavylift: 1\nname: boom\nend: 6 s\ncranes: {crane: {type: bending-boom}}\n"
USE = """
import json, sys
sys.meta_path = [x for x in sys.meta_path if "editable" not in f"{getattr(x, '__module__', '')}{x}".lower()]
sys.path.insert(0, sys.argv[1])
from heavylift.nodes.models.levels.listing import left_out
from heavylift.nodes.scene import load, parse
lift, boom, jib, turn = map(parse, json.load(sys.stdin))
print(json.dumps({
    "bends": left_out(boom.plan),
    "swivels": jib.statics.states[-1].coordinates["pivot"],
    "slings": sorted(tie.rope for machine in lift.plan.machines for tie in machine.ties),
    "tilted": max(abs(x.poses["block"][1][1][2]) for x in turn.statics.states),
    "sources": sorted({x.source for x in lift.plan.limits if x.quantity == "rope peak"}),
}))
"""


def followed(recipe: dict[str, str | tuple[str, str]], package: Path) -> tuple[set[str], int]:
    """Follow a recipe in a copy; return the files that it touches and the number of their new lines that are rows."""
    rows = 0
    for name, given in recipe.items():
        file, text = package / name, given
        if isinstance(given, tuple):
            before, row = file.read_text(encoding="utf-8"), given[1]
            assert given[0] in before
            text, rows = before.replace(given[0], f"{given[0]}{row}\n"), rows + 1
        file.unlink(missing_ok=True)  # else the file to which it links would be written
        file.write_text(str(text), encoding="utf-8")
    return {*recipe}, rows


def link(source: str, copy: str) -> None:
    os.symlink(source, copy)


def touched(package: Path) -> set[str]:
    files = (file for file in package.rglob("*") if file.is_file() and not file.is_symlink())
    return {str(file.relative_to(package)) for file in files if file.suffix != ".pyc"}


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("copy") / "heavylift"
    for room in ROOMS:
        shutil.copytree(ROOT / room, folder / room, copy_function=link, ignore=shutil.ignore_patterns("node_modules"))
    link(
        str(ROOT / "coordinator/face/__init__.py"), str(folder / "__init__.py")
    )  # a package comes before an installed one
    return folder


def test_each_recipe_for_an_extension_changes_only_the_stated_number_of_files(package: Path) -> None:
    counts = {"verb with a meaning": (2, 1), "verb of one actuator": (1, 1), "standard": (1, 1)}
    seen = touched(package)
    assert not seen
    for name, recipe in RECIPES.items():
        files, rows = followed(recipe, package)
        assert (len(files), rows) == counts.get(name, (1, 0)), name
        seen |= files
        assert touched(package) == seen
    given = json.dumps([LIFT, BOOM, JIB, TURN])
    result = subprocess.run(
        [sys.executable, "-c", USE, str(package.parent)], input=given, capture_output=True, text=True,
        env={**os.environ, "HEAVYLIFT_CACHE": str(package.parent / "cache")},
    )  # fmt: skip
    assert not result.returncode, result.stderr
    found = json.loads(result.stdout)
    assert "elastic parts rigid" in found["bends"]
    assert found["swivels"] == pytest.approx(radians(10.0))
    assert found["slings"] == [f"one.sling-{i}" for i in (1, 2, 3, 4)]
    assert found["tilted"] == pytest.approx(sin(radians(10.0)), abs=1e-2)
    assert "a works standard" in found["sources"]
