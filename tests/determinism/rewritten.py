"""Equivalent texts of a scene: keys in any order, comments, anchors, other units, another style, several files."""

from __future__ import annotations

import json
import re
from decimal import Decimal
from pathlib import Path
from random import Random
from typing import Any

from heavylift.nodes.scene.text import read

SMALLER = {"t": ("kg", 1000), "m": ("mm", 1000), "kN": ("N", 1000), "MN": ("kN", 1000), "min": ("s", 60)}
QUANTITY = re.compile(rf"(?<![\w.+-])(-?\d+(?:\.\d+)?) ({'|'.join(SMALLER)})(?![\w/])")


def data(text: str) -> dict[str, Any]:
    """What a text says, without `extends`."""
    found = read(text, "scene.yaml")
    assert not found.faults
    return found.data


def shuffled(given: Any, random: Random) -> Any:
    """The same data with the keys of every mapping in another order; lists stay."""
    if isinstance(given, dict):
        keys = random.sample(list(given), len(given))
        return {key: shuffled(given[key], random) for key in keys}
    return [shuffled(each, random) for each in given] if isinstance(given, list) else given


def flow(given: dict[str, Any]) -> str:
    """As one line, which is YAML too."""
    return json.dumps(given)


def block(given: dict[str, Any], random: Random) -> str:
    """Line by line, with comments and blank lines in between; what is said again is an alias of its first place."""
    lines = []
    for line in _lines(given, "", {}):
        if random.random() < 0.3:
            lines.append(random.choice(["", "# a comment: of no meaning", "      # another"]))
        lines.append(line + random.choice(["", "", "   # said beside"]))
    return "\n".join(lines) + "\n"


def commented(text: str, random: Random) -> str:
    """The text as it is, with other comments and blank lines between its lines."""
    lines = text.split("\n")
    for _ in range(5):
        lines.insert(random.randrange(len(lines)), random.choice(["", f"# comment {random.random()}"]))
    return "\n".join(lines)


def other_units(given: Any) -> Any:
    """Every quantity that can be said in a smaller unit, in that one: 300 t as 300000 kg."""
    if isinstance(given, dict):
        return {key: other_units(value) for key, value in given.items()}
    if isinstance(given, list):
        return [other_units(value) for value in given]
    return QUANTITY.sub(_smaller, given) if isinstance(given, str) else given


def apart(given: dict[str, Any], random: Random, folder: Path) -> Path:
    """As a file that extends another one, each with about half of what is said in mappings."""
    below, above = _halves(given, random)
    (folder / "base.yaml").write_text(json.dumps(below))
    path = folder / "over.yaml"
    path.write_text(json.dumps({**above, "extends": "base.yaml"}))
    return path


def _halves(given: dict[str, Any], random: Random) -> tuple[dict[str, Any], dict[str, Any]]:
    below: dict[str, Any] = {}
    above: dict[str, Any] = {}
    for key, value in given.items():
        if isinstance(value, dict) and value and random.random() < 0.5:
            below[key], above[key] = _halves(value, random)
        else:
            random.choice([below, above])[key] = value
    return below, above


def _smaller(match: re.Match[str]) -> str:
    unit, factor = SMALLER[match[2]]
    return f"{(Decimal(match[1]) * factor).normalize():f} {unit}"


def _lines(given: Any, indent: str, anchors: dict[str, str]) -> list[str]:
    found = []
    for key, value in given.items():
        text = json.dumps(value)
        if isinstance(value, dict) and value:
            found += [f"{indent}{json.dumps(key)}:", *_lines(value, indent + "  ", anchors)]
        elif text in anchors:
            found.append(f"{indent}{json.dumps(key)}: *{anchors[text]}")
        else:
            anchors[text] = f"first-{len(anchors)}"
            found.append(f"{indent}{json.dumps(key)}: &{anchors[text]} {text}")
    return found
