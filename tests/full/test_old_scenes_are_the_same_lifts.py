"""Random lifts by goliaths and lifting beams give equal systems in this version, in former ones, and in plain parts.

The former versions are read from the repository's own history; without it, as in an sdist, they are skipped.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tarfile
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "nodes/fidelity"))
sys.path.insert(0, str(Path(__file__).parents[1] / "nodes/scene"))

from heavylift.coordinator.ladder import at_level
from heavylift.coordinator.record import play
from heavylift.kernel import SceneError
from heavylift.nodes.models import system
from heavylift.nodes.plan import Fidelity
from heavylift.nodes.scene import load, parse
from random_lifts import random_lift
from test_names_of_parts_mean_nothing import findings, plain, renamed

ROOT = Path(__file__).parents[2]
LIFTS = range(200)
PLAYED = range(0, 200, 20)
LEVELS = (
    Fidelity(girder="elastic", rope_mass="lumped"),
    Fidelity(ropes="massive", lumps=2, girder="elastic"),
    Fidelity(ropes="rigid", slings="rigid"),
    Fidelity(motion="across", pads="standing"),
)
FORMER = ("12b8f9b5", "ae8cf4df")  # release 0.2.0; the last version with a plan and models for goliaths alone
SAME = 1e-9  # relative: of what is found at rest
LUMPED = 1e-9  # relative: where lumps of ropes are was rounded to ten digits
SYSTEMS = """
import json, sys
import msgspec
sys.meta_path = [x for x in sys.meta_path if "editable" not in f"{getattr(x, '__module__', '')}{x}".lower()]
sys.path.insert(0, sys.argv[1])
from heavylift.kernel.errors import SceneError
from heavylift.nodes.models import system
from heavylift.nodes.scene import load, parse
for text, settings in json.load(sys.stdin):
    try:
        print(msgspec.json.encode(system(parse(text, "lift.yaml", settings, passing=True).plan)).decode())
    except SceneError:  # which a level refuses
        print("null")
"""


CHECKED = """
import json, sys
from pathlib import Path
if len(sys.argv) > 2:
    sys.meta_path = [x for x in sys.meta_path if "editable" not in f"{getattr(x, '__module__', '')}{x}".lower()]
    sys.path.insert(0, sys.argv[2])
from heavylift.nodes.scene import load
for file in sorted(Path(sys.argv[1]).glob("*.yaml")):
    scene = load(str(file))
    found = [(x.limit.subject, x.limit.quantity, x.value) for x in scene.uses if x.value is not None]
    checks = scene.checks if hasattr(scene, "checks") else scene.findings
    red = {x.subject for x in checks if getattr(x, "state", getattr(x, "severity", "")) == "red"}
    print(json.dumps([file.stem, found, sorted(red)]))
