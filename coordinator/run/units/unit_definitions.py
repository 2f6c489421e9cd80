"""Units of variables in a model description of FMI, as products of powers of base units."""

import re
from collections.abc import Mapping
from xml.etree.ElementTree import Element, SubElement

BASES = {"kg": {"kg": 1}, "m": {"m": 1}, "s": {"s": 1}, "rad": {"rad": 1}, "1": {}, "%": {}}
BASES |= {"N": {"kg": 1, "m": 1, "s": -2}, "J": {"kg": 1, "m": 2, "s": -2}, "W": {"kg": 1, "m": 2, "s": -3}}
FACTOR = re.compile(r"([A-Za-z%]+|1)(-?\d*)")


def exponents(unit: str) -> dict[str, int] | None:
    """Return the exponents of the base units of a unit such as "N m/rad" or "m/s2"; None if it is not known."""
    found: dict[str, int] = {}
    for i, part in enumerate(unit.split("/")):
        for word in part.split():
            match = FACTOR.fullmatch(word)
            if match is None or match[1] not in BASES:
                return None
            for base, n in BASES[match[1]].items():
                found[base] = found.get(base, 0) + n * int(match[2] or 1) * (-1 if i else 1)
    return {base: n for base, n in found.items() if n}


def with_units(root: Element, variables: Mapping[str, Element], units: Mapping[str, str]) -> Element:
    """Return a model description whose variables have their units, with definitions of these units."""
    known = {unit: bases for unit in sorted({*units.values()}) if (bases := exponents(unit)) is not None}
    for name, unit in units.items():
        if unit in known:
            variables[name].set("unit", unit)
    place = 1 + next(i for i, node in enumerate(root) if node.tag == "CoSimulation")
    definitions = Element("UnitDefinitions")
    for unit, bases in known.items():
        node = SubElement(definitions, "Unit", name=unit)
        factor = {"factor": "0.01"} if unit == "%" else {}
        SubElement(node, "BaseUnit", {**{base: str(n) for base, n in bases.items()}, **factor})
    root.insert(place, definitions)
    return root
