"""Machine types as data: a file of bodies, joints, drives and hooks, with parameters that a scene may override.

    gather(source)     reads type files in the scene's own folder into its data, under `types`
    expand(source)     expands each crane of a scene by its type and parameters, under `machines`, and
                       gives each frame on a hook its parts
    library(), frames(), vessel_types()    the types that come with heavylift, by name

A value that begins with `=` is arithmetic over parameters (`expressions`); it becomes a quantity in SI units. Names of
parts get the name of the crane as prefix: `boom` of `west` is `west.boom`. The places of
values are kept, so that an error names the line of the type file, or of the scene if a parameter is overridden.
"""

from copy import deepcopy
from functools import lru_cache
from pathlib import Path as FilePath
from typing import Any

from heavylift.kernel.errors import SceneError
from heavylift.nodes.scenes import frames_folder, types_folder, vessels_folder
from heavylift.recordings.format.spellings import BEAM_TYPE, BEAMS, GIRDERS, old_parts, old_type

from .extending import fill_in, merged
from .faults import closest, raise_faults
from .files import content, within
from .source import Data, Path, SourceText, read
from .tables import charted
from .type_expansion import Expansion, MachineType

VERSION = 1


def library() -> dict[str, FilePath]:
    """Return the bundled machine types by name."""
    return {path.stem: path for path in sorted(types_folder().glob("*.yaml"))}


def frames() -> dict[str, FilePath]:
    """Return the bundled frame types by name."""
    return {path.stem: path for path in sorted(frames_folder().glob("*.yaml"))}


@lru_cache(maxsize=1)
def vessel_types() -> dict[str, dict[str, Any]]:
    """Return the bundled vessel types by name, each with a description and the default values of its keys."""
    found = sorted(vessels_folder().glob("*.yaml"))
    return {path.stem: dict(read(content(path).decode(), path.name).data) for path in found}


@lru_cache(maxsize=64)
def machine_type(name: str, frame: bool = False) -> MachineType:
    """Return a bundled type of a crane or frame; raises SceneError if there is none with this name."""
    known = frames() if frame else library()
    if name not in known:
        raise SceneError(f"there is no machine type '{name}': {closest(name, known)}")
    source = read(content(known[name]).decode(), f"{name}.yaml")
    raise_faults(source, source.faults)
    return extending(MachineType(name, source))


def extending(kind: MachineType) -> MachineType:
    """Return a machine type merged over the bundled type that it extends, if it extends one."""
    old = old_type(kind.source.data)
    base = kind.data.get("extends")
    if not isinstance(base, str):
        return kind
    below = deepcopy(machine_type(base, "frame type" in kind.data).source)
    theirs, own = below.data.get("hooks"), kind.data.get("hooks")
    if old and isinstance(own, dict) and isinstance(theirs, dict):  # which says where they are alone
        below.data["hooks"] = {name: next(iter(theirs.values())) for name in own}
    return MachineType(kind.name, merged(below, kind.source))


def gather(source: SourceText) -> None:
    """Read the machine type files that a scene refers to by path, with the places of all values in them."""
    own = source.data.get("types")
    types = dict(own) if isinstance(own, dict) else {}
    named = {str(entry.get("type")): at for at, entry in reversed([*_cranes(source), *_frames(source)])}
    found = sorted(name for name in named if name.endswith((".yaml", ".yml")))
    for name in found:
        if name in types:
            continue
        try:
            text = content(within(source.root, source.root / name)).decode("utf-8")
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else str(error)
            source.fault((*named[name], "type"), f"the type file '{name}' cannot be read: {reason}")
            continue
        inner = read(text, str(source.root / name))
        source.faults += inner.faults
        types[name] = dict(inner.data)
        source.keys |= {("types", name, *path): mark for path, mark in inner.keys.items()}
        source.values |= {("types", name, *path): mark for path, mark in inner.values.items()}
    if found:
        source.data["types"] = types
    charted(source)


