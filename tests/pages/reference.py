"""The reference: commands, keys of scene files, public names of the rooms, made from docstrings, help texts and schema.

The documentation site calls `parts`; nothing of it is stored.  `python tests/pages/reference.py` prints it.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from importlib import import_module
from types import ModuleType
from typing import Any, get_args, get_type_hints

import msgspec
import typer
from heavylift.nodes.devs import Atomic, In, Message, Out
from heavylift.nodes.queueing import Distribution

MODULES = (  # and perhaps which names of each
    "heavylift",
    "heavylift.nodes.scene",
    "heavylift.nodes.limits",
    "heavylift.coordinator.run",
    "heavylift.coordinator.run.models: ModelRun",
    "heavylift.coordinator.sweeps.study: Study",
    "heavylift.coordinator.live",
    "heavylift.recordings",
    "heavylift.nodes.devs",
    "heavylift.nodes.devs.hybrid",
    "heavylift.nodes.queueing.distributions",
    "heavylift.nodes.queueing.stations",
    "heavylift.nodes.queueing.server",
    "heavylift.nodes.queueing.routing",
    "heavylift.nodes.queueing.entities: Entity Demand",
    "heavylift.nodes.models: Sample SetPoint",
    "heavylift.nodes.testing",
    "heavylift.kernel.description.mechanics",
    "heavylift.kernel.description.signals: Threshold",
    "heavylift.kernel.description.units",
    "heavylift.kernel.description.laws",
    "heavylift.kernel.description.forces",
    "heavylift.kernel.description.contacts",
    "heavylift.kernel.simulation.simulation",
    "heavylift.kernel.analysis",
    "heavylift.kernel.forces.mathematics",
    "heavylift.kernel.errors",
)
SHELF = (  # modules with parts of DEVS models, to be coupled or copied
    "heavylift.nodes.queueing.stations",
    "heavylift.nodes.queueing.server",
    "heavylift.nodes.queueing.routing",
    "heavylift.nodes.queueing.distributions",
    "heavylift.nodes.queueing.entities",
    "heavylift.nodes.fmi",
    "heavylift.nodes.zoo.queue",
    "heavylift.nodes.zoo.multi_server_queue",
    "heavylift.nodes.zoo.bouncing_ball",
    "heavylift.nodes.zoo.traffic_light",
    "heavylift.nodes.zoo.anti_sway",
    "heavylift.nodes.zoo.token_ring",
    "heavylift.nodes.models.parts.messages: Sample SetPoint",
)
UNIT = r"`{}` \[([^\]]+)\]"  # of a parameter, in the docstring of its class
HEADS = {
    "commands": "# Commands\n\nEach prints this with `--help`.",
    "scene-files": "# Scene files\n\n`heavylift schema` writes the same as a JSON Schema, which editors read.",
    "devs-parts": "# Parts of DEVS models\n\nParameters, ports and results of the atomic models; fields of messages. A "
    "port receives a bag: the list of all messages of one logical time. The first parameter, `name`, is left out.",
    "python": "# Python\n\nPublic names of the packages. Times are in seconds, quantities in SI units unless stated.",
}


def parts() -> dict[str, str]:
    """The pages of the reference as Markdown, by name."""
    made = {"commands": _commands, "scene-files": _keys, "devs-parts": _shelf, "python": _modules}
    written = {name: (HEADS[name], *map(str.strip, make())) for name, make in made.items()}
    return {name: "\n\n".join(filter(None, pieces)) + "\n" for name, pieces in written.items()}


def _commands() -> Iterator[str]:
    from heavylift.coordinator.commands import app

    group: Any = typer.main.get_command(app)
    for name in sorted(group.commands):
        command = group.commands[name]
        words = [p.name if p.required else f"[{p.name}]" for p in command.params if p.param_type_name == "argument"]
        rows = [_row(f"`{', '.join(p.opts)}`", p.help) for p in command.params if p.param_type_name == "option"]
        rows += [_row(p.name, p.help) for p in command.params if p.param_type_name == "argument"]
        usage = " ".join(["heavylift", name, *words])
        message = "\n\n".join(" ".join(part.split()) for part in command.help.split("\n\n"))
        table = ["| option or argument | meaning |", "|---|---|", *rows] if rows else []
        yield "\n".join([f"## `{usage}`\n", f"{message} Example: `{command.example}`\n", *table])


def _keys() -> Iterator[str]:
    from heavylift.nodes.scene import json_schema
    from heavylift.nodes.scene.language import phrases

    schema = json_schema()
    grammar = inspect.cleandoc(phrases.__doc__ or "").partition("\n\n")[2]
    yield (
        "A quantity is written with its unit, and perhaps how uncertain it is (`480 t +- 3 %`, `480 t sd 5 t`, "
        "`460..500 t`); `string` stands for a name, `list` and `mapping` for several; `like: name` in an entry copies "
        f"another one of its mapping. What an order and a condition may say:\n\n```\n{grammar}\n```"
    )
    parts = {"the scene": schema, **schema["$defs"]}
    for name, part in parts.items():
        model = next((option for option in part.get("anyOf", []) if "properties" in option), part)
        message = " ".join(model.get("description", "").split())
        rows = [
            _key(key, value, key in model.get("required", ())) for key, value in model.get("properties", {}).items()
        ]
        if rows:
            yield "\n".join(
                [f"## {_plain(name)}\n", f"{message}\n", "| key | default | meaning |", "|---|---|---|", *rows]
            )


def _key(name: str, value: dict[str, Any], required: bool) -> str:
    default = "needed" if required else _written(value.get("default"))
    return _row(f"`{name}`", default, f"{_kind(value)}{'; ' if value.get('description') else ''}{_meaning(value)}")


def _meaning(value: dict[str, Any]) -> str:
    """What a key means, without the units that its kind tells."""
    return re.sub(r"\(?[\w ]+ with its unit: .*", "", value.get("description", "")).strip(" ;")


def _written(default: object) -> str:
    if isinstance(default, list):
        return f"[{', '.join(_written(x) for x in default)}]"
    return "" if default is None else str(default).lower() if isinstance(default, bool) else str(default)


def _kind(value: dict[str, Any]) -> str:
    """What stands behind a key, in a word."""
    if "dimension" in value:
        return str(value["dimension"])
    if "$ref" in value:
        return _plain(value["$ref"].rpartition("/")[2])
    options = [
        _kind(option)
        for key in ("anyOf", "oneOf")
        for option in value.get(key, [])
        if option.get("type") != "null" and "like" not in option.get("properties", {})
    ]
    if options:
        return " or ".join(dict.fromkeys(options))
    if "enum" in value or "const" in value:
        return ", ".join(f"`{word}`" for word in value.get("enum", [value.get("const")]))
    if "prefixItems" in value:
        return f"[{', '.join(_kind(item) for item in value['prefixItems'])}]"
    if value.get("type") == "array":
        return f"list of {_kind(value['items'])}"
    if isinstance(value.get("additionalProperties"), dict):
        return f"mapping of names to {_kind(value['additionalProperties'])}"
    return str(value.get("type", "anything"))


def _plain(name: str) -> str:
    """The name of a model without the modules that tell equal ones apart."""
    *path, last = name.split("__")
    return f"{last} ({path[-1]})" if path else last


def _shelf() -> Iterator[str]:
    for message in SHELF:
        name, _, some = message.partition(": ")
        module = import_module(name)
        kinds = [getattr(module, public) for public in some.split() or public_names(module)]
        yield f"## {name}\n\n{_first(module)}"
        for kind in (x for x in kinds if isinstance(x, type) and not inspect.isabstract(x)):
            if issubclass(kind, Message):
                yield _table(kind, ("field", "type", "unit", "default"), fields_of(kind))
            elif issubclass(kind, Atomic | Distribution):
                yield _table(kind, ("parameter", "type", "unit", "default"), parameters_of(kind))
                rows = [(port, way, f"`{carried.__name__}`") for port, way, carried in ports_of(kind)]
                yield _table(None, ("port", "direction", "message"), rows)
                result = get_type_hints(kind.result).get("return") if issubclass(kind, Atomic) else None
                yield f"Result: `{result.__name__}`" if isinstance(result, type) and issubclass(result, Message) else ""


def _table(kind: type | None, head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    title = [f"### {kind.__name__}\n", " ".join(inspect.cleandoc(kind.__doc__ or "").split()) + "\n"] if kind else []
    table = [_row(*head), _row(*["---"] * len(head)), *(_row(f"`{first}`", *rest) for first, *rest in rows)]
    return "\n".join([*title, *(table if rows else ())])


def fields_of(kind: type[Message]) -> list[tuple[str, ...]]:
    """Name, type, unit and default of the fields of a message."""
    return [
        (x.name, _type(x.type), kind.units.get(x.name, ""), "" if x.required else repr(x.default))
        for x in msgspec.structs.fields(kind)
    ]


def parameters_of(kind: type) -> list[tuple[str, ...]]:
    """Name, type, unit and default of the parameters of a part; the unit stands in the docstring of a class."""
    docs = " ".join(" ".join((base.__doc__ or "").split()) for base in kind.__mro__ if "heavylift" in base.__module__)
    rows = []
    for name, x in inspect.signature(kind).parameters.items():
        if name != "name" and x.kind not in (x.VAR_POSITIONAL, x.VAR_KEYWORD):
            unit = re.search(UNIT.format(name), docs)
            default = "" if x.default is x.empty else repr(x.default)
            rows.append((name, _type(x.annotation), unit[1] if unit else "", default))
    return rows


def ports_of(kind: type) -> list[tuple[str, str, type[Message]]]:
    """Name, direction and message of the declared ports of a model."""
    found = {name: x for base in reversed(kind.__mro__) for name, x in vars(base).items() if isinstance(x, In | Out)}
    return [(name, "in" if isinstance(x, In) else "out", x.type) for name, x in found.items()]


def _type(annotation: Any) -> str:
    plain = annotation.__name__ if isinstance(annotation, type) and not get_args(annotation) else str(annotation)
    return f"`{re.sub(r'[a-z_.]+[.](?=[A-Za-z])', '', plain)}`"


def _modules() -> Iterator[str]:
    for message in MODULES:
        name, _, some = message.partition(": ")
        module = import_module(name)
        doc = inspect.cleandoc(module.__doc__ or "")
        yield f"## {name}\n\n```\n{doc}\n```"
        for public in some.split() or public_names(module):
            entry = _entry(public, getattr(module, public))
            if entry:
                yield entry


def public_names(module: ModuleType) -> list[str]:
    own = [
        k for k, v in vars(module).items() if getattr(v, "__module__", "") == module.__name__ and not k.startswith("_")
    ]
    return sorted(getattr(module, "__all__", own))


def _entry(name: str, thing: object) -> str:
    if isinstance(thing, type) and thing.__doc__:
        lines = [f"**`{name}`** {_first(thing)}", *_members(thing)]
        return "\n".join(lines)
    if inspect.isfunction(thing):
        return f"**`{name}{_signature(thing)}`** {_first(thing)}"
    return "" if isinstance(thing, ModuleType) else f"**`{name}`** `{str(thing).replace('typing.', '')}`"


def _members(kind: type) -> Iterator[str]:
    names = [f.name for f in fields(kind)] if is_dataclass(kind) else getattr(kind, "__struct_fields__", ())
    if names:
        yield f"\n    {kind.__name__}({', '.join(names)})"
    bases = [base for base in reversed(kind.__mro__) if "heavylift" in base.__module__]
    members = {k: v for b in bases for k, v in vars(b).items() if getattr(v, "__module__", "") != "typing"}  # overloads
    shown = [
        f"- `{name}{_signature(member)}` {_first(member)}"
        for name, member in members.items()
        if not name.startswith("_") and inspect.isfunction(member) and member.__doc__
    ]
    shown += [
        f"- `{name}` {_first(member)}"
        for name, member in members.items()
        if not name.startswith("_") and isinstance(member, property) and member.__doc__
    ]
    if shown:
        yield "\n" + "\n".join(shown)


def _signature(thing: Callable[..., object]) -> str:
    """Names and defaults of arguments, without types and without what has no plain form."""
    words = []
    for parameter in inspect.signature(thing).parameters.values():
        if parameter.name == "self":
            continue
        star = "*" * ((parameter.kind == parameter.VAR_POSITIONAL) + 2 * (parameter.kind == parameter.VAR_KEYWORD))
        message = "" if parameter.default is parameter.empty else f"={parameter.default!r}"
        words.append(f"{star}{parameter.name}{'=...' if ' at 0x' in message else message}")
    return f"({', '.join(words)})"


def _first(thing: object) -> str:
    """The first paragraph of a docstring on one line."""
    return " ".join(inspect.cleandoc(thing.__doc__ or "").partition("\n\n")[0].split())


def _row(*cells: str | None) -> str:
    return f"| {' | '.join((cell or '').replace('|', chr(92) + '|') for cell in cells)} |"


if __name__ == "__main__":
    print("\n".join(parts().values()))
