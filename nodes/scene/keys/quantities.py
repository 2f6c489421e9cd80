"""The quantity at a path of a scene: its value, and the dimension with which the models of the keys read it."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, get_args, get_origin

from heavylift.nodes.scene.text.expressions import dimension_of, value_of
from heavylift.nodes.scene.text.source import Fault, Path
from heavylift.nodes.scene.text.uncertainty import Stated, standard
from heavylift.nodes.scene.text.units import Quantity
from pydantic import BaseModel

from .base import written

MADE = "parts", "parameters"  # keys that types write
Kind = Any  # annotation of a key, with its metadata


def below(at: object, kind: Kind) -> dict[str | int, tuple[object, Kind]]:
    """Return the value and type annotation of each element of a part of a scene, by key or index."""
    if isinstance(at, BaseModel):
        fields = type(at).model_fields.items()
        found = {f.alias or written(name): (getattr(at, name), (f.annotation, *f.metadata)) for name, f in fields}
        return {key: x for key, x in found.items() if key not in MADE} | _parameters(at)
    if isinstance(at, Mapping):
        return {str(key): (value, kind) for key, value in at.items()}
    if isinstance(at, list | tuple):
        return {i: (value, _element(kind, len(at), i)) for i, value in enumerate(at)}
    return {}


def _parameters(at: BaseModel) -> dict[str | int, tuple[object, Kind]]:
    """Return the parameters of a machine type that are quantities, or places and ranges made of quantities."""
    found: dict[str | int, tuple[object, Kind]] = {}
    for key, text in getattr(at, "parameters", {}).items():
        values = [(value_of(x), dimension_of(x)) for x in (text if isinstance(text, list) else [text])]
        known = [(value.number, Quantity(kind)) for value, kind in values if value and kind]
        if isinstance(text, list) and len(known) == len(values):
            kinds = tuple(Annotated[float, kind] for _, kind in known)
            found[key] = tuple(number for number, _ in known), tuple[kinds]  # type: ignore[valid-type]
        else:
            found[key] = known[0] if known else (text, None)
    return found


def quantity(kind: Kind) -> Quantity | None:
    """Return the first quantity in a type annotation, at any depth; None if the annotation contains none."""
    found: Quantity | None = _deep(kind, lambda each: each if isinstance(each, Quantity) else None)
    return found


def found_at(scene: object, path: Path) -> tuple[object, Kind] | None:
    """Return the value and type annotation at a path of a scene; None if the path does not exist."""
    at, kind = scene, None
    for part in path:
        inside = below(at, kind)
        if part not in inside:
            return None
        at, kind = inside[part]
    return at, kind


def quantity_at(scene: BaseModel, path: Path) -> tuple[float, Quantity] | None:
    """Return the value in SI units at a path of a scene, and its quantity; None if there is no quantity.

    For a place, the quantity is that of its first coordinate."""
    at, kind = found_at(scene, path) or (None, None)
    if isinstance(at, tuple) and at:
        at = at[0]
    found = quantity(kind)
    if found is None or isinstance(at, bool) or not isinstance(at, int | float):
        return None
    return float(at), found


def uncertainty_faults(scene: BaseModel, stated: Mapping[Path, Stated], given: Mapping[Path, Path]) -> list[Fault]:
    """Return an error for each stated uncertainty that does not belong to a quantity, or is invalid for its quantity.

    `given`: see `SourceText.given`."""
    faults, put = [], {written: at for at, written in given.items()}
    for path, each in stated.items():
        at = put.get(path, path)
        found = quantity_at(scene, at if at[0] == "machines" else path)
        try:
            if found is None:
                raise ValueError("this value cannot be uncertain; write it without '+-', 'sd' or '..'")
            standard(each, found[1])
        except ValueError as error:
            faults.append(Fault(path, str(error)))
    return faults


def _element(kind: Kind, n: int, i: int) -> Kind:
    """Return the annotation of element i of n: in a tuple that of the element, else the common one."""

    def own(each: Kind) -> Kind | None:
        origin: object = get_origin(each)
        args = get_args(each) if origin is tuple else ()
        return args[i] if len(args) == n and Ellipsis not in args else None

    return _deep(kind, own) or kind


def _deep(kind: Kind, found: Callable[[Kind], Any]) -> Any:
    """Return the first result that a function finds for an annotation or one of its parts."""
    result = found(kind)
    if result is not None:
        return result
    parts = kind if isinstance(kind, tuple) else get_args(kind)
    return next((result for part in parts if (result := _deep(part, found)) is not None), None)
