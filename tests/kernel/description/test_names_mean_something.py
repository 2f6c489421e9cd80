"""References between items of a system are checked; unknown names are reported with similar ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from typing import Any

import msgspec
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import (
    GROUPS,
    Ball,
    Body,
    Brake,
    Bushing,
    Characteristic,
    Contact,
    Drive,
    InputSignal,
    Joint,
    JointSpring,
    Line,
    Load,
    Lock,
    Master,
    Measured,
    Plane,
    Point,
    Reeving,
    RigidRope,
    Rope,
    Sheave,
    Spring,
    Stop,
    Support,
    System,
    Threshold,
    Torsion,
    UserLaw,
    Wind,
)
from heavylift.kernel.islands import simulate

SIX = ((0.0,) * 6,) * 6
HERE, ABOVE = Point("lower", (0.1, 0.0, 0.0)), Point("world", (0.0, 0.0, 9.0))
RICH = System(
    bodies=(Body("upper", 2.0), Body("lower", 1.0), Body("cart", 1.0)),
    joints=(
        Joint("rail", "prismatic", "world", "upper"),
        Joint("hinge", "prismatic", "upper", "lower", axis=(1, 0, 0)),
        Joint("track", "prismatic", "world", "cart", axis=(1, 0, 0)),
    ),
    springs=(JointSpring("spring", "rail", k=1.0),),
    stops=(Stop("stop", "rail", -9.0, 9.0, 1.0, 1.0),),
    brakes=(Brake("brake", "hinge", 1.0, 1.0, 1.0),),
    locks=(Lock("lock", "track"),),
    drives=(Drive("drive", "hinge", "servo", kp=1.0),),
    ropes=(Rope("fall", (Line(HERE, ABOVE),), 1e3, 20.0),),
    rigid_ropes=(RigidRope("stay", (Line(HERE, ABOVE),), 30.0),),
    supports=(Support("pad", HERE, -9.0, 1.0, 1.0, on="upper"), Support("floor", HERE, -9.0, 1.0, 1.0)),
    forces=(
        Load("load", HERE),
        Wind("wind", HERE, 1.0, 1.0, (1.0, 0.0, 0.0), InputSignal()),
        Spring("buffer", HERE, ABOVE, 9.0, 1.0),
        Torsion("torsion", "upper", "lower", (0.0, 1.0, 0.0)),
        Bushing("bushing", HERE, Point("upper"), SIX, SIX),
        Characteristic("motor", "rail", "speed", (0.0, 1.0), (0.0, 0.0)),
        UserLaw("own", "heavylift.nodes.zoo.laws:none", joint="rail"),
        Reeving("rope", HERE, (Sheave(Point("upper")),), ABOVE, 1e3, InputSignal(30.0)),
    ),
    contacts=(Contact("contact", Ball("cart", (0.0, 0.0, 50.0), 0.1), Plane("world", (0.0, 0.0, -9.0))),),
    masters=(Master("master"),),
    measured=(Measured("angle", "angle", "lower"), Measured("travel", "joint", "track")),
    thresholds=(
        Threshold("high", "height", point=HERE),
        Threshold("higher", "height difference", point=HERE, origin=ABOVE),
        Threshold("taut", "tension", ropes=("fall", "stay")),
        Threshold("turned", "angle", of="lower"),
        Threshold("far", "joint", of="rail"),
        Threshold("fast", "speed", of="rail"),
        Threshold("stormy", "wind", of="wind", point=HERE),
        Threshold("aside", "swing along", ropes=("fall",)),
    ),
)
OTHER = {"name", "kind", "quantity", "axes", "of_speed", "function", "guards", "edge"}  # texts that name no item


def _spoiled(x: Any, path: str = "") -> Iterator[tuple[str, str, Any]]:
    """Each name within an item, where it stands, and the item with another one in its place."""
    if isinstance(x, tuple):
        for i, part in enumerate(x):
            if isinstance(part, str):
                yield path, part, (*x[:i], f"{part}x", *x[i + 1 :])
            for at, name, new in _spoiled(part, f"{path}[{i}]"):
                yield at, name, (*x[:i], new, *x[i + 1 :])
    elif is_dataclass(x) or isinstance(x, msgspec.Struct):
        names = [f.name for f in fields(x)] if is_dataclass(x) else list(x.__struct_fields__)
        change = replace if is_dataclass(x) else msgspec.structs.replace
        for field in names:
            value = getattr(x, field)
            if isinstance(value, str) and value and field not in OTHER and value not in ("position", "speed"):
                yield f"{path}.{field}", value, change(x, **{field: f"{value}x"})
            elif not isinstance(value, str):
                for at, name, new in _spoiled(value, f"{path}.{field}"):
                    yield at, name, change(x, **{field: new})


SYSTEM = replace(RICH, forces=tuple(f for f in RICH.forces if not isinstance(f, UserLaw)))
CASES = [
    pytest.param(replace(RICH, **{group: (*items[:i], new, *items[i + 1 :])}), name, id=f"{x.name}{at}")
    for group in GROUPS
    for items in (getattr(RICH, group),)
    for i, x in enumerate(items)
    for at, name, new in _spoiled(x)
]


def _run(system: System) -> None:
    simulate(system, 1e-7, 500_000_000, frozenset(), "dopri5", None).start()


def test_the_system_for_tests_of_misspelt_names_runs_if_its_names_are_correct() -> None:
    _run(SYSTEM)


@pytest.mark.parametrize(("system", "name"), CASES)
def test_the_error_for_a_misspelt_name_in_a_system_suggests_the_similar_name(system: System, name: str) -> None:
    with pytest.raises(KernelError) as caught:
        _run(system)
    assert f"'{name}x'; did you mean '{name}'?" in str(caught.value)


def test_the_error_for_a_name_unlike_any_other_lists_all_known_names() -> None:
    with pytest.raises(KernelError, match="lock 'k': there is no joint 'j'; the system has no joint at all"):
        _run(System(locks=(Lock("k", "j"),)))
    with pytest.raises(KernelError, match="lock 'k': there is no joint 'z'; known: rail, hinge, track"):
        _run(replace(SYSTEM, locks=(Lock("k", "z"),)))


def test_the_tests_of_misspelt_names_cover_every_kind_of_named_item() -> None:
    spoiled = {case.id.partition(".")[0] for case in CASES}  # type: ignore[union-attr]
    names = {x.name for group in GROUPS for x in getattr(RICH, group)}
    assert names - spoiled == {"upper", "lower", "cart", "master"}
