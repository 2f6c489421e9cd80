"""Keys of elements in a scene set the kernel's fields with their names, units and signs."""

from random import Random
from typing import Any, get_args, get_type_hints

import pytest
from heavylift.kernel.description import Unit
from heavylift.nodes.scene.keys import WORDS
from heavylift.nodes.scene.keys.parts import forces, mechanics
from heavylift.nodes.scene.text.units import NAMED
from pydantic import ValidationError

LAWS = (
    mechanics.SpringKeys,
    mechanics.StopKeys,
    mechanics.BrakeKeys,
    mechanics.LockKeys,
    mechanics.SupportKeys,
    mechanics.DriveKeys,
)
GIVEN: dict[str, Any] = {  # what has no unit, or is written otherwise
    "type": "prescribed", "start": {"body": "a"}, "end": {"body": "b"}, "body": "a", "joint": "j", "over": "speed",
    "curve": [[0, 0]], "function": "math:sin", "direction": [0, 0, 1], "axis": [0, 0, 1], "range": [0, "1 m"],
    "holds": "1 kN", "ramp": "1 m/s2",
}  # fmt: skip


def _numbers(kind: type) -> dict[str, Unit]:
    """Fields that are one number with a unit."""
    hints = get_type_hints(kind, include_extras=True)
    found = {name: [x for x in get_args(hint) if isinstance(x, Unit)] for name, hint in hints.items()}
    return {name: units[0] for name, units in found.items() if units and units[0].dimension in NAMED}


def _needed(model: Any) -> dict[str, Any]:
    torsion = {"start": "a", "end": "b"} if model.__name__ == "Torsion" else {}
    given = {key: x for key, x in (GIVEN | torsion).items() if key in model.model_fields}
    if "type" in given and model is not mechanics.DriveKeys:
        given["type"] = get_args(model.model_fields["type"].annotation)[0]
    return given


def _si(unit: Unit) -> str:
    return next(word for word, factor in NAMED[unit.dimension].units.items() if factor == 1)


@pytest.mark.parametrize("model", [*forces.MODELS, *LAWS], ids=lambda model: model.__name__)
def test_each_key_of_a_force_element_sets_the_kernel_field_with_its_value_in_si_units(model: Any) -> None:
    random = Random(model.__name__)
    units = {name: unit for name, unit in _numbers(model.struct).items() if WORDS.get(name, name) in model.model_fields}
    values = {name: round(random.uniform(0.1, 9.0), 3) for name in units}
    written = {WORDS.get(name, name): f"{x!r} {_si(units[name])}" for name, x in values.items()}
    folder = "/" if model is forces.LawKeys else None
    made = model.model_validate(_needed(model) | written).built("it", folder=folder)
    assert {name: getattr(made, name) for name in values} == pytest.approx(values, rel=1e-12)
    for key in (WORDS.get(name, name) for name, unit in units.items() if unit.least):
        with pytest.raises(ValidationError, match="must be"):
            model.model_validate(_needed(model) | written | {key: f"-{written[key]}"})
