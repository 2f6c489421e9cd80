"""Parts of a machine read from a robot model: `from: robot.urdf` or `from: model.xml` (MJCF), by MuJoCo.

    machines:
      arm:
        from: arm.urdf
        joints: {arm.base: {at: [4 m, 0 m, 1 m]}}

All names get the name of the machine as prefix. The model stands on the massless body `base`, whose joint to the world
the scene may change, like every other part. An actuator that holds a position or a speed becomes a drive, any other a
force of factor 0. Features without an equivalent are listed under `from: lacks`, and `heavylift check` reports them.
"""

import re
from collections.abc import Iterator, Sequence
from math import sqrt
from pathlib import Path as FilePath
from typing import Any
from xml.parsers import expat

from heavylift.kernel.algebra.elementary import atan2
from heavylift.kernel.description import forces
from heavylift.kernel.description.mechanics import JOINTS, WORLD, Body, Joint, Line, Point, Rope, System
from heavylift.kernel.errors import SceneError
from heavylift.nodes.mujoco_models import ImportedModel, import_model
from heavylift.nodes.scene.text.files import content, within
from heavylift.nodes.scene.text.source import Data, Mark, Path, SourceText

LARGEST = 16_000_000  # bytes of a file
KINDS = ".urdf", ".xml", ".mjcf"
BASE = "base"
FOLDERS, FILES = ("meshdir", "texturedir", "assetdir"), ("file", "filename")  # attributes of MJCF and URDF
EARTH = (9.7, 9.9)  # gravity that no scene needs to change [m/s2]
RAMP = {True: "1 rad/s2", False: "1 m/s2"}  # of drives, by whether their joint turns
UNITS = {True: ("rad", "N m", "N m/rad", "N m s/rad"), False: ("m", "N", "N/m", "N s/m")}
Lines = dict[str, Mark]


class _InvalidXml(SceneError):
    """A model file that MuJoCo or the XML parser refuses, with the place of the error."""

    def __init__(self, sentence: str, mark: Mark) -> None:
        super().__init__(sentence)
        self.mark = mark


def imported(source: SourceText) -> None:
    """Insert the parts of each machine or mechanism that is read `from` a model file; errors go to the scene."""
    machines = source.data.get("machines")
    bases: list[Path] = [("machines", name) for name in (machines if isinstance(machines, dict) else ())]
    for base in (*bases, ("mechanism",)):
        entry = source.at(base)
        file = entry.get("from") if isinstance(entry, dict) else None
        if isinstance(entry, dict) and isinstance(file, str):
            try:
                _put(source, base, entry, file)
            except _InvalidXml as error:
                source.fault((*base, "from"), str(error), mark=error.mark)
            except (SceneError, ValueError) as error:
                source.fault((*base, "from"), str(error))


def _put(source: SourceText, base: Path, entry: dict[str, Data], file: str) -> None:
    if not file.lower().endswith(KINDS):
        raise SceneError(f"'{file}' is not a .urdf, .xml or .mjcf file")
    path, lines = source.root / file, Lines()
    _scan(source.root, path, lines)
    prefix = f"{base[-1]}." if base[0] == "machines" else ""
    try:
        model = import_model(path)
    except SceneError as error:
        sentence = str(error).removeprefix(f"{path}: ")
        row = re.search(r", line (\d+)", sentence)
        raise _InvalidXml(sentence, _mark(path, int(row[1]) if row else 1)) from None
    sections, lacks = _Parts(model, prefix).sections()
    whole = source.mark((*base, "from"))
    for section, parts in sections.items():
        for name in parts:
            own = name.removeprefix(prefix)
            mark = next((lines[own[:n]] for n in range(len(own), 0, -1) if own[:n] in lines), whole)
            at = (*base, section, name)
            source.keys.setdefault(at, mark)
            source.values.setdefault(at, mark)
        entry[section] = _laid(parts, entry.get(section))
    entry["from"] = {"file": file, "lacks": lacks}


def _mark(path: FilePath, row: int, column: int = 1) -> Mark:
    """Return the mark of a line of a model file."""
    lines = path.read_text("utf-8", "replace").splitlines()[row - 1 :]
    return Mark(str(path), row, column, lines[0] if lines else "")


def _laid(made: Data, given: Data) -> Data:
    """Return generated parts with the scene's changes merged over them."""
    if not isinstance(made, dict) or not isinstance(given, dict):
        return made if given is None else given
    return made | {key: _laid(made.get(key), value) for key, value in given.items()}


