"""One crane or frame made of the parts of its type: parameters put in, arithmetic done, names with its own in front."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .expressions import ExpressionError, Parameters, value_of
from .faults import closest
from .source import Data, Path, Source

HEADER = {"machine type", "frame type", "family", "name", "about", "capacity", "source", "parameters", "interlocks"}
NAMED = (  # sections whose keys are names of parts
    *("bodies", "joints", "ropes", "supports", "springs", "stops", "brakes", "locks", "drives", "forces", "contacts"),
    *("hooks", "elastic", "shapes"),
)
BODIES, JOINTS = ("parent", "child", "body", "on", "radius from"), ("joint",)  # keys whose values name a body, a joint


@dataclass(frozen=True)
class MachineType:
    """A type file: what it says of itself, its parameters, and its data with their marks."""

    name: str
    source: Source

    @property
    def data(self) -> Mapping[str, Data]:
        """All of it."""
        return self.source.data

    @property
    def parameters(self) -> Mapping[str, Data]:
        """What a scene may override, with its values."""
        found = self.data.get("parameters")
        return found if isinstance(found, dict) else {}

    def about(self, key: str) -> str:
        """What it says of itself: its `about`, its `capacity`, its `source`."""
        return " ".join(str(self.data.get(key, "")).split())


class Expansion:
    """One crane or frame, which stands `at` a place of the scene, and its type."""

    def __init__(self, source: Source, at: Path, crane: Mapping[str, Data], kind: MachineType) -> None:
        self.source, self.at, self.name, self.kind = source, at, str(at[-1]), kind
        name = self.name
        self.given = {key: value for key, value in crane.items() if key != "type"}
        self.base: Path = ("machines", name)
        self.prefix = f"{name}."
        self.bodies: set[str] = set()
        self.joints: set[str] = set()
        self.computed = True

    def run(self) -> None:
        """The machine, below `machines` of the scene's data."""
        known = self.kind.parameters
        for key in self.given:
            if key not in known:
                message = f"the type {self.kind.name} has no parameter '{key}'"
                self.source.fault(("cranes", self.name, key), message, closest(key, known), on_key=True)
        self._local()
        keys, values = (
            {path: mark for path, mark in marks.items() if path[:2] == self.base and len(path) > 2}
            for marks in (self.source.keys, self.source.values)
        )
        machine = self._sections()
        self.source.keys |= keys
        self.source.values |= values
        machines = self.source.data.setdefault("machines", {})
        cranes = self.source.data["cranes"]
        if not isinstance(machines, dict) or not isinstance(cranes, dict):
            return  # which is reported elsewhere
        machines[self.name] = self._laid(machine, machines.get(self.name, {}), ())
        del cranes[self.name]
        self.source.keys[self.base] = self.source.mark(("cranes", self.name), on_key=True)
        self.source.values[self.base] = self.source.mark(("cranes", self.name))

    def attach(self, entry: dict[str, Data]) -> None:
        """Parts of a frame in its entry, and its parameters, whether written there or not."""
        self.base = (*self.at, "parts")
        self._unmade(entry)
        self.given = {key.replace("_", " "): x for key, x in self.given.items()}  # Python's names are keys, too
        known = self.kind.parameters
        for key in [key for key in entry if key.replace("_", " ") in known]:
            del entry[key]
        entry["parameters"] = {**known, **{key: x for key, x in self.given.items() if key in known}}
        self._local()
        entry["parts"] = self._sections()

    def _unmade(self, entry: Mapping[str, Data]) -> None:
        """Nobody writes what the type makes."""
        for key in (key for key in ("parameters", "parts") if key in entry):
            self.source.fault((*self.at, key), f"unknown key '{key}'", on_key=True)

    def _local(self) -> None:
        """What is given of the parameters, if it fits; names of bodies and joints."""
        known = self.kind.parameters
        for key, value in self.given.items():
            if key in known and not _fits(value, known[key]):
                self.source.fault((*self.at, key), f"'{value}' does not fit", f"in the type: {known[key]}")
        self.given = {key: x for key, x in self.given.items() if key in known and _fits(x, known[key])}
        local = {section: self._names(section) for section in NAMED}
        self.bodies, self.joints = {*local["bodies"], *local["hooks"]}, {*local["joints"]}

    def _laid(self, made: Data, given: Data, path: Path) -> Data:
        """What a scene writes of the crane's parts, over what the type makes of them."""
        if not isinstance(made, dict) or not isinstance(given, dict):
            return given
        for key, value in given.items():
            if key not in made and len(path) == 1 and path[0] in NAMED and path != ("elastic",):
                told = f"the type {self.kind.name} makes no '{key}'"
                self.source.fault((*self.base, *path, key), told, closest(key, made), on_key=True)
            else:
                made[key] = self._laid(made.get(key), value, (*path, key))
        return made

    def lay_under(self, crane: dict[str, Data]) -> None:
        """Parameters of the type of a crane on rails and what it makes of them, below the keys of the crane."""
        self.base, self.prefix = ("cranes", self.name, "parts"), ""
        theirs = self.kind.parameters
        self._unmade(crane)
        written = {key.replace("_", " "): value for key, value in self.given.items()}  # Python's names are keys, too
        self.given = {key: x for key, x in written.items() if key in theirs and _alike(x, theirs[key])}
        crane["parts"] = self._sections()
        crane["parameters"] = {key: value for key, value in theirs.items() if key not in written}
        for key in theirs:
            if key not in written and (mark := self.kind.source.values.get(("parameters", key))):
                self.source.values["cranes", self.name, key] = mark

    def _sections(self) -> dict[str, Data]:
        """All of the type but what it says of itself; its interlocks join those of the scene."""
        made = {name: self._made(x, (name,), (name,)) for name, x in self.kind.data.items() if name not in HEADER}
        self._interlocks()
        return made

    def _interlocks(self) -> None:
        """Those of the type, among the scene's."""
        own, base = self.kind.data.get("interlocks"), self.base
        given = self.source.data.setdefault("interlocks", {}) if own else None
        if not isinstance(own, dict) or not isinstance(given, dict):
            return
        self.base = ()
        for key, data in own.items():
            name = f"{self.name}.{key}"
            made = self._made(data, ("interlocks", key), ("interlocks", name))
            given[name] = {"on": self.name, **made} if isinstance(made, dict) else made
        self.base = base

    def _names(self, section: str) -> list[str]:
        found = self.kind.data.get(section)
        return list(found) if isinstance(found, dict) else []

    def _made(self, data: Data, path: Path, to: Path) -> Data:
        """Data of the type at `path`, as they stand at `to` of the machine."""
        self._mark(path, to)
        if isinstance(data, dict):
            prefix = self.prefix if len(path) == 1 and path[0] in NAMED else ""
            made: dict[str, Data] = {}
            for key, value in data.items():
                name = f"{prefix}{key}"
                made[name] = self._made(self._resolved(key, value), (*path, key), (*to, name))
            return made
        if isinstance(data, list):
            return [self._made(each, (*path, i), (*to, i)) for i, each in enumerate(data)]
        if isinstance(data, str) and data.startswith("="):
            return self._computed(data, path, to)
        return data

    def _resolved(self, key: str, value: Data) -> Data:
        """A reference to a part of the machine, by its whole name."""
        local = self.bodies if key in BODIES else self.joints if key in JOINTS else ()
        return f"{self.prefix}{value}" if isinstance(value, str) and value in local else value

    def _computed(self, text: str, path: Path, to: Path) -> Data:
        try:
            return Parameters(self.kind.parameters, self.given).computed(text[1:])
        except ExpressionError as error:
            blank = len(text[1:]) - len(text[1:].lstrip())
            what = "crane" if self.at[0] == "cranes" else "frame"
            own = f"in the {what} '{self.name}' of type {self.kind.name}"
            column = 1 + max(error.column, blank)
            self.source.fault((*self.base, *to), str(error), own, column=column)
            self.computed = False
            return None

    def _mark(self, path: Path, to: Path) -> None:
        """Where the text at `path` stands: in the type, or in the scene if it is a parameter that is given there."""
        here, theirs = (*self.base, *to), self.kind.source
        if path in theirs.keys:
            self.source.keys[here] = theirs.keys[path]
        if path in theirs.values:
            self.source.values[here] = theirs.values[path]


def _fits(given: Data, default: Data) -> bool:
    """Whether a value can stand for a parameter's own; what is computed there tells nothing of it."""
    return value_of(default) is None or _alike(given, default)


def _alike(given: Data, default: Data) -> bool:
    """Whether a value is of the kind of another one, so that arithmetic can be done with it."""
    if isinstance(given, list) and isinstance(default, list):
        return len(given) == len(default) and all(map(_alike, given, default))
    one, two = value_of(given), value_of(default)
    return one is not None and two is not None and one.exponents == two.exponents
