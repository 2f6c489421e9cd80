"""The data of a scene with the place in the text of every key and every value.

YAML 1.2 is parsed by ruamel's composer: its nodes are converted once into plain data, and each path in the data gets a
mark (file, line, column) for its key and one for its value, so that any later error can point at the text that the user
wrote. `extends: other.yaml` merges mappings key by key (lists and values are replaced); marks keep their own file. `<<:
*name` merges the mapping of an anchor under another mapping. The order of keys has no meaning: `ordered` sorts them by
name.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path as FilePath
from typing import Any, TypeAlias

from heavylift.kernel.description.units import natural
from heavylift.kernel.errors import SPACES, printable
from ruamel.yaml import YAML
from ruamel.yaml.composer import Composer
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode
from ruamel.yaml.reader import ReaderError

from .files import LARGEST
from .spelling import explained, unreadable

Path: TypeAlias = tuple[str | int, ...]
Data: TypeAlias = "dict[str, Data] | list[Data] | str | int | float | bool | None"

DEEPEST = 40  # levels of a scene
MERGE = "<<"
MOST_VALUES = 50_000  # of a scene, those that an alias stands for counted each time
MOST_DIGITS = 100  # of a number


@dataclass(frozen=True)
class Mark:
    """A place in a scene file: line and column, counted from 1, and the text of the line."""

    file: str
    line: int
    column: int
    text: str


@dataclass(frozen=True)
class Fault:
    """An error at a path in the data of a scene.

    `column`: place of the error in the value, counted from 0."""

    path: Path
    sentence: str
    hint: str = ""
    on_key: bool = False
    column: int = 0
    mark: Mark | None = None


@dataclass
class SourceText:
    """The plain data of a scene, with the places of its keys and values in the text, and the errors found so far."""

    name: str
    data: dict[str, Data] = field(default_factory=dict)
    keys: dict[Path, Mark] = field(default_factory=dict)
    values: dict[Path, Mark] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)
    places: dict[str, Path] = field(default_factory=dict)
    root: FilePath = FilePath()  # the scene's folder, which holds all files that it may use
    files: tuple[str, ...] = ()  # the file, and before it those that it extends
    given: dict[Path, Path] = field(default_factory=dict)  # what types put somewhere -> where the scene writes it
    offered: dict[Path, str] = field(default_factory=dict)  # the same -> the parameter that it is

    def fault(
        self, path: Path, text: str, hint: str = "", *, on_key: bool = False, column: int = 0, mark: Mark | None = None
    ) -> None:
        """Add an error about the value at a path."""
        self.faults.append(Fault(path, text, hint, on_key, column, mark))

    def at(self, path: Path) -> Data:
        """Return the value at a path of the present data; None if the path does not exist."""
        found: Data = self.data
        for part in path:
            found = child(found, part)
        return found

    def written(self, path: Path) -> Path:
        """Return the path of the key in the scene file that sets a value.

        This is the path of the parameter from which a type computes the value, or the given path itself."""
        tops = (n for n in range(len(path), 0, -1) if path[:n] in self.given) if self.given else ()
        return next(((*self.given[path[:n]], *path[n:]) for n in tops), path)

    def mark(self, path: Path, *, on_key: bool = False) -> Mark:
        """Return the place in the text of the value at a path, or else of its nearest parent with a place."""
        path = self.written(path)
        while path:
            found = (self.keys.get(path) if on_key else None) or self.values.get(path)
            if found:
                return found
            path, on_key = path[:-1], True
        return self.values.get((), Mark(self.name, 1, 1, ""))

    def layer(self, mark: Mark) -> int:
        """Return the precedence of the file of a mark: later files override earlier ones, settings override all."""
        return self.files.index(mark.file) if mark.file in self.files else len(self.files)

    def where(self, path: Path) -> str:
        """Return the place of a scene's value, given by its path, as `file:line:column`; "" if it is in no file."""
        mark = self.mark(path, on_key=True)
        if not mark.file:
            return ""
        text = f"{mark.file.replace(chr(92), '/').rsplit('/', 1)[-1]}:{mark.line}:{mark.column}"
        self.places.setdefault(text, path)
        return text

    def path_of(self, where: str) -> Path:
        """Return the path of the value at a place in the file; the inverse of the method `where`."""
        return self.places.get(where, ())