def _scan(root: FilePath, path: FilePath, lines: Lines, seen: tuple[FilePath, ...] = ()) -> None:
    """Collect the lines that name elements, in a model and the files that it includes; raises SceneError if the model
    refers to a file outside the scene's folder."""
    try:
        text = content(within(root, path), LARGEST)
    except OSError as error:
        raise SceneError(f"the model '{path.name}' cannot be read: {error.strerror}") from None
    parser, named = expat.ParserCreate(), list[str]()
    shown = text.decode("utf-8", "replace").splitlines()
    folders, included = [path.parent], list[str]()

    def start(tag: str, attributes: dict[str, str]) -> None:
        row, column = parser.CurrentLineNumber, 1 + parser.CurrentColumnNumber
        if (name := attributes.get("name")) and row <= len(shown):
            lines.setdefault(_word(name), Mark(str(path), row, column, shown[row - 1]))
        folders.extend(path.parent / attributes[key] for key in FOLDERS if key in attributes)
        named.extend(attributes[key] for key in FILES if key in attributes)
        if tag == "include":
            included.append(attributes.get("file", ""))

    parser.StartElementHandler = start
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise _InvalidXml(
            f"the file is not valid XML: {expat.ErrorString(error.code)}", _mark(path, error.lineno)
        ) from None
    for name in named:
        for folder in folders:
            for there in (folder / name, folder / FilePath(name).name):
                if there.exists():
                    within(root, there)
    for name in included:
        if (there := (seen or (path,))[0].parent / name).exists() and there not in seen:
            _scan(root, there, lines, (*(seen or (path,)), there))


