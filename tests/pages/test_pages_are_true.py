"""Commands on pages exist, links lead to files, and the reference describes the public interface."""

from __future__ import annotations

import inspect
import re
import shlex
from importlib import import_module

import pytest
import typer
from heavylift.coordinator.commands import app
from heavylift.nodes.devs import Atomic, Message
from heavylift.nodes.queueing import Distribution
from heavylift.nodes.scene import json_schema
from page_blocks import ROOT
from reference import MODULES, SHELF, fields_of, parameters_of, parts, ports_of, public_names

PAGES = sorted(
    str(path.relative_to(ROOT))
    for path in ROOT.rglob("*.md")
    if path.relative_to(ROOT).parts[0][0] != "." and "node_modules" not in path.parts
)
COMMANDS = typer.main.get_command(app).commands
CALL = re.compile(r"(?:^|[`\s/])heavylift ([a-z]+\b[^`\n#;]*)", re.M)


@pytest.mark.parametrize("name", PAGES)
def test_commands_and_options_named_on_pages_exist(name: str) -> None:
    text = (ROOT / name).read_text()
    typed = [*re.findall(r"^```sh\n(.*?)^```", text, re.M | re.S), *re.findall(r"^ {4}.*$", text, re.M)]
    quoted = re.findall(r"`([^`\n]*heavylift [^`\n]*)`", text)
    for call in (call for part in [*typed, *quoted] for call in CALL.findall(part)):
        command, *words = shlex.split(call.partition("&&")[0].partition(">")[0].replace("'", "").replace('"', ""))
        assert command in COMMANDS, f"{name}: heavylift {call}"
        known = {option for parameter in COMMANDS[command].params for option in parameter.opts} | {"--help", "-o"}
        unknown = [word for word in words if re.match(r"--?[a-z]", word) and word not in known]
        assert not unknown, f"{name}: heavylift {call}: {unknown}"


@pytest.mark.parametrize("name", PAGES)
def test_links_on_pages_lead_to_existing_files(name: str) -> None:
    here = (ROOT / name).parent
    links = re.findall(r"\]\(([^)#\s]+)[^)]*\)", (ROOT / name).read_text())
    assert [link for link in links if "://" not in link and not (here / link).exists()] == []


@pytest.mark.parametrize("name", PAGES)
def test_files_named_in_printed_commands_exist(name: str) -> None:
    named = re.findall(
        r"\b((?:tests|coordinator|kernel|nodes|recordings)/[\w/]+\.(?:py|md|yaml|png))\b", (ROOT / name).read_text()
    )
    here = (ROOT / name).parent
    assert [path for path in named if not (ROOT / path).exists() and not (here / path).exists()] == []


REFERENCE = parts()


def test_the_reference_page_describes_every_command_and_option() -> None:
    for name, command in COMMANDS.items():
        (part,) = re.findall(rf"^## `heavylift {name}[ `].*?(?=^## |\Z)", REFERENCE["commands"], re.M | re.S)
        rows = dict(re.findall(r"^\| `?([^|`]*)`? \| (.*) \|$", part, re.M))
        for parameter in command.params:
            message = ", ".join(parameter.opts) if parameter.param_type_name == "option" else parameter.name
            assert rows.get(message), f"heavylift {name} {message}"


def test_the_reference_page_describes_every_key_of_scene_files() -> None:
    keys = re.findall(r"^\| `([^`]*)` \|", REFERENCE["scene-files"], re.M)
    schema = json_schema()
    models = [schema, *(option for part in schema["$defs"].values() for option in [part, *part.get("anyOf", [])])]
    assert {key for model in models for key in model.get("properties", {})} - {"like"} == set(keys) - {"like"}


@pytest.mark.parametrize("module", [message for message in MODULES if ":" not in message])
def test_the_reference_page_describes_every_public_name(module: str) -> None:
    there = import_module(module)
    names = [name for name in public_names(there) if not inspect.ismodule(getattr(there, name))]
    (part,) = re.findall(rf"^## {re.escape(module)}$.*?(?=^## |\Z)", REFERENCE["python"], re.M | re.S)
    assert [name for name in names if f"**`{name}" not in part] == []


NUMBERS = {"`float`", "`tuple[float, ...]`", "`Sequence[float]`", "`Sequence[float] | None`"}
OF_A_SIGNAL = ("Sample", "value")  # whose unit is that of what it samples


def shelf() -> list[type]:
    found = []
    for message in SHELF:
        name, _, some = message.partition(": ")
        module = import_module(name)
        kinds = (getattr(module, public) for public in some.split() or public_names(module))
        found += [x for x in kinds if isinstance(x, type) and not inspect.isabstract(x)]
    return [x for x in found if issubclass(x, Atomic | Distribution | Message)]


@pytest.mark.parametrize("kind", shelf(), ids=lambda kind: kind.__name__)
def test_the_reference_page_describes_the_ports_and_units_of_every_library_model(kind: type) -> None:
    rows = fields_of(kind) if issubclass(kind, Message) else parameters_of(kind)
    without = [name for name, type_, unit, _ in rows if type_ in NUMBERS and not unit]
    assert [name for name in without if (kind.__name__, name) != OF_A_SIGNAL] == []
    assert all(type_ != "`_empty`" for _, type_, _, _ in rows)
    (part,) = re.findall(rf"^### {kind.__name__}\n.*?(?=^##|\Z)", REFERENCE["devs-parts"], re.M | re.S)
    for name, *more in [*rows, *(ports_of(kind) if issubclass(kind, Atomic) else ())]:
        assert f"| `{name}` | {more[0].replace('|', chr(92) + '|')} |" in part


IMPORT = re.compile(r"^ *from (heavylift[\w.]*) import (?:\(([^)]*)\)|(.*))$", re.MULTILINE)
OTHERS = {"heavylift.kernel.forces.mathematics"}  # functions whose meaning is that of their names
ALWAYS = ("Hybrid", "Line", "Point", "Contact", "Sample", "SetPoint", "Study", "Rope", "Body", "Atomic")


@pytest.mark.parametrize("name", PAGES)
def test_public_names_used_on_pages_are_described_in_the_reference(name: str) -> None:
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / name).read_text(), re.DOTALL)
    found = [
        (module, word.split()[0])
        for block in blocks
        for module, several, one in IMPORT.findall(block)
        for word in re.sub(r"#.*", "", several or one).split(",")
        if word.strip() and module not in OTHERS and ".zoo." not in module
    ]
    classes = [word for module, word in found if callable(getattr(import_module(module), word))]
    assert [word for word in classes if not re.search(rf"^\*\*`{word}\b", REFERENCE["python"], re.MULTILINE)] == []


def test_the_reference_page_has_an_entry_for_every_name_that_user_models_need() -> None:
    assert [word for word in ALWAYS if not re.search(rf"^\*\*`{word}`", REFERENCE["python"], re.MULTILINE)] == []
