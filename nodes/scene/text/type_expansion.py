"""Expansion of a crane or frame to the parts of its type: parameters are inserted, expressions evaluated, and names
prefixed."""

import marshal
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from heavylift.recordings.format.spellings import GIRDERS

from .expressions import ExpressionError, value_of
from .faults import closest
from .parameters import Parameters
from .source import Data, Path, SourceText

HEADER = {"machine type", "frame type", "extends", "name", "about", "capacity", "source", "parameters", "interlocks"}
NAMED = (  # sections whose keys are names of parts
    *("bodies", "joints", "ropes", "supports", "springs", "stops", "brakes", "locks", "drives", "forces", "contacts"),
    *("hooks", "elastic", "shapes", GIRDERS, "load cells"),
)
BODIES = "parent", "child", "body", "on", "radius from"  # keys whose values name a body
JOINTS = "joint", "slides"  # or joints
MOST_MADE = 64
_made: "dict[str, tuple[MachineType, bytes, SourceText]]" = {}  # parts of types without errors, with their marks


@dataclass(frozen=True)
class MachineType:
    """A machine type as read from its file: description, parameters and data, with the places of all values."""

    name: str
    source: SourceText

    @property
    def data(self) -> Mapping[str, Data]:
        """All data of the machine type, by key."""
        return self.source.data

    @property
    def parameters(self) -> Mapping[str, Data]:
        """The parameters that a scene may override, with their default values."""
        found = self.data.get("parameters")
        return found if isinstance(found, dict) else {}

    def about(self, key: str) -> str:
        """Return the text of the type's key `about`, `capacity` or `source`."""
        return " ".join(str(self.data.get(key, "")).split())