class _Parts:
    """Conversion of an imported model to the sections of a machine, as a scene writes them."""

    def __init__(self, model: ImportedModel, prefix: str) -> None:
        self.model, self.prefix = model, prefix
        self.system: System = model.found.system
        self.kinds = {joint.name: joint.kind for joint in self.system.joints}
        self.taken: set[str] = set()
        self.lacks = list(model.found.missing)

    def sections(self) -> tuple[dict[str, dict[str, Data]], list[Data]]:
        """Return the imported parts as sections of a machine's keys, and a list of the features not converted."""
        system = self.system
        if not EARTH[0] < system.gravity < EARTH[1]:
            self.lacks.append(f"gravity of {system.gravity:g} m/s2: that of the scene acts, key `gravity`")
        bodies: dict[str, Data] = {self._body(WORLD): {"mass": "0 kg"}}
        bodies |= {self._body(b.name): _mass(b) for b in system.bodies}
        fixed: Data = {"type": "fixed", "parent": WORLD, "child": self._body(WORLD)}
        joints = {self._body(WORLD): fixed}
        self.taken.add(BASE)
        joints |= {self._named(joint.name, "joint"): self._joint(joint) for joint in system.joints}
        made: dict[str, dict[str, Data]] = {"bodies": bodies, "joints": joints, "forces": {}, "drives": {}}
        made["springs"] = {}
        made["shapes"] = {self._body(name): boxes for name, boxes in self._shapes() if boxes}
        bias = {spring.name: spring for spring in system.springs}
        for force in system.forces:
            self._force(force, bias, made)
        for spring in bias.values():
            u = UNITS[self._turns(spring.joint)]
            made["springs"][self._named(spring.name, "spring")] = {
                "joint": self._part(spring.joint), "stiffness": f"{spring.k!r} {u[2]}",
                "damping": f"{spring.d!r} {u[3]}", "rest": f"{spring.q_rest!r} {u[0]}",
            }  # fmt: skip
        made["stops"] = {}
        for stop in system.stops:
            u = UNITS[self._turns(stop.joint)]
            made["stops"][self._named(stop.name, "limit")] = {
                "joint": self._part(stop.joint), "range": [f"{stop.lower!r} {u[0]}", f"{stop.upper!r} {u[0]}"],
                "stiffness": f"{stop.k!r} {u[2]}", "damping": f"{stop.d!r} {u[3]}",
            }  # fmt: skip
        made["ropes"] = {self._named(rope.name, "rope"): self._rope(rope) for rope in system.ropes}
        return {key: parts for key, parts in made.items() if parts}, list(self.lacks)

    def _part(self, name: str) -> str:
        return f"{self.prefix}{_word(name)}"

    def _body(self, name: str) -> str:
        return self._part(BASE if name == WORLD else name)

    def _named(self, name: str, kind: str) -> str:
        """Return the name of a part, with its kind if another part of a different kind has the same name."""
        word = _word(name)
        word = word if word not in self.taken else f"{word}-{kind}"
        self.taken.add(word)
        return f"{self.prefix}{word}"

    def _turns(self, joint: str) -> bool:
        return JOINTS[self.kinds[joint]].turns(0)

    def _joint(self, j: Joint) -> Data:
        made: dict[str, Data] = {
            "type": j.kind, "parent": self._body(j.parent), "child": self._body(j.child), "at": _lengths(j.p_PJ),
            "rotation": [f"{x!r} rad" for x in _angles(j.R_PJ)], "at child": _lengths(j.p_CJ),
        }  # fmt: skip
        if j.kind in ("revolute", "prismatic"):
            made["axis"] = list(j.axis)
        if j.kind == "free":
            made |= {"position": _lengths(j.q0[:3]), "attitude": list(j.q0[3:])}
        return made

    def _force(self, f: forces.Force, bias: dict[str, Any], made: dict[str, dict[str, Data]]) -> None:
        """Convert a force: an actuator with feedback becomes a drive, which replaces its spring in `bias`."""
        match f:
            case forces.Characteristic():
                turns, effort = self._turns(f.joint), f.effort[0]
                u = UNITS[turns]
                joint: dict[str, Data] = {"joint": self._part(f.joint)}
                spring = bias.pop(f"{f.name}-bias", None) if f.signal.driven else None
                if spring:
                    self._note("actuators with feedback are drives, which move with a ramp of 1 m/s2 or 1 rad/s2")
                    kind = {"type": "servo", "stiffness": f"{spring.k!r} {u[2]}"} if spring.k else {"type": "speed"}
                    drive = joint | kind | {"damping": f"{spring.d!r} {u[3]}", "ramp": RAMP[turns]}
                    made["drives"][self._named(f.name, "drive")] = drive
                    return
                curve: Data = [[f"{x!r} {u[0]}", f"{effort!r} {u[1]}"] for x in f.x]
                row = {"type": "characteristic", "over": "position", "curve": curve}
                made["forces"][self._named(f.name, "force")] = joint | row | self._factor(f.signal)
            case forces.Load():
                made["forces"][self._named(f.name, "force")] = {
                    "type": "load", **self._point(f.at), "axes": f.axes, **self._factor(f.signal),
                    "force": [f"{x!r} N" for x in f.force], "moment": [f"{x!r} N m" for x in f.moment],
                }  # fmt: skip
            case forces.Spring():
                made["forces"][self._named(f.name, "spring")] = {
                    "type": "spring", "start": self._point(f.a), "end": self._point(f.b), "rest": f"{f.rest!r} m",
                    "stiffness": f"{f.k!r} N/m", "damping": f"{f.d!r} N s/m",
                }  # fmt: skip
            case forces.Reeving():
                self._reeving(f, made)

    def _reeving(self, f: forces.Reeving, made: dict[str, dict[str, Data]]) -> None:
        if f.edges:
            self.lacks.append(f"tendon '{f.name}': cylinders along which a tendon slides; `from_mujoco` has them")
            return
        over: list[Data] = [
            {**self._point(s.at), "axis": list(s.axis), "radius": f"{s.radius!r} m"} if s.radius else self._point(s.at)
            for s in f.sheaves
        ]
        made.setdefault("ropes", {})[self._named(f.name, "rope")] = {
            "start": self._point(f.a), "end": self._point(f.b), "over": over, "EA": f"{f.EA!r} N",
            "length": f"{f.L0!r} m", "damping": f"{f.damping!r} N s/m",
        }  # fmt: skip

    def _factor(self, signal: forces.InputSignal) -> dict[str, Data]:
        if signal.driven:
            self._note("actuators without feedback are forces of factor 0: set their `factor` or `history`")
        return {"factor": signal.value}

    def _note(self, sentence: str) -> None:
        if sentence not in self.lacks:
            self.lacks.append(sentence)

    def _rope(self, r: Rope) -> Data:
        lines: list[Data] = [self._line(line) for line in r.lines]
        return {"lines": lines, "EA": f"{r.EA!r} N", "length": f"{r.L0!r} m", "damping": f"{r.damping!r} N s/m"}

    def _line(self, line: Line) -> Data:
        return {"start": self._point(line.a), "end": self._point(line.b), "share": line.share}

    def _point(self, p: Point) -> dict[str, Data]:
        return {"body": self._body(p.body), "at": _lengths(p.p)}

    def _shapes(self) -> Iterator[tuple[str, Data]]:
        for body, boxes in self.model.boxes.items():
            yield body, [{"at": _lengths(centre), "size": _lengths(size)} for centre, size in boxes]


def _word(name: str) -> str:
    """Return a name with the characters that names of parts may have."""
    word = re.sub(r"[^A-Za-z0-9_-]", "-", name)
    return word if word[:1].isalpha() or word[:1] == "_" else f"n{word}"


def _mass(body: Body) -> Data:
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.inertia
    moments = [xx, yy, zz, *((xy, xz, yz) if any((xy, xz, yz)) else ())]
    inertia: list[Data] = [f"{x!r} kg m2" for x in moments]
    return {"mass": f"{body.mass!r} kg", "com": _lengths(body.com), "inertia": inertia}


def _lengths(values: Sequence[float]) -> list[Data]:
    return [f"{x!r} m" for x in values]


def _angles(R: Sequence[Sequence[float]]) -> tuple[float, float, float]:
    """Return the angles about x, then y, then z [rad] that give a rotation matrix."""
    flat = sqrt(R[0][0] * R[0][0] + R[1][0] * R[1][0])
    if flat < 1e-12:
        return atan2(-R[1][2], R[1][1]), atan2(-R[2][0], flat), 0.0
    return atan2(R[2][1], R[2][2]), atan2(-R[2][0], flat), atan2(R[1][0], R[0][0])
