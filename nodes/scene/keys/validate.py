"""Validation of scene data by the pydantic models, whose errors become sentences with their place in the text.

pydantic reports all errors together; here each error gets its path in the file (without pydantic's own union tags), a
plain sentence and, for an unknown key or word, the nearest known one. `override` applies a setting, also to one number
of a list that the scene leaves at its default.
"""

from collections.abc import Iterator
from copy import deepcopy
from difflib import get_close_matches
from functools import reduce
from itertools import pairwise
from types import UnionType
from typing import Annotated, Union, get_args, get_origin

from heavylift.kernel.errors import SceneError
from heavylift.nodes.scene.text import overlay
from heavylift.nodes.scene.text.extending import alike
from heavylift.nodes.scene.text.faults import closest, raise_faults
from heavylift.nodes.scene.text.machine_types import expand, gather
from heavylift.nodes.scene.text.parameters import arithmetic
from heavylift.nodes.scene.text.source import Data, Fault, Path, SourceText, child, ordered, read
from heavylift.nodes.scene.text.tables import tabled
from heavylift.nodes.scene.text.uncertainty import Stated, separated
from heavylift.recordings.format.spellings import BEAMS
from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from .gear import geared
from .quantities import found_at, quantity, uncertainty_faults
from .schema import RESERVED, Scene

_PLAIN = {
    "string_type": "a word or text is needed here",
    "dict_type": "a mapping 'name: ...' is needed here",
    "model_type": "a mapping of keys is needed here",
    "model_attributes_type": "a mapping of keys is needed here",
    "tuple_type": "a list such as [1 m, 2 m, 3 m] is needed here",
    "list_type": "a list is needed here",
    "int_type": "a whole number is needed here",
    "int_parsing": "a whole number is needed here",
    "finite_number": "a whole number is needed here",
    "int_from_float": "a whole number is needed here",
    "bool_type": "true or false is needed here",
    "bool_parsing": "true or false is needed here",
}


def validate(source: SourceText) -> Scene | None:
    """Return the validated scene with expanded machines; None if it is invalid, with errors added to the scene.

    Uncertain numbers in the source's data are replaced by their nominal values."""
    stated = uncertainties(source)
    if not (arithmetic(source) and expand(source)):
        return None
    try:
        scene = Scene.model_validate(ordered(source.data))
    except ValidationError as error:
        # what is put at several places is reported once
        faults = [_fault(source, message) for message in error.errors(include_url=False)]
        sentence = {source.written(x.path): x for x in faults if source.written(x.path) != x.path}
        source.faults += [x for x in faults if sentence.get(source.written(x.path), x) is x]
        return None
    source.faults += [*_reserved(scene), *uncertainty_faults(scene, stated, source.given)]
    return scene


def validated(text: str, name: str) -> Scene:
    """Return the scene of a complete text; raises SceneError if the text is invalid."""
    source = read(text, name)
    scene = validate(source)
    raise_faults(source, source.faults)
    assert scene is not None
    return scene


def uncertainties(source: SourceText) -> dict[Path, Stated]:
    """Return the stated uncertainties of a scene by path, and replace uncertain numbers by nominal values. Instances
    under `lifts` state their own uncertainties and are not searched."""

    def is_text(path: Path) -> bool:
        inside = path[0] == "lifts" and path[2:3] not in (("at",), ("start",))
        return inside or ((found := _at(path)) != [] and all(each is str for each in found))

    return separated(source, is_text)