class _Composer(Composer):
    """YAML composer that refuses nodes that are nested too deeply, and too many nodes."""

    depth = count = 0

    def compose_node(self, parent: object, index: object) -> object:
        """Return the next node of the YAML text, as PyYAML asks for it."""
        self.count += 1
        if self.depth >= DEEPEST or self.count > 2 * MOST_VALUES:  # keys are nodes, too
            deep = f"nested deeper than {DEEPEST} levels"
            message = deep if self.depth >= DEEPEST else f"more than {MOST_VALUES} values"
            raise MarkedYAMLError(problem=message, problem_mark=self.parser.peek_event().start_mark)
        self.depth += 1
        node = super().compose_node(parent, index)
        self.depth -= 1
        return node


class _TooLong(Exception):
    """Raised if a scene has more values than allowed, for example through nested aliases."""


def read(text: str, name: str, root: FilePath | None = None) -> SourceText:
    """Parse a YAML text into data with places in the text; syntax errors become faults. `root`: folder of the scene."""
    found = _composed(text, name)
    data = mapped(found.data, lambda value, path: value)
    return SourceText(
        name, data, dict(found.keys), dict(found.values), list(found.faults), {}, root or FilePath(), (name,)
    )


def mapped(data: Data, made: Callable[[Data, Path], Data], path: Path = ()) -> Any:
    """Return data in which each scalar value is replaced by `made(value, path)`."""
    if isinstance(data, dict):
        return {key: mapped(each, made, (*path, key)) for key, each in data.items()}
    return [mapped(x, made, (*path, i)) for i, x in enumerate(data)] if isinstance(data, list) else made(data, path)


@lru_cache(maxsize=64)  # variants of a scene share its text, and settings among them theirs
def _composed(text: str, name: str) -> SourceText:
    source = SourceText(name)
    if len(text) > 2 * LARGEST:  # one that is merged of several
        source.fault((), f"a scene has at most {2 * LARGEST} characters", mark=Mark(name, 1, 1, ""))
        return source
    lines = text.splitlines() or [""]

    def at(line: int, column: int) -> Mark:
        line = min(line, len(lines) - 1)
        return Mark(name, line + 1, column + 1, lines[line])

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # an anchor may be used again
            yaml = YAML(typ="safe", pure=True)
            yaml.Composer = _Composer
            node = yaml.compose(text)
    except MarkedYAMLError as error:
        sentence, place = explained(error, lines)
        source.fault((), sentence, mark=at(*place))
        return source
    except ReaderError as error:
        sentence, place = unreadable(error, text)
        source.fault((), sentence, mark=at(*place))
        return source
    except YAMLError as error:
        source.fault((), f"this is not YAML: {' '.join(str(error).split())}", mark=at(0, 0))
        return source
    except (ValueError, RecursionError):  # a directive or an escape with numbers that are none
        source.fault((), "this is not YAML that can be read", mark=at(0, 0))
        return source
    source.values[()] = at(node.start_mark.line, node.start_mark.column) if node else at(0, 0)
    if not isinstance(node, MappingNode):
        source.fault((), "a scene is a mapping of keys, beginning with 'heavylift: 1'")
        return source

    def value_of(node: Node, path: Path, above: tuple[int, ...]) -> Data:
        source.values[path] = at(node.start_mark.line, node.start_mark.column)
        if len(source.values) > MOST_VALUES or len(path) > DEEPEST:
            raise _TooLong
        if id(node) in above:
            source.fault(path, "an alias must not contain itself")
            return None
        above = (*above, id(node))
        if isinstance(node, SequenceNode):
            return [value_of(child, (*path, i), above) for i, child in enumerate(node.value)]
        if isinstance(node, MappingNode):
            return mapping(node, path, above)
        return _scalar(node, path, source)

    known: dict[int, list[tuple[Node, Node]]] = {}

    def whole(node: MappingNode, path: Path) -> list[tuple[Node, Node]]:
        """Return the pairs (key, value) of a YAML mapping: its own pairs, then those merged by `<<: *name`."""
        if id(node) not in known:
            known[id(node)] = []  # what it would bring into itself
            below = [x for key, x in node.value if key.value == MERGE]
            pairs = [(key, x) for key, x in node.value if key.value != MERGE]
            for x in (x for one in below for x in (one.value if isinstance(one, SequenceNode) else [one])):
                words = {key.value for key, _ in pairs if isinstance(key, ScalarNode)}
                if isinstance(x, MappingNode):
                    pairs += [(key, y) for key, y in whole(x, path) if str(key.value) not in words]
                    continue
                mark = at(x.start_mark.line, x.start_mark.column)
                source.fault(path, "'<<' lays a mapping below this one, such as '<<: *name'", mark=mark)
            known[id(node)] = pairs
        return known[id(node)]

    def mapping(node: MappingNode, path: Path, above: tuple[int, ...]) -> dict[str, Data]:
        made: dict[str, Data] = {}
        for key, child in whole(node, path):
            mark = at(key.start_mark.line, key.start_mark.column)
            word = _line(key) if isinstance(key, ScalarNode) else None
            if word is None:
                source.fault(path, "a key must be a word", mark=mark)
            elif word in made:
                first = source.keys[(*path, word)].line
                message = f"the name '{word}' is given twice (first in line {first})"
                source.fault((*path, word), message, mark=mark)
            else:
                source.keys[(*path, word)] = mark
                made[word] = value_of(child, (*path, word), above)
        return made

    try:
        source.data = mapping(node, (), (id(node),))
    except _TooLong:
        source = SourceText(name, values={(): source.values[()]}, root=source.root)
        limits = f"more than {MOST_VALUES} values or more than {DEEPEST} levels of them"
        source.fault((), f"with its aliases, the scene has {limits}")
    return source