"""
TURNED = {  # bundled scenes of that version that were not red
    "edge": {"crane.H1", "crane.H2"},  # off-lead
    "floating": {"block"},  # speeds at lift-off and landing
}


def levels(seed: int) -> list[Fidelity]:
    return [Fidelity(), LEVELS[seed % len(LEVELS)]]


def setting(level: Fidelity) -> list[str]:
    """A level as a setting of a scene."""
    given = {f.replace("_", " "): getattr(level, f) for f in ("ropes", "lumps", "rope_mass", "slings", "girder")}
    words = {**given, "motion": level.motion, "pads": level.pads}
    return [] if level == Fidelity() else [f"fidelity={json.dumps(words)}"]


def different(old: Any, new: Any, at: str = "", *, rounded: bool = False) -> Iterator[str]:
    """Yield the differences of two descriptions; elements with names are compared by these, new fields ignored.
    `rounded`: parts of ropes with lumps may differ in the last digits, and in their damping, which was too much."""
    if isinstance(old, dict) and isinstance(new, dict):
        for key in old:
            yield from different(old[key], new.get(key), f"{at}.{key}", rounded=rounded)
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        if old and isinstance(old[0], dict) and "name" in old[0]:
            old, new = (sorted(x, key=lambda each: str(each["name"])) for x in (old, new))
        for i, (a, b) in enumerate(zip(old, new, strict=True)):
            name = a["name"] if isinstance(a, dict) and "name" in a else i
            yield from different(a, b, f"{at}[{name}]", rounded=rounded)
    elif old != new:
        near = isinstance(old, float) and isinstance(new, float) and new == pytest.approx(old, rel=LUMPED, abs=1e-9)
        chain = rounded and ("lump-" in at or at.startswith(".ropes"))
        if not (chain and (near or at.endswith(".damping"))):
            yield f"{at}: {old} was {new}"


def archive_of(version: str, folder: Path) -> None:
    """Unpack a former version of the package; skip the test without the history."""
    git = subprocess.run(["git", "archive", version], cwd=ROOT, capture_output=True)
    if git.returncode:
        pytest.skip(f"there is no {version} here: {git.stderr.decode().strip()}")
    with tarfile.open(fileobj=BytesIO(git.stdout)) as archive:
        archive.extractall(folder / "heavylift", filter="data")


@pytest.mark.parametrize("version", FORMER)
def test_scenes_of_former_versions_give_the_systems_of_those_versions(version: str, tmp_path: Path) -> None:
    archive_of(version, tmp_path)
    asked = [(random_lift(seed), level) for seed in LIFTS for level in levels(seed)]
    given = json.dumps([(text, setting(level)) for text, level in asked])
    command = [sys.executable, "-c", SYSTEMS, str(tmp_path)]
    former = subprocess.run(command, input=given, capture_output=True, text=True, check=True).stdout.splitlines()
    assert len(former) == len(asked)
    for line, (text, level) in zip(former, asked, strict=True):
        try:
            own = system(parse(text, "lift.yaml", setting(level), passing=True).plan)
        except SceneError:
            assert line == "null", (text, level)
            continue
        found = list(
            different(json.loads(line), json.loads(msgspec.json.encode(own)), rounded=level.ropes == "massive")
        )
        assert not found, (text, level, found[:5])


@pytest.mark.parametrize("seed", LIFTS)
def test_a_random_lift_written_with_present_keys_gives_the_system_of_its_former_text(seed: int, tmp_path: Path) -> None:
    text = random_lift(seed)
    own = plain(text, tmp_path)
    try:
        old = parse(text, passing=True).plan
    except SceneError:  # overloaded at rest
        with pytest.raises(SceneError):
            load(own)
        return
    new = load(own).plan
    for level in levels(seed):
        one, other = (msgspec.json.encode(system(at_level(x, level))).decode() for x in (old, new))
        assert not [*different(*(json.loads(renamed(x)) for x in (one, other)))]
    if seed in PLAYED:
        a, b = play(parse(text).plan), play(new)
        assert np.array_equal(a.rows, b.rows)
        assert [x[::2] for x in a.conduct.stages] == [x[::2] for x in b.conduct.stages]
        assert findings(a) == findings(b)


def former_scenes(folder: Path, *more: str) -> dict[str, tuple[dict[tuple[str, str], float], set[str]]]:
    """What `check` finds of each bundled scene of a former version: values by subject and quantity, and what is red."""
    scenes = str(folder / "heavylift/nodes/scenes")
    result = subprocess.run([sys.executable, "-c", CHECKED, scenes, *more], capture_output=True, text=True, check=True)
    rows = (json.loads(line) for line in result.stdout.splitlines())
    return {name: ({(who, what): value for who, what, value in found}, {*red}) for name, found, red in rows}


def test_bundled_scenes_of_former_versions_give_the_values_and_findings_that_those_versions_gave(
    tmp_path: Path,
) -> None:
    """Each value is as it was; what turned red is listed, here and for users."""
    archive_of(FORMER[-1], tmp_path)
    old, new = former_scenes(tmp_path, str(tmp_path)), former_scenes(tmp_path)
    turned = {name: red - old[name][1] for name, (_, red) in new.items()}
    assert {name: red for name, red in turned.items() if red} == TURNED
    for name, (values, red) in old.items():
        found, still = new[name]
        assert {key: found.get(key) for key in values} == {key: pytest.approx(x, rel=SAME) for key, x in values.items()}
        assert red <= still, name