def _reserved(scene: Scene) -> Iterator[Fault]:
    """Yield errors for names of machines or groups that are keywords or names of parts of a run."""
    named: dict[Path, str] = {("cranes", name): name for name in scene.cranes}
    named |= {("machines", name): name for name in scene.machines if name not in scene.cranes}
    if scene.rig:
        named |= {("rig", BEAMS, name): name for name in scene.rig.beams}
        named |= {("rig", "groups", name): name for name in scene.rig.groups}
    named |= {("models", name): name for name in scene.models}
    for key in ("rigging", "blocks", "vessels", "obstacles"):
        named |= {(key, name): name for name in getattr(scene, key)}
    if scene.mechanism:
        named["mechanism", "name"] = scene.mechanism.name
    for path, name in named.items():
        if name in RESERVED and path != ("blocks", "block"):  # as that of an instance is
            message = f"the name '{name}' is reserved: choose another"
            yield Fault(path, message, on_key=path != ("mechanism", "name"))


def _key_of_action(word: str) -> str:
    """Return the key of an action that is most similar to a word; "" if none is."""
    return next(iter(get_close_matches(word.lower(), ("stage", "when", "timeout", "may touch", "wait"), 1, 0.75)), "")


def _fault(source: SourceText, error: ErrorDetails) -> Fault:
    path, kind, given = _path(source.data, error["loc"]), str(error["type"]), error.get("input")
    context = error.get("ctx") or {}
    last = str(path[-1]) if path else ""
    text = str(context.get("sentence", context.get("error", "")))
    if text.startswith(("an order begins", "write what to do")) and (near := _key_of_action(last)):
        return Fault(path, f"there is no '{last}' to give an order to", f"did you mean '{near}'?", on_key=True)
    if kind == "phrase":
        added = len(str(given)) - len(str(source.at(path)))  # `wait: 3 s` is read as the phrase 'wait 3 s'
        return Fault(path, context["sentence"], context["hint"], column=context["column"] - added)
    if kind == "extra_forbidden":
        return Fault(path, f"unknown key '{last}'", closest(last, _keys(error["loc"][:-1])), on_key=True)
    if kind == "missing":
        if path and isinstance(path[-1], int):
            return Fault(path[:-1], f"value number {path[-1] + 1} is missing here")
        return Fault(path, f"the key '{last}' is missing", on_key=True)
    if kind == "literal_error" and path == ("heavylift",):
        return Fault(path, f"this heavylift reads scenes of version 1, not {given}")
    if kind in {"literal_error", "union_tag_invalid"}:
        path = (*path, "type") if kind == "union_tag_invalid" else path
        words = _literals((*error["loc"], "type") if kind == "union_tag_invalid" else error["loc"])
        word = str(given.get("type") if isinstance(given, dict) else given)
        hint = f"can be asked: {', '.join(words)}" if path[0] == "ask" else closest(word, words)
        return Fault(path, f"'{word}' is not known here", hint)
    if kind == "union_tag_not_found":
        return Fault(
            path, "the key 'type' is missing", f"known: {', '.join(_literals((*error['loc'], 'type')))}", on_key=True
        )
    if kind == "too_long":
        most, count = context["max_length"], context["actual_length"]
        return Fault(path, f"{most} values are enough here, not {count}", _decimals(source.at(path)))
    if kind == "too_short":
        message = f"{context['min_length']} or more are needed here, not {context['actual_length']}"
        return Fault(path, message)
    if kind in {"greater_than_equal", "greater_than"}:
        return Fault(path, f"{next(iter(context.values()))} or more is needed here, not {given}")
    if kind == "less_than_equal":
        return Fault(path, f"{context['le']} or less is needed here, not {given}")
    if kind == "value_error" and error["loc"] and error["loc"][-1] == "[key]":
        return Fault(path, str(context["error"]), on_key=True)
    if kind == "value_error":
        return Fault(path, str(context["error"]))
    if kind in {"model_type", "model_attributes_type", "dict_type"} and isinstance(given, str):
        key = next((key for key in _keys(error["loc"]) if given.startswith(f"{key} ")), "")
        hint = f"is a colon missing: '{key}: {given[len(key) :].strip()}'?" if key else ""
        return Fault(path, _PLAIN[kind], hint)
    return Fault(path, _PLAIN.get(kind, str(error["msg"])))


