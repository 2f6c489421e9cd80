"""Scenes that extend others: the data of a scene are merged over those of the scene that it extends; entries that are
`like` other entries.

An entry with `like` contains only the differences: `two: {like: one, hook: west H2, lugs: [A3, A4]}`.
"""

from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path as FilePath

from heavylift.kernel.errors import SceneError
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.files import scene_text, within
from heavylift.nodes.scene.text.source import Data, Path, SourceText, read
from heavylift.nodes.scenes import bundled
from heavylift.recordings.format.spellings import BEAMS

ENDINGS = (".yaml", ".yml", ".json")
LONGEST_CHAIN = 20  # of files that extend one another
LIKE = "like"
SECTIONS: tuple[Path, ...] = (
    *((key,) for key in ("blocks", "cranes", "rigging", "edges", "vessels", "obstacles", "lifts", "interlocks")),
    *(("mechanism", key) for key in ("bodies", "joints", "ropes", "drives", "springs", "supports", "forces", "hooks")),
    ("rig", BEAMS),
)  # whose entries may be like others


def extended(path: FilePath, name: str, text: str, root: FilePath, above: tuple[FilePath, ...] = ()) -> SourceText:
    """Return the data of a file merged over the file that it extends.

    The extended file must be in the folder `root` or bundled with heavylift."""
    return over(read(text, name, root), path, root, above)


def over(source: SourceText, path: FilePath, root: FilePath, above: tuple[FilePath, ...] = ()) -> SourceText:
    """Return the data of a scene or type merged over the file that its key `extends` names."""
    base = source.data.pop("extends", None)
    if base is None:
        return source
    at = ("extends",)
    here = (*above, path.resolve())
    if not isinstance(base, str):
        source.fault(at, "write the path of a scene, such as 'extends: lift.yaml'")
        return source
    below = path.parent / base
    try:
        if base in bundled() and not (below.suffix in ENDINGS and below.is_file()):
            below, root = bundled()[base], bundled()[base].parent
        elif below.suffix not in ENDINGS:
            message = f"'{base}' is neither a file .yaml nor the name of a bundled scene: {closest(base, bundled())}"
            raise SceneError(message)
        real = within(root, below)
        if real in here:
            raise SceneError(f"'{base}' extends itself in a circle")
        if len(above) > LONGEST_CHAIN:
            raise SceneError(f"more than {LONGEST_CHAIN} files extend one another")
        name_below = below.name if below in bundled().values() else str(below)  # however the path above is written
        under = extended(below, name_below, scene_text(real, base), root, here)
    except (SceneError, ValueError) as error:
        source.fault(at, str(error))
        return source
    return merged(under, source)


def alike(source: SourceText) -> None:
    """Complete each entry that has the key `like` by keys of the entry that `like` names; errors go to the scene."""
    for section in SECTIONS:
        entries = source.at(section)
        if isinstance(entries, dict):
            for name in entries:
                _like(source, section, entries, name, ())


def _like(source: SourceText, section: Path, entries: dict[str, Data], name: str, above: tuple[str, ...]) -> None:
    own, path = entries.get(name), (*section, name)
    if not isinstance(own, dict) or LIKE not in own:
        return
    other, at = own[LIKE], (*path, LIKE)
    if not isinstance(other, str) or other not in entries or other in (name, *above):
        circle = other in (name, *above)
        hint = "" if circle else closest(str(other), [x for x in entries if x != name])
        source.fault(
            at, f"'{name}' refers to itself by 'like'" if circle else f"there is no '{other}' here to be like", hint
        )
    else:
        _like(source, section, entries, other, (*above, name))
        fill_in(source, entries[other], (*section, other), own, path)
    del own[LIKE]


def fill_in(source: SourceText, theirs: Data, there: Path, own: dict[str, Data], here: Path) -> None:
    """Add the missing keys to an entry by copying them from another entry, together with their places in the text."""
    for key, value in theirs.items() if isinstance(theirs, dict) else ():
        mine = own.get(key)
        if isinstance(mine, dict) and isinstance(value, dict):
            fill_in(source, value, (*there, key), mine, (*here, key))
        elif key not in own and key != LIKE:
            own[key] = deepcopy(value)
            n = len(there) + 1
            for marks in (source.keys, source.values):
                marks |= {(*here, *at[n - 1 :]): mark for at, mark in marks.items() if at[:n] == (*there, key)}


def merged(below: SourceText, above: SourceText) -> SourceText:
    """Return the scene or type `below` with `above` merged over it.

    Mappings are merged key by key; lists and values are replaced."""
    keys, values = dict(below.keys), dict(below.values)
    found = SourceText(
        above.name, below.data, keys, values, below.faults + above.faults, {}, above.root, below.files + above.files
    )
    laid = _overlay(found, above, below.data, above.data, ())
    found.data = laid if isinstance(laid, dict) else {}
    found.values[()] = above.mark(())
    return found


def _overlay(merged: SourceText, upper: SourceText, below: Data, above: Data, path: Path) -> Data:
    if isinstance(below, dict) and isinstance(above, dict):
        joined = dict(below)
        for key, value in above.items():
            joined[key] = _overlay(merged, upper, below.get(key), value, (*path, key))
        if path:
            _take(merged, upper, path)
        return joined
    forget(merged, path, below)
    for found in _paths(above, path):
        _take(merged, upper, found)
    return above


def _take(merged: SourceText, upper: SourceText, path: Path) -> None:
    if path in upper.values:
        merged.values[path] = upper.values[path]
    if path in upper.keys:
        merged.keys[path] = upper.keys[path]


def forget(source: SourceText, path: Path, value: Data) -> None:
    """Delete the recorded places in the file of a value and of all values inside it."""
    for found in _paths(value, path):
        source.keys.pop(found, None)
        source.values.pop(found, None)


def _paths(value: Data, path: Path) -> Iterator[Path]:
    """Yield the paths of a value and of all values in it."""
    yield path
    below = value if isinstance(value, dict) else dict(enumerate(value)) if isinstance(value, list) else {}
    for key, each in below.items():
        yield from _paths(each, (*path, key))
