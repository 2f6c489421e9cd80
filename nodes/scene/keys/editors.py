"""The JSON Schema of scene files, for editors: keys with units, defaults and meanings.

It is generated from the pydantic models that read scenes, so it is always up to date. Editors use it for completion and
for checks while typing; everything else (names, physics, phrases of the action list) is checked by `heavylift check`.
"""

from collections.abc import Iterator
from typing import Any

from heavylift.nodes.scene.text import units as u
from heavylift.nodes.scene.text.expressions import dimension_of
from heavylift.nodes.scene.text.extending import SECTIONS
from heavylift.nodes.scene.text.machine_types import library, machine_type, vessel_types
from heavylift.nodes.scene.text.type_expansion import MachineType
from heavylift.recordings.format.spellings import BEAM_TYPE, BEAMS

from .base import Base, comments
from .quantities import MADE
from .schema import Scene

Schema = dict[str, Any]
FIRST_UNIT = {dimension.name: next(iter(dimension.units.items())) for dimension in u.NAMED.values()}
ALIKE = {
    "type": "object",
    "description": "another entry with differences",
    "properties": {"like": {"type": "string"}},
    "required": ["like"],
}
ANSWERS = "rows of a table, such as barge.csv#loaded; columns period [s], heading [deg], surge [m/m], surge phase [deg]"
SHORT = {  # what a scene may write shorter than its models require
    "ActionLine": {"type": "string", "pattern": "^wait ", "description": "only wait, such as 'wait 60 s'"},
    "Process": {"type": "array", "items": {"type": "string"}, "description": "nodes of a process on this host"},
}
FILES = ({"type": "string"}, {"type": "array", "items": {"type": "string"}})
GEAR = "its item of the scene's gear, by ID"
TABLES = {  # out of which a block may take what it needs
    "from": "a row of a table beside the scene, such as blocks.csv#B17; its heads name keys with units: mass [t]",
    "lugs from": "the block's lugs in a table, such as lugs.csv#B17; columns block, name, x [m], y [m], z [m]",
}