def _line(node: ScalarNode) -> str:
    """Return the text of a node as a single printable line."""
    text = str(node.value)
    if node.style in ("|", ">"):
        text = " ".join(text.splitlines())
    return printable(text.replace("\t", " "), keep=SPACES)


def _scalar(node: Node, path: Path, source: SourceText) -> str | int | float | bool | None:
    text = _line(node) if isinstance(node, ScalarNode) else str(node.value)
    kind = str(node.tag).rsplit(":", 1)[-1]
    if kind == "null":
        return None
    if kind == "bool":
        return text.lower() == "true"
    if kind in ("int", "float") and len(text) > MOST_DIGITS:
        source.fault(path, f"a number has at most {MOST_DIGITS} digits, this one has {len(text)}")
        return None
    try:
        if kind == "int":
            return int(text.replace("_", ""), 0 if text.lstrip("+-")[:2] in {"0x", "0o", "0b"} else 10)
        if kind == "float":
            return float(text.replace("_", "").lower().replace(".inf", "inf").replace(".nan", "nan"))
    except ValueError:  # a tag calls it a number
        source.fault(path, f"'{text}' is not a number")
        return None
    if isinstance(node, ScalarNode) and node.style in {"'", '"'}:  # the text begins after the quote
        mark = source.values[path]
        source.values[path] = Mark(mark.file, mark.line, mark.column + 1, mark.text)
    return text


def ordered(data: Data) -> Data:
    """Return data with all keys sorted by name, so that the order of keys in the text has no effect."""
    if isinstance(data, dict):
        return {key: ordered(data[key]) for key in sorted(data, key=natural)}
    return [ordered(each) for each in data] if isinstance(data, list) else data


def shown(path: Path) -> str:
    """Return a path in the form that users read: cranes.west.at, actions[3].all hooks."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text or "scene"


def child(at: Data, part: str | int) -> Data:
    """Return the element of a mapping or list by key or index; None if there is no such element."""
    if isinstance(at, dict):
        return at.get(str(part))
    return at[part] if isinstance(at, list) and isinstance(part, int) and part < len(at) else None
