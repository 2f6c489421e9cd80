"""Changes of a scene file: only what is changed is written anew, so comments, order and layout of all else stay.

An edit is a path of keys and numbers with the value as YAML, as after `--set`; without a value it removes the entry.
It is made in the text at the marks of ruamel's nodes, then read back: all other values must be as before.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from copy import deepcopy
from pathlib import Path
from typing import Any, TypeAlias

from heavylift.kernel.errors import SceneError
from heavylift.nodes.scene.text.files import content
from heavylift.nodes.scene.text.source import Data, read, shown
from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError
from ruamel.yaml.nodes import CollectionNode, MappingNode, Node, SequenceNode

Keys: TypeAlias = tuple[str | int, ...]


def version_of(text: str) -> str:
    """Return a hash of a text, by which the workbench recognises that a file has changed."""
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def edited(text: str, path: Sequence[str | int], value: str | None) -> str:
    """Return the text of a scene after setting the value at a path, or removing that path; raises SceneError."""
    keys = tuple(path)
    if not keys:
        raise SceneError("an edit must name the key to change")
    before = _data(text)
    if value is None:
        return _checked(text, _removed(text, keys), before, keys, None)
    value = value.strip()
    wanted = _value(value, keys)
    for written in (value, _quoted(value)) if isinstance(wanted, str) else (value,):
        changed = _written(text, keys, written)
        with suppress(SceneError):
            return _checked(text, changed, before, keys, wanted)
    raise SceneError(f"{shown(keys)}: '{value}' cannot be inserted here; change the text of the scene")


def reordered(text: str, path: Sequence[str | int], to: int) -> str:
    """Return the text with one item of a list, including its comments, moved to index `to`; the list must be in block
    style."""
    *above, at = keys = tuple(path)
    nodes, known = _found(text, keys)
    if known < len(keys) or not isinstance(nodes[-2], SequenceNode) or not isinstance(at, int):
        raise SceneError(f"{shown(keys)}: this is not an item of a list, so it has no order")
    items, before = nodes[-2].value, _data(text)
    if nodes[-2].flow_style or not 0 <= to < len(items):
        raise SceneError(f"{shown(keys)}: a list in this form cannot be reordered here; change the text of the scene")
    starts = [_line_start(text, int(item.start_mark.index)) for item in items]
    starts[1:] = [_with_comment(text, start) for start in starts[1:]]
    ends = [*starts[1:], min(_line_end(text, _end(items[-1])) + 1, len(text))]
    parts = [text[start:end].rstrip("\n") + "\n" for start, end in zip(starts, ends, strict=True)]
    parts.insert(to, parts.pop(at))
    changed = text[: starts[0]] + "".join(parts) + text[ends[-1] :]
    expected = deepcopy(before)
    listed: Any = expected
    for key in above:
        listed = listed[key]
    listed.insert(to, listed.pop(at))
    if _data(changed) != expected:
        raise SceneError(f"{shown(keys)}: a list in this form cannot be reordered here; change the text of the scene")
    return changed


def write(path: Path, text: str, version: str) -> None:
    """Replace a file atomically if its present text has this version; raises SceneError if it has another."""
    if version_of(present(path)) != version:
        raise SceneError(f"{path.name} was changed elsewhere in the meantime; repeat the edit on the new text")
    descriptor, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8", newline="") as file:
            file.write(text)
        with suppress(OSError):
            os.chmod(name, path.stat().st_mode)
        os.replace(name, path)
    except OSError:
        with suppress(OSError):
            os.unlink(name)
        raise


def present(path: Path) -> str:
    """Return the text of a scene file with its line ends; raises SceneError if it cannot be read."""
    try:
        return content(path).decode("utf-8")
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise SceneError(f"{path.name} cannot be read: {reason}") from None


def _data(text: str) -> Data:
    source = read(text, "scene.yaml")
    if source.faults:
        line = source.faults[0].mark.line if source.faults[0].mark else 1
        raise SceneError(f"line {line} of the scene has a fault; correct the text first")
    return source.data


def _value(value: str, keys: Keys) -> Data:
    """Return the value that a text means inside a flow collection or on its own."""
    if "\n" in value:
        raise SceneError(f"{shown(keys)}: a value must be a single line")
    source = read(f"value: {value or chr(39) * 2}\n", "value")
    if value[:1] not in ("[", "{", "'", '"') and (source.faults or " #" in value):
        return value
    if source.faults:
        raise SceneError(f"{shown(keys)}: '{value}': {source.faults[0].sentence}")
    return source.data["value"]


def _quoted(value: str) -> str:
    return "'" + value.strip("'\"").replace("'", "''") + "'"


def _checked(text: str, changed: str, before: Data, keys: Keys, wanted: Data) -> str:
    """Return the changed text; raises SceneError if its data differ from the former data in more than the wanted
    value."""
    expected = deepcopy(before)
    at: Any = expected
    for key in keys[:-1]:
        if isinstance(at, dict) and at.get(key) is None:
            at[key] = {}
        at = at[key]
    if wanted is None:
        del at[keys[-1]]
    elif isinstance(at, list) and keys[-1] == len(at):
        at.append(wanted)
    else:
        at[keys[-1]] = wanted
    if _plain(_data(changed)) != _plain(expected):
        raise SceneError(f"{shown(keys)}: this entry cannot be changed in a form; change the text of the scene")
    return changed


def _plain(data: Data) -> Data:
    """Return data in which empty collections are replaced by None."""
    if isinstance(data, dict):
        return {key: _plain(value) for key, value in data.items()} or None
    return [_plain(value) for value in data] or None if isinstance(data, list) else data


# ---- in the text ---------------------------------------------------------------------------------------------


def _found(text: str, keys: Keys) -> tuple[list[Node], int]:
    """Return the nodes along a path from the root, as far as they exist in the text, and the number of path keys that
    were found."""
    try:
        nodes = [YAML(typ="safe", pure=True).compose(text)]
    except YAMLError:
        raise SceneError("the text of the scene is not valid YAML; correct it first") from None
    for number, key in enumerate(keys):
        child = _child(nodes[-1], key)
        if child is None:
            return nodes, number
        nodes.append(child)
    return nodes, len(keys)


def _child(node: Node, key: str | int) -> Node | None:
    if isinstance(node, MappingNode):
        return next((x for k, x in node.value if k.value == key), None)
    if isinstance(node, SequenceNode) and isinstance(key, int) and key < len(node.value):
        child: Node = node.value[key]
        return child
    return None


def _end(node: Node) -> int:
    """Return the index at which the text of a node ends."""
    if not isinstance(node, CollectionNode) or node.flow_style:
        return int(node.end_mark.index)
    inner = [x for pair in node.value for x in (pair if isinstance(pair, tuple) else (pair,))]
    return max((_end(x) for x in inner), default=int(node.start_mark.index))


def _written(text: str, keys: Keys, value: str) -> str:
    nodes, known = _found(text, keys)
    node = nodes[-1]
    start, end = int(node.start_mark.index), _end(node)
    indent, plain = " " * int(node.start_mark.column), value
    for key in reversed(keys[known + 1 :]):
        value = "{" + f"{_key(key)}: {value}" + "}"
    if known == len(keys):
        return text[:start] + value + text[end:] if start < end else text[:start] + f" {value}" + text[start:]
    key = keys[known]
    if not isinstance(node, CollectionNode):  # nothing but a key is written of it yet
        if not str(node.tag).endswith(":null"):
            raise SceneError(f"{shown(keys)}: {shown(keys[:known])} is a value, which has no keys")
        return f"{text[:start].rstrip(' ')} {{{_key(key)}: {value}}}{text[end:]}"
    if key != len(node.value) if isinstance(node, SequenceNode) else not isinstance(key, str):
        raise SceneError(f"{shown(keys)}: give the number of an item in a list, or a key in a mapping")
    entry = value if isinstance(node, SequenceNode) else f"{_key(key)}: {value}"
    if node.flow_style:
        comma = ", " if node.value else ""
        inside = text[: end - 1].rstrip()
        return f"{inside}{comma}{entry}{text[end - 1 :]}"
    line = _line_end(text, end if known or isinstance(node, SequenceNode) else _before(text, node, str(key)))
    if isinstance(node, SequenceNode):
        return f"{text[:line]}\n{indent}- {entry}{text[line:]}"
    steps = [f"\n{indent}{'  ' * i}{_key(key)}:" for i, key in enumerate(keys[known:])]
    return f"{text[:line]}{''.join(steps)} {plain}{text[line:]}"


def _before(text: str, node: CollectionNode, key: str) -> int:
    """Return the index after the last existing key that the schema orders before a new top-level key; without one, the
    end of the scene."""
    from heavylift.nodes.scene.keys.schema import Scene  # it takes a second to import

    order = [x.replace("_", " ") for x in Scene.model_fields]
    earlier = order[: order.index(key)] if key in order else order
    ends = [_end(value) for name, value in node.value if name.value in earlier]
    return len(text[: max(ends)].rstrip()) if ends else _end(node)


def _key(key: str | int) -> str:
    text = str(key)
    plain = text and text.strip() == text and not set(text) & set(":#,[]{}&*!|>'\"%@`")
    return text if plain else _quoted(text)


def _removed(text: str, keys: Keys) -> str:
    nodes, known = _found(text, keys)
    if known < len(keys):
        raise SceneError(f"{shown(keys)}: the scene has no such entry to remove")
    parent, gone = nodes[-2], nodes[-1]
    assert isinstance(parent, CollectionNode)
    entries = [(pair[0], pair[1]) if isinstance(pair, tuple) else (pair, pair) for pair in parent.value]
    number = next(i for i, (_, x) in enumerate(entries) if x is gone)
    start, end = int(entries[number][0].start_mark.index), _end(gone)
    if len(entries) == 1:
        first = int(parent.start_mark.index)
        return text[:first] + ("[]" if isinstance(parent, SequenceNode) else "{}") + text[_end(parent) :]
    after = int(entries[number + 1][0].start_mark.index) if number + 1 < len(entries) else None
    before = _end(entries[number - 1][1]) if number else None
    if parent.flow_style:
        return text[:start] + text[after:] if after is not None else text[:before] + text[end:]
    line = _line_start(text, start)
    lead = text[line:start]
    if lead.strip() in ("", "-" if isinstance(parent, SequenceNode) else ""):
        return text[:line] + text[min(_line_end(text, end) + 1, len(text)) :]
    assert after is not None  # the first key behind a dash: the next one takes its place
    return text[:start] + text[after:]


def _line_start(text: str, at: int) -> int:
    return text.rfind("\n", 0, at) + 1


def _with_comment(text: str, start: int) -> int:
    """Return the index at which the comment directly above a line begins, or that of the line if there is no
    comment."""
    while start and text[(above := _line_start(text, start - 1)) : start].lstrip().startswith("#"):
        start = above
    return start


def _line_end(text: str, at: int) -> int:
    found = text.find("\n", at)
    return found if found >= 0 else len(text)
