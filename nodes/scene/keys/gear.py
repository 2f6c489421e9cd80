"""Rigging gear by ID: files of slings, shackles, spreaders and lifting beams in a scene's folder, and references to
them.

    gear: [slings.csv, shackles.yaml]
    rigging:
      legs: {on: jib main, to: [A, B], length: {gear: WR-48-8}, sling: {gear: WR-48-8}, shackle: {gear: SH-25}}
      beam: {type: spreader, gear: SB-20, points: {...}}

In a table the first column is the ID, and the others are keys with their units, such as `breaking [kN]`; a .yaml file
has the same keys below each ID. Keys written beside `gear` in the same file override the item, and the item overrides
the scene that the file extends. In the scene's data, `gear` then holds the items in use, each with the places where it
is used.
"""

from heavylift.kernel.errors import SceneError
from heavylift.nodes.scene.text.faults import closest, raise_faults
from heavylift.nodes.scene.text.files import content, within
from heavylift.nodes.scene.text.source import Data, Mark, Path, SourceText, read, shown
from heavylift.nodes.scene.text.table_files import table
from heavylift.recordings.format.spellings import BEAM

GEAR = "gear"
SLING = ("EA", "breaking", "WLL", "termination", "diameter")
FRAME = ("mass", "size")
USED = {"sling": SLING, "frame": FRAME, BEAM: ()}  # keys that each kind of place takes from an item


def geared(source: SourceText) -> None:
    """Replace references to rigging gear (`gear: ID`) by its data; raises SceneError with all errors found so far."""
    named, before = source.data.get(GEAR), len(source.faults)
    items: dict[str, dict[str, Data]] = {}
    for i, file in enumerate([named] if isinstance(named, str) else named if isinstance(named, list) else ()):
        try:
            for name, item in _items(source, str(file)).items():
                if name in items:
                    raise SceneError(f"{file} has the item '{name}', which another file has, too; rename one")
                items[name] = item
        except (SceneError, ValueError, OSError) as error:
            message = getattr(error, "strerror", None) or str(error)
            source.fault((GEAR, i) if isinstance(named, list) else (GEAR,), message)
    if isinstance(named, dict):
        items |= {name: item for name, item in named.items() if isinstance(item, dict)}
    raise_faults(source, source.faults[before:])
    used = {name: item for name, item in items.items() if item.get("at")}
    for key in ("rigging", "rig"):
        _walk(source, (key,), items, used)
    raise_faults(source, source.faults[before:])
    if used or named is not None:
        source.data[GEAR] = dict(used)


def _walk(source: SourceText, path: Path, items: dict[str, dict[str, Data]], used: dict[str, dict[str, Data]]) -> None:
    """Replace the references to gear at and below a path."""
    given = source.at(path)
    if not isinstance(given, dict):
        return
    for key in list(given):
        _walk(source, (*path, key), items, used)
    if GEAR not in given:
        return
    at, mark = (*path, GEAR), source.mark((*path, GEAR))
    name = str(given.pop(GEAR))
    item = items.get(name)
    if item is None:
        message = closest(name, items) if items else "name the files that hold it, 'gear: [slings.csv]'"
        source.fault(at, f"there is no gear '{name}'", message, mark=mark)
        return
    last = path[-1]
    places = item.setdefault("at", [])
    if isinstance(places, list) and shown(path) not in places:
        places.append(shown(path))
    used[name] = item
    if last in ("shackle", "length"):
        _whole(source, path, "WLL" if last == "shackle" else "length", item, name, mark)
        return
    kind = "sling" if last == "sling" else "frame" if path[0] == "rigging" else BEAM
    taken = {key: item[key] for key in USED[kind] if key in item}
    if kind != "sling" and "WLL" in item:
        taken["capacity"] = item["WLL"]
    if kind == "frame":
        taken["type"] = item.get("kind")
    own = [x for x in given if source.layer(source.mark((*path, x), on_key=True)) >= source.layer(mark)]
    for key in ("breaking", "EA") if kind == "sling" else ():
        if key not in item and key not in own:
            source.fault(at, f"the gear '{name}' has no '{key}'", mark=mark)
    for key in (key for key in taken if key not in own):
        given[key] = taken[key]
        source.keys[(*path, key)] = source.values[(*path, key)] = mark


def _whole(source: SourceText, path: Path, key: str, item: dict[str, Data], name: str, mark: Mark) -> None:
    """Replace the name of a gear item, written where a number is expected, by the item's value for this key."""
    if key not in item:
        source.fault(path, f"the gear '{name}' has no '{key}'", mark=mark)
        return
    parent = source.at(path[:-1])
    assert isinstance(parent, dict)
    parent[str(path[-1])] = item[key]


def _items(source: SourceText, file: str) -> dict[str, dict[str, Data]]:
    """Return the gear items in a file by ID."""
    if file.endswith((".yaml", ".yml")):
        own = read(content(within(source.root, source.root / file)).decode(), file)
        raise_faults(own, own.faults)
        source.files = (*source.files, file) if file not in source.files else source.files
        return {str(name): dict(item) for name, item in own.data.items() if isinstance(item, dict)}
    items = table(source.root, file)
    found: dict[str, dict[str, Data]] = {}
    for row in items.rows:
        name = row[0].text
        if name in found:
            raise SceneError(f"{file}:{row[0].mark.line}: the item '{name}' is listed twice; keep one")
        item: dict[str, Data] = {}
        for i in (i for i in range(1, len(row)) if row[i].text):
            column = items.head[i]
            if column.axis:
                size = item.setdefault(column.key, [])
                assert isinstance(size, list)
                size.append(items.text(row, i))
            else:
                item[column.key] = items.text(row, i)
        found[name] = item
    return found