def _decimals(values: Data) -> str:
    """Return a hint for a list with decimal commas: `[20,5 m, 16 m]` is read as three values."""
    each = values if isinstance(values, list) else []
    split = [(a, b) for a, b in pairwise(each) if isinstance(a, int) and isinstance(b, str) and b[:1].isdigit()]
    return f"a decimal has a point: write '{split[0][0]}.{split[0][1]}'" if split else ""


def _path(data: Data, loc: tuple[str | int, ...]) -> Path:
    """Return the path of an error without pydantic's union tags; a last key that is missing in the data is kept."""
    path: list[str | int] = []
    at = data
    for depth, part in enumerate(loc):
        last = depth == len(loc) - 1
        inside = (isinstance(at, dict) and part in at) or (
            isinstance(at, list) and isinstance(part, int) and part < len(at)
        )
        if inside:
            at = child(at, part)
            path.append(part)
        elif last and part != "[key]" and (isinstance(at, dict) or (isinstance(at, list) and isinstance(part, int))):
            path.append(part)
    return tuple(path)


def _models(annotation: object) -> list[object]:
    """Return the types in an annotation, without Annotated, None and unions."""
    origin = get_origin(annotation)
    if origin is Annotated:
        return _models(get_args(annotation)[0])
    if origin in {Union, UnionType}:
        return [m for part in get_args(annotation) for m in _models(part)]
    return [annotation]


def _down(found: list[object], part: str | int) -> list[object]:
    below: list[object] = []
    for each in found:
        if isinstance(each, type) and issubclass(each, BaseModel):
            fields = {f.alias or name: f.annotation for name, f in each.model_fields.items()}
            below += _models(fields[str(part)]) if part in fields else []
        elif get_origin(each) in {dict, list}:
            below += _models(get_args(each)[-1])
        elif get_origin(each) is tuple and get_args(each)[-1] is Ellipsis:
            below += _models(get_args(each)[0])
    if not below:  # a union tag names one of the models
        return [m for m in found if part in _tags(m)]
    return below


def _tags(model: object) -> tuple[object, ...]:
    kind = getattr(model, "model_fields", {}).get("type")
    return get_args(kind.annotation) if kind else ()


def _at(loc: tuple[str | int, ...]) -> list[object]:
    """Return the models and types that are possible at a location."""
    return reduce(_down, loc, [Scene])


def _keys(loc: tuple[str | int, ...]) -> list[str]:
    return [f.alias or name for m in _at(loc) for name, f in getattr(m, "model_fields", {}).items()]


def _literals(loc: tuple[str | int, ...]) -> list[str]:
    return [str(word) for each in _at(loc) for word in get_args(each)]


def override(source: SourceText, setting: str) -> None:
    """Apply one setting `dotted.path=text` to the scene; later errors in this value refer to the setting."""
    overlay.override(source, setting, default_list)


def default_list(source: SourceText, path: Path) -> list[Data] | None:
    """Return the default list of numbers or words at a path that the scene does not set; None for other defaults."""
    trial = deepcopy(source)
    try:
        alike(trial)
        tabled(trial)
        geared(trial)
        gather(trial)
        scene = validate(trial)
    except SceneError:  # which is reported when the scene is built
        return None
    at, kind = found_at(scene, path) or (None, None)
    return listed(at, kind) if isinstance(at, tuple | list) else None


def listed(at: tuple[object, ...] | list[object], kind: object) -> list[Data] | None:
    """Return a list in the form in which scenes write it; None unless all its elements are numbers or words."""
    found = quantity(kind)
    si = next((unit for unit, factor in found.dimension.units.items() if factor == 1), "") if found else ""
    written: list[Data] = []
    for x in at:
        if not isinstance(x, int | float | str):
            return None
        written.append(x if found is None or isinstance(x, str | bool) else f"{x!r} {si}".strip())
    return written
