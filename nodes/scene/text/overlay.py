"""Settings from the command line, applied to the data of a scene.

A path is written as in error messages: `cranes.west.at`, `actions[2].all hooks`, or, for a part made by a type,
`machines.jib.hooks.jib.main.speed`. In addition, `block.com.x` is the first coordinate of a place, `stage up/all hooks`
is a key of the action with that stage, and `stage up/all hooks/by` is the quantity after the word `by` in an order.
"""

import re
from collections.abc import Callable, Container
from copy import deepcopy

from .extending import forget
from .faults import closest
from .machine_types import expand
from .source import DEEPEST, Data, Mark, Path, SourceText, child, read
from .spelling import NUMBER

AXES = {"x": 0, "y": 1, "z": 2}
STAGE = re.compile(r"\s*stage\s+([^/]+?)\s*/\s*(.+)")
PART = re.compile(r"[^./\[\]]+")


def override(source: SourceText, setting: str, default: Callable[[SourceText, Path], list[Data] | None]) -> None:
    """Apply one setting `dotted.path=text` to the scene; later errors in this value refer to the setting.

    `default`: function that returns the list at a path that the scene does not set."""
    dotted, equals, text = setting.partition("=")
    file = "--set"
    path = path_in(source, dotted)
    mark = Mark(file, 1, len(dotted) + 2 + len(text) - len(text.lstrip()), setting)
    if not equals or not dotted.strip():
        source.fault((), "write a setting as key=value", mark=Mark(file, 1, 1, setting))
        return
    if (named := STAGE.fullmatch(dotted)) and path[:1] != ("actions",):
        stages = [stage for stage in _stages(source) if stage]
        message = f"there is no stage '{named[1]}'" if stages else "the scene has no stages"
        source.fault((), message, closest(named[1], stages), mark=Mark(file, 1, 1, setting))
        return
    inner = read(f"value: {text.strip()}", file)
    if inner.faults:
        source.fault(path, inner.faults[0].sentence, mark=mark)
        return
    if len(path) > DEEPEST:
        source.fault((), f"a setting has at most {DEEPEST} levels, this one has {len(path)}", mark=mark)
        return
    at: Data = source.data
    for depth, part in enumerate(path[:-1]):
        below = child(at, part)
        if below is None and isinstance(at, dict) and isinstance(part, str):
            after = path[depth + 1]
            if isinstance(after, int) or (after in AXES and depth + 2 == len(path)):
                usual = default(source, path[: depth + 1])
                if usual is None:
                    whole = ".".join(map(str, path[: depth + 1]))
                    message = (
                        f"one number of '{whole}' cannot be set, the scene has none: set it whole, '{whole}=[...]'"
                    )
                    source.fault((), message, mark=Mark(file, 1, 1, setting))
                    return
                below = at[part] = usual
                place = AXES.get(str(after), after) if len(usual) == len(AXES) else after
                path = (*path[: depth + 1], place, *path[depth + 2 :])
            else:
                below = at[part] = {}
            source.keys[path[: depth + 1]] = Mark(file, 1, 1, setting)
        at = below
    last, value = path[-1], inner.data["value"]
    if isinstance(at, str) and (answer := _said(at, str(last), text.strip())):
        override(source, f"{'.'.join(map(str, path[:-1]))}={answer}", default)
        return
    forget(source, path, child(at, last))
    match at, last:
        case dict(), str():
            at[last] = value
        case list(), int() if last < len(at):
            at[last] = value
        case _:
            source.fault(path, f"the scene has no place '{dotted}'", mark=Mark(file, 1, 1, setting))
            return
    source.keys[path] = Mark(file, 1, 1, setting)
    for below_path in inner.values:
        if below_path:
            source.values[(*path, *below_path[1:])] = mark


def path_in(source: SourceText, text: str) -> Path:
    """Return the path in the data of a scene for a path in the user's spelling."""
    path: list[str | int] = []
    if (named := STAGE.fullmatch(text)) and named[1] in (stages := _stages(source)):
        path, text = ["actions", stages.index(named[1])], named[2]
    words = parts(text)
    source = made(source) if words[:1] == ["machines"] else source
    while words:
        at = source.at(tuple(path))
        part = next_key(words, at if isinstance(at, dict) else ())
        place = isinstance(at, list) and len(at) == len(AXES) and part in AXES
        path.append(AXES[part] if place else int(part) if part.isdecimal() and len(part) < 10 else part)
    return tuple(path)


def made(source: SourceText) -> SourceText:
    """Return a copy of the data of a scene in which machines are expanded to their parts."""
    copy = deepcopy(source)
    expand(copy)
    return copy


def parts(text: str) -> list[str]:
    """Return a path that a user has written as a list of keys and indices."""
    return [word.strip() for word in PART.findall(text)]


def next_key(words: list[str], known: Container[object]) -> str:
    """Remove and return the next key of a path: the longest known key (which may contain dots), or else one word."""
    n = next((n for n in range(len(words), 1, -1) if ".".join(words[:n]) in known), 1)
    key, words[:] = ".".join(words[:n]), words[n:]
    return key


def _stages(source: SourceText) -> list[str]:
    """Return the name of the stage of each action; "" for an action without one."""
    actions = source.data.get("actions")
    return [
        str(action.get("stage", "")) if isinstance(action, dict) else ""
        for action in (actions if isinstance(actions, list) else ())
    ]


def _said(phrase: str, word: str, text: str) -> str:
    """Return the phrase with the quantity after `word` replaced by `text`; "" if the word is not in it."""
    found, count = re.subn(rf"(\b{re.escape(word)}\s+){NUMBER}\s*[^\s\d]*", lambda m: m[1] + text, phrase, count=1)
    return found if count else ""
