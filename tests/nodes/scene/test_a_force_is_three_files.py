"""The recipe for a new force: a description, a law and a row of the force table give scenes its keys."""

import ast
import os
import subprocess
import sys
from math import radians
from pathlib import Path
from shutil import copytree
from typing import get_args

import pytest
from heavylift.kernel.description import Force

ROOT = Path(__file__).parents[3]
LISTED = {
    kind: {"mechanics.py"} for kind in ("MooringLine", "Reeving", "TuggerLine", "UserLaw")
}  # ropes and the user's code
DESCRIPTION = '''
class EddyBrake(Element, frozen=True, tag=True):
    """An eddy-current brake on a joint: torque = 2 T u / (1 + u^2), u = speed over the critical one (Wouterse 1991)."""

    name: str
    joint: str
    largest: u.Effort  # torque at the critical speed
    critical: Annotated[float, u.Unit("angular rate", "positive")] = 12.0
    d: u.TurnDamping = 0.0


Force = EddyBrake | '''
LAW = '''
from heavylift.kernel.description.forces import EddyBrake
from .force_law import LawOutput, ForceLaw


class EddyBrakeLaw(ForceLaw[EddyBrake]):
    """Torque against the turning."""

    def numbers(self, f, poses):
        return [f.largest, f.critical, f.d]

    def answer(self, f, p, ends, signal, joint, t):
        u = joint[1] / p[1]
        torque = 2.0 * p[0] * u / (1.0 + u * u) + p[2] * joint[1]
        return LawOutput(effort=-torque, heat=torque * joint[1], shown=[])
'''
SCENE = """\
heavylift: 1
name: bench
end: 2 s
mechanism:
  bodies:
    disc: {mass: 100 kg, inertia: [80 kg m2, 80 kg m2, 80 kg m2]}
  joints:
    hinge: {type: revolute, child: disc, axis: [0, 0, 1], speed: 30 rad/s}
  forces:
    retarder: {type: eddy brake, joint: hinge, largest: 0.4 kN m, critical: 700 deg/s, damping: 2 N m s/rad}
"""
ASKED = """
import sys
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.scene import json_schema, parse
from heavylift.coordinator.record.in_memory import play

text = sys.stdin.read()
try:
    scene = parse(text)
    print(scene.plan.machines[0].system.forces[0])
    played = play(scene.plan)
    print(played.rows[-1, played.layout.find('joint/velocity').start])
except HeavyliftError as error:
    print(error)
keys = json_schema()["$defs"]["EddyBrake"]
print(keys["description"], keys["required"], keys["properties"]["critical"])
"""


def _edit(path: Path, *changes: tuple[str, str]) -> None:
    text = path.read_text()
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    path.write_text(text)


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    product = tmp_path_factory.mktemp("copy") / "heavylift"
    copytree(ROOT / "kernel", product / "kernel")
    for room in ("nodes", "coordinator", "recordings"):
        (product / room).symlink_to(ROOT / room)
    (product / "__init__.py").symlink_to(ROOT / "coordinator" / "face" / "__init__.py")
    kernel = product / "kernel"
    _edit(
        kernel / "description" / "forces.py",
        ("\nForce = ", DESCRIPTION),
        ("from typing import Literal", "from typing import Annotated, Literal"),
        ('"Bushing",', '"Bushing", "EddyBrake",'),
    )
    (kernel / "forces" / "eddy_brake.py").write_text(LAW)
    row = ("    kinds.Load: LoadLaw(),", "    kinds.Load: LoadLaw(),\n    kinds.EddyBrake: EddyBrakeLaw(),")
    imported = ("from .loads", "from .eddy_brake import EddyBrakeLaw\nfrom .loads")
    _edit(kernel / "forces" / "table.py", row, imported)
    return product.parent


def _answer(copy: Path, scene: str) -> list[str]:
    own = {**os.environ, "PYTHONPATH": str(copy), "HEAVYLIFT_CACHE": str(copy / "cache")}
    asked = [sys.executable, "-c", ASKED]
    done = subprocess.run(asked, input=scene, env=own, capture_output=True, text=True, timeout=300, check=False)
    assert not done.returncode, done.stderr
    return done.stdout.splitlines()


def test_a_newly_added_force_is_read_from_a_scene_and_acts_in_its_run(copy: Path) -> None:
    made, speed, keys = _answer(copy, SCENE)
    assert made.startswith("EddyBrake(name='retarder', joint='hinge', largest=400.0, critical=12.2")
    assert "d=2.0" in made
    w, critical, dt = 30.0, radians(700.0), 1e-4
    for _ in range(20000):
        u = w / critical
        w -= dt / 80.0 * (800.0 * u / (1.0 + u * u) + 2.0 * w)
    assert float(speed) == pytest.approx(w, rel=1e-3)
    assert keys.startswith("An eddy-current brake on a joint. ['type', 'joint', 'largest']")
    assert "'default': '687.5493542 deg/s'" in keys
    assert "'dimension': 'angular rate'" in keys


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("0.4 kN m", "400", "missing unit: write '400 kN' or '400000 N'"),
        ("700 deg/s", "700 m/s", "is not a valid angular rate"),
        ("joint: hinge", "joint: hinges", "there is no joint 'hinges'"),
        ("critical", "critcal", "unknown key 'critcal'"),
        ("eddy brake", "eddy break", "'eddy break' is not known here"),
    ],
)
def test_faults_in_a_newly_added_kind_of_force_are_reported_with_their_line_in_the_scene(
    copy: Path, old: str, new: str, sentence: str
) -> None:
    message = _answer(copy, SCENE.replace(old, new))[0:-1]
    assert any(sentence in line and line.partition(":")[0] for line in message), message


def _naming(kind: str, *folders: str) -> set[str]:
    """Files of these folders whose code uses a name; a law that is a folder is one file."""
    found = set()
    for path in (path for folder in folders for path in (ROOT / folder).rglob("*.py")):
        names = {getattr(x, "id", "") or getattr(x, "attr", "") for x in ast.walk(ast.parse(path.read_text()))}
        if kind in names or f"class {kind}(" in path.read_text():
            found.add(path.parent.name if path.parent.name == "reeving" else path.name)
    return found


@pytest.mark.parametrize("kind", [kind.__name__ for kind in get_args(Force)])
def test_each_kind_of_force_has_a_description_and_a_law_and_one_row_in_the_table_of_forces(kind: str) -> None:
    found = _naming(kind, "kernel/description", "kernel/forces") - LISTED.get(kind, set())
    assert len(found) == 3, found
    assert {"forces.py", "table.py"} < found
    assert _naming(kind, "nodes/scene/keys") <= {"forces.py", "ropes.py", "seas.py"}, "keys that differ have one class"