def json_schema() -> Schema:
    """Return the JSON Schema of scene files as plain data."""
    schema = Scene.model_json_schema(by_alias=True)
    definitions = schema["$defs"]
    meanings = {model.__name__: comments(model) for model in _models(Base)}
    for name, part in {"Scene": schema, **definitions}.items():
        comment = meanings.get(name.rpartition("__")[2], {})
        for key, value in part.get("properties", {}).items():
            part["properties"][key] = _readable(value, comment.get(key, ""))
    for name, short in SHORT.items():
        definitions[name] = {"anyOf": [definitions[name], short]}
    crane = definitions["CraneKeys"]
    crane["properties"] = own = {key: value for key, value in crane["properties"].items() if key not in MADE}
    own["type"] = {**own["type"], "anyOf": [{"enum": [*library()]}, {"type": "string"}]}
    del crane["additionalProperties"]
    crane["allOf"] = [
        {
            "if": {"properties": {"type": {"const": name}}},
            "then": {
                "description": f"{kind.about('about')}; {kind.about('capacity')}",
                "properties": own | _parameters(kind),
                "additionalProperties": False,
            },
        }
        for name, kind in ((name, machine_type(name)) for name in library())
    ]
    for first, *rest in SECTIONS:
        part = definitions[schema["properties"][first]["anyOf"][0]["$ref"].rpartition("/")[2]] if rest else schema
        entries = part["properties"][rest[0] if rest else first]
        entries["additionalProperties"] = {"anyOf": [entries["additionalProperties"], ALIKE]}
    for name, key in (("Vessel", "responses"), ("Floating", "loads")):
        definitions[name]["properties"][f"{key} from"] = {"type": "string", "description": ANSWERS}
    beams = definitions["RigKeys"]["properties"][BEAMS]["additionalProperties"]["anyOf"]
    beam = definitions[beams[0]["$ref"].rpartition("/")[2]]
    beam["required"] = [key for key in beam["required"] if key not in MADE]
    own = {key: value for key, value in beam["properties"].items() if key not in MADE}
    beam["properties"] = own | _parameters(machine_type(BEAM_TYPE, frame=True))
    beam["additionalProperties"] = {"description": "a parameter of another type"}
    schema["properties"]["gear"] = {"anyOf": [schema["properties"]["gear"], *FILES]}
    for name in ("SlingType", "Frame", beams[0]["$ref"].rpartition("/")[2]):
        definitions[name]["properties"]["gear"] = {"type": "string", "description": GEAR}
    definitions["Frame"]["anyOf"] = [{"required": definitions["Frame"].pop("required")}, {"required": ["gear"]}]
    item = {"type": "object", "properties": {"gear": {"type": "string"}}, "required": ["gear"], "description": GEAR}
    for place in ("SlingKeys.shackle", "SlingKeys.length", "Equaliser.shackle", "RigKeys.shackle"):
        name, key = place.split(".")
        written = definitions[name]["properties"][key]
        definitions[name]["properties"][key] = {"anyOf": [written, item], "description": written.get("description", "")}
    block = definitions["Block"]
    for key, meaning in TABLES.items():
        block["properties"][key] = {"type": "string", "description": meaning}
    block["anyOf"] = [{"required": block.pop("required")}, *({"required": [key]} for key in TABLES)]
    vessel = definitions["Vessel"]
    vessel["properties"]["type"] = {"type": "string", "description": f"a bundled one: {', '.join(vessel_types())}"}
    vessel["anyOf"] = [{"required": vessel.pop("required")}, {"required": ["type", "mass"]}]
    schema["properties"]["extends"] = {"type": "string", "description": "scene that this one is laid over"}
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def _parameters(kind: MachineType) -> Schema:
    """Return the parameters of a machine type as keys of the schema."""
    found: Schema = {}
    for key, text in kind.parameters.items():
        measured = dimension_of(text)
        found[key] = {"type": ["string", "number"], "dimension": measured.name} if measured else {}
        found[key] |= {"default": text} if text is not None else {}
    return found


def with_unit(dimension: str, value: float) -> str | float:
    """Return a value in SI units as text with the unit that scenes use, or as a plain number if there is no unit."""
    unit, factor = FIRST_UNIT.get(dimension, ("", 1.0))
    return f"{value / factor:.10g} {unit}" if unit else value


def _models(base: type[Base]) -> Iterator[type[Base]]:
    """Yield all models of keys derived from `base`."""
    for model in base.__subclasses__():
        yield model
        yield from _models(model)


def _readable(key: Schema, meaning: str) -> Schema:
    """Return the schema of a key without generated titles, and with the unit of its default; a place on a beam may also
    be written as a length."""
    found = {name: value for name, value in key.items() if name != "title"}
    if found.get("default") in ({}, []) or isinstance(found.get("default"), dict):  # its own keys have theirs
        del found["default"]
    if "default" in found:
        found["default"] = _default(found, found["default"])
    items = found.get("prefixItems", [])
    if len(items) == 3 and all(item.get("dimension") == "length" for item in items):
        found = {"anyOf": [found, {"type": "string"}]} | (
            {"default": found.pop("default")} if "default" in found else {}
        )
    if meaning:
        found["description"] = f"{meaning} ({found['description']})" if "description" in found else meaning
    return found


def _default(key: Schema, value: object) -> object:
    options = [key, *key.get("anyOf", [])]
    if isinstance(value, list):
        lists: list[list[Schema]] = [option.get("prefixItems", []) for option in options]
        items = next((items for items in lists if len(items) == len(value)), [])
        return [_default(item, x) for item, x in zip(items, value, strict=True)] if items else value
    dimension = next((option["dimension"] for option in options if "dimension" in option), "")
    return with_unit(dimension, value) if dimension and isinstance(value, float) else value
