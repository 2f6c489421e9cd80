"""Quantities that would vanish or overflow in products are refused at their place, in every unit."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import pytest
from heavylift.kernel import KernelError, SceneError
from heavylift.kernel.description import Body, Joint, System
from heavylift.nodes.scene import loading
from heavylift.nodes.scene.text import Dimension
from heavylift.nodes.scene.text.units import DIMENSIONS
from heavylift.nodes.scenes import bundled
from lifting import unstated

UNITS = [
    pytest.param(dimension, unit, id=f"{dimension.name} {unit}") for dimension in DIMENSIONS for unit in dimension.units
]


@pytest.mark.parametrize(("dimension", "unit"), UNITS)
def test_quantities_beyond_their_bounds_are_refused_in_any_unit(dimension: Dimension, unit: str) -> None:
    for text in ("1e-320", "1e-400", "4.9e-324", "-1e-99", "1e-99999999999"):
        with pytest.raises(ValueError, match=r"smaller than 1e-30|out of range"):
            dimension.read(f"{text} {unit}".strip())
    for text in ("1e308", "-1e308", "1e60", "1e400"):
        with pytest.raises(ValueError, match=r"larger than 1e\+30|not a finite number|out of range"):
            dimension.read(f"{text} {unit}".strip())
    if type(dimension) is Dimension:
        assert dimension.read(f"0e-400 {unit}".strip()) == 0.0
        assert math.isclose(dimension.read(f"1e-12 {unit}".strip()), 1e-12 * dimension.read(f"1 {unit}".strip()))


def _spoiled(value: str) -> Iterator[str]:
    """A small lift, each time with another one of its quantities."""
    text = unstated(bundled()["lift"].read_text())
    for found in re.finditer(r"(?<![\w.-])\d+(?:\.\d+)?(?= (?:t|m|mm|m/min|s)\b)", text):
        if "#" not in text[text.rfind("\n", 0, found.start()) + 1 : found.start()]:
            yield f"{text[: found.start()]}{value}{text[found.end() :]}"


@pytest.mark.parametrize("value", ["1e-320", "1e308"])
def test_quantities_beyond_their_bounds_are_refused_under_any_key(value: str) -> None:
    scenes = list(_spoiled(value))
    assert len(scenes) > 20
    for text in scenes:
        with pytest.raises(SceneError, match=rf"scene.yaml:\d+:\d+: error: .*{value}"):
            loading.parse(text)


def test_numbers_of_a_kernel_system_beyond_their_bounds_are_refused() -> None:
    rail = Joint("j", "prismatic", "world", "b")
    from heavylift import simulate

    for system, message in (
        (System((Body("b", 1e308),), (rail,)), r"body 'b': mass is 1e\+308; it must lie within 1e\+100"),
        (System((Body("b", 1.0),), (rail,), gravity=1e308), r"gravity is 1e\+308; it must be a finite number"),
    ):
        with pytest.raises(KernelError, match=message):
            simulate(system, until=1.0)