def expand(source: SourceText) -> bool:
    """Replace each crane and frame by the parts of its type; return whether all expressions could be computed.

    Errors are added to the scene. Without all results, the data cannot be processed further."""
    computed = True
    own = source.data.pop("types", {})
    inline = own if isinstance(own, dict) else {}
    if inline is not own:
        source.fault(("types",), "a mapping of names to types is needed here")
    for at, entry in [*_cranes(source), *_frames(source)]:
        frame = at[0] != "cranes"
        word = entry.setdefault("type", BEAM_TYPE) if frame else entry.get("type")
        if not isinstance(word, str):
            if frame:
                source.fault((*at, "type"), "the name of a type is needed here, or of a file of one")
                computed = False
            continue
        try:
            kind = _inline(source, word, inline[word]) if word in inline else machine_type(word, frame)
        except SceneError:
            known = frames() if frame else library()
            source.fault((*at, "type"), f"'{word}' is not known here", closest(word, [*known, *inline]))
            del source.at(at[:-1])[at[-1]]  # type: ignore[union-attr, arg-type]
            continue
        header = "frame type" if frame else "machine type"
        if kind.data.get(header) != VERSION:
            message = f"'{word}' is not a {header}: such a file begins with '{header}: {VERSION}'"
            source.fault((*at, "type"), message)
            computed = False
            continue
        expansion = Expansion(source, at, entry, kind)
        if frame:
            expansion.attach(entry)
        else:
            expansion.run(entry)
        computed &= expansion.computed
    vessels = source.data.get("vessels")
    for name, given in vessels.items() if isinstance(vessels, dict) else ():
        if isinstance(given, dict) and "type" in given:
            _equip(source, ("vessels", name), given)
    machines = source.data.get("machines")
    for name in machines if isinstance(machines, dict) else ():
        _modern(source, ("machines", name))
    _modern(source, ("mechanism",))
    return computed


def _equip(source: SourceText, at: Path, entry: dict[str, Data]) -> None:
    """Give a vessel the keys of its type that it omits; a vessel whose motion is given does not float freely."""
    word, known = str(entry.pop("type")), vessel_types()
    if word not in known:
        source.fault((*at, "type"), f"'{word}' is no type of a vessel", closest(word, known))
        return
    omitted = ("motion", "floating") if entry.get("motion") == "given" else ()
    fill_in(source, {k: x for k, x in known[word]["vessel"].items() if k not in omitted}, ("types", word), entry, at)


def _modern(source: SourceText, base: Path) -> None:
    """Move parts that use former spellings to their present keys; their recorded places in the text stay."""
    parts: Any = source.at(base)
    for old, new in [*old_parts(parts)] if isinstance(parts, dict) else ():
        where: Path = (*base, *old)
        holder: Any = source.at(where[:-1])
        value, at = holder.pop(where[-1]), parts
        for key in new[:-1]:
            at = at.setdefault(key, {})
        at[new[-1]] = {**at[new[-1]], **value} if isinstance(value, dict) and new[-1] in at else value
        source.given[(*base, *new)] = source.written((*base, *old))
    if isinstance(parts, dict) and not parts.get(GIRDERS, True):
        del parts[GIRDERS]


def _inline(source: SourceText, name: str, data: Data) -> MachineType:
    """Return a type that is defined in the scene itself."""
    at: Path = ("types", name)
    keys, values = (
        {path[2:]: mark for path, mark in some.items() if path[:2] == at} for some in (source.keys, source.values)
    )
    return extending(MachineType(name, SourceText(name, data if isinstance(data, dict) else {}, keys, values)))


def _cranes(source: SourceText) -> list[tuple[Path, dict[str, Data]]]:
    cranes = source.data.get("cranes")
    return [(("cranes", n), c) for n, c in cranes.items() if isinstance(c, dict)] if isinstance(cranes, dict) else []


def _frames(source: SourceText) -> list[tuple[Path, dict[str, Data]]]:
    rig = source.data.get("rig")
    beams = rig.get(BEAMS) if isinstance(rig, dict) else None
    return [(("rig", BEAMS, n), b) for n, b in beams.items() if isinstance(b, dict)] if isinstance(beams, dict) else []