class Expansion:
    """Replaces the crane or frame at the path `at` of a scene by the parts of its type."""

    def __init__(self, source: SourceText, at: Path, crane: Mapping[str, Data], kind: MachineType) -> None:
        self.source, self.at, self.name, self.kind = source, at, str(at[-1]), kind
        self.written = {key.replace("_", " "): key for key in crane if key != "type"}  # Python's names are keys, too
        self.given = {key: crane[word] for key, word in self.written.items()}
        self.base: Path = ("machines", self.name)
        self.prefix = f"{self.name}."
        self.bodies: set[str] = set()
        self.joints: set[str] = set()
        self.computed = True

    def run(self, entry: dict[str, Data]) -> None:
        """Insert the parts that a machine type generates into the scene; the crane's entry keeps its parameters."""
        known = self.kind.parameters
        for key in (key for key in self.given if key not in known):
            message = f"the type {self.kind.name} has no parameter '{key}'"
            self.source.fault((*self.at, self.written[key]), message, closest(key, known), on_key=True)
            del entry[self.written[key]]
        self._parameters(entry)
        keys, values = (
            {path: mark for path, mark in marks.items() if path[:2] == self.base and len(path) > 2}
            for marks in (self.source.keys, self.source.values)
        )
        machine = self._sections()
        self.source.keys |= keys
        self.source.values |= values
        machines = self.source.data.setdefault("machines", {})
        if not isinstance(machines, dict):
            return  # which is reported elsewhere
        machines[self.name] = self._laid(machine, machines.get(self.name, {}), ())
        self.source.where(self.at)  # so that its place is called as the scene writes it
        self.source.keys[self.base] = self.source.mark(self.at, on_key=True)
        self.source.values[self.base] = self.source.mark(self.at)

    def attach(self, entry: dict[str, Data]) -> None:
        """Insert the parts and parameters of a frame into its entry."""
        self.base = (*self.at, "parts")
        for key in (key for key in ("parameters", "parts") if key in entry):  # which the type makes
            self.source.fault((*self.at, key), f"unknown key '{key}'", on_key=True)
        self._parameters(entry)
        entry["parts"] = self._sections()

    def _parameters(self, entry: dict[str, Data]) -> None:
        """Collect all parameters under one key of the entry, the given ones and the defaults."""
        known = self.kind.parameters
        for key in [key for key in entry if key.replace("_", " ") in known]:
            del entry[key]
        entry["parameters"] = {**known, **{key: x for key, x in self.given.items() if key in known}}
        self._local()

    def _local(self) -> None:
        """Remove given parameters that do not fit, with an error for each, and collect the names of the type's bodies
        and joints."""
        known = self.kind.parameters
        for key, value in self.given.items():
            if key in known and not self._fits(key, value):
                path = (*self.at, self.written[key])
                self.source.fault(
                    path,
                    f"'{value}' does not fit this parameter",
                    f"the type has {known[key]} here: write a value of that kind",
                )
        self.given = {key: x for key, x in self.given.items() if key in known and self._fits(key, x)}
        local = {section: self._names(section) for section in NAMED}
        self.bodies, self.joints = {*local["bodies"], *local["hooks"]}, {*local["joints"]}

    def _laid(self, made: Data, given: Data, path: Path) -> Data:
        """Return the type's parts at a path with the scene's changes merged over them."""
        if not isinstance(made, dict) or not isinstance(given, dict):
            return given
        for key, value in given.items():
            if key not in made and len(path) == 1 and path[0] in NAMED and path != ("elastic",):
                message = f"the type {self.kind.name} makes no '{key}'"
                self.source.fault((*self.base, *path, key), message, closest(key, made), on_key=True)
            else:
                made[key] = self._laid(made.get(key), value, (*path, key))
        return made

    def _sections(self) -> dict[str, Data]:
        """Return all sections of the type's parts, without its description; its interlocks are added to the scene."""
        key, source = repr((self.at, self.base, self.given, self.written)), self.source
        kind, parts, own = _made.get(key, (None, b"", source))
        if kind is not self.kind:  # variants of a scene share most of them
            self.source = own = SourceText(source.name)
            made = {name: self._made(x, (name,), (name,)) for name, x in self.kind.data.items() if name not in HEADER}
            self._interlocks()
            self.source, parts = source, marshal.dumps((made, own.data.pop("interlocks", {})))
            source.faults += own.faults
            if self.computed and not own.faults:
                _made[key] = self.kind, parts, own
                for old in [*_made][: max(0, len(_made) - MOST_MADE)]:
                    _made.pop(old, None)
        for name in ("keys", "values", "given", "offered"):
            getattr(source, name).update(getattr(own, name))
        sections, interlocks = marshal.loads(parts)
        if interlocks and isinstance(given := source.data.setdefault("interlocks", {}), dict):
            given |= interlocks
        result: dict[str, Data] = sections
        return result

    def _interlocks(self) -> None:
        """Make the interlocks of the type."""
        own, base, given = self.kind.data.get("interlocks"), self.base, dict[str, Data]()
        if not isinstance(own, dict):
            return
        self.base = ()
        for key, data in own.items():
            name = f"{self.name}.{key}"
            made = self._made(data, ("interlocks", key), ("interlocks", name))
            given[name] = {"on": self.name, **made} if isinstance(made, dict) else made
        self.base, self.source.data["interlocks"] = base, given

    def _names(self, section: str) -> list[str]:
        found = self.kind.data.get(section)
        return list(found) if isinstance(found, dict) else []

    def _made(self, data: Data, path: Path, to: Path) -> Data:
        """Return the type's data at `path` as data of the machine at `to`: names are prefixed, expressions
        evaluated."""
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
        """Return the full name of a part of the machine to which a value refers; other values are returned
        unchanged."""
        local = self.bodies if key in BODIES else self.joints if key in JOINTS else ()
        if isinstance(value, list) and local:
            return [self._resolved(key, each) for each in value]
        return f"{self.prefix}{value}" if isinstance(value, str) and value in local else value

    def _computed(self, text: str, path: Path, to: Path) -> Data:
        word = " ".join(text[1:].split())
        if word in self.kind.parameters:
            raw = self.given.get(word, self.kind.parameters[word])
            self.source.offered[(*self.base, *to)] = word
            if word in self.given:
                self.source.given[(*self.base, *to)] = (*self.at, self.written[word])
            if word in self.given or not (isinstance(raw, str) and raw.startswith("=")):
                return raw
        try:
            made = self.values.computed(text[1:])
            if path[-1:] == ("start",) and (named := self._blamed(text)):
                self.source.given[(*self.base, *to)] = (*self.at, self.written[named])
            return made
        except ExpressionError as error:
            del self.values  # which stands where it failed
            self.computed = False
            if blamed := self._blamed(text):
                message = f"the type {self.kind.name} computes {text[1:].strip()}: {error}"
                self.source.fault((*self.at, self.written[blamed]), message)
                return None
            what = "crane" if self.at[0] == "cranes" else "frame"
            own = f"in the {what} '{self.name}' of type {self.kind.name}"
            column = max(1 + error.column, len(text) - len(text[1:].lstrip()))
            self.source.fault((*self.base, *to), str(error), own, column=column)
            return None

    def _blamed(self, text: str) -> str:
        """If a formula has a result with the type's own values, return the first given parameter in this formula; else
        ""."""
        named = [key for key in self.given if re.search(rf"\b{re.escape(key)}\b", text)]
        try:
            Parameters(self.kind.parameters, {}).computed(text[1:])
        except ExpressionError:
            return ""
        return min(named, key=text.index, default="")

    @cached_property
    def values(self) -> Parameters:
        """The parameters of the type, whose values are computed at most once."""
        return Parameters(self.kind.parameters, self.given)

    @cached_property
    def arithmetic(self) -> list[str]:
        """The expressions in the type, except those that consist of a single parameter."""
        found, waiting = list[str](), [self.kind.source.data]
        for data in waiting:  # which grows
            waiting += data.values() if isinstance(data, dict) else data if isinstance(data, list) else ()  # type: ignore[arg-type]
            if isinstance(data, str) and data.startswith("=") and data[1:].strip() not in self.kind.parameters:
                found.append(data)
        return found

    def _fits(self, key: str, given: Data) -> bool:
        """Return whether a given value can replace a parameter's default. If the type computes with the parameter, both
        must be of the same kind; otherwise the value may be anything that the keys accept."""
        default = self.kind.parameters[key]
        whole = value_of(given) is None and not any(key in text for text in self.arithmetic)
        return value_of(default) is None or _alike(given, default) or whole

    def _mark(self, path: Path, to: Path) -> None:
        """Copy the place in the text from `path` in the type to `to` in the machine."""
        here, theirs = (*self.base, *to), self.kind.source
        if path in theirs.keys:
            self.source.keys[here] = theirs.keys[path]
        if path in theirs.values:
            self.source.values[here] = theirs.values[path]


def _alike(given: Data, default: Data) -> bool:
    """Return whether a given value is of the same kind as a default value, so that the same expressions can use it."""
    if isinstance(given, list) and isinstance(default, list):
        return len(given) == len(default) and all(map(_alike, given, default))
    one, two = value_of(given), value_of(default)
    return one is not None and two is not None and one.exponents == two.exponents
