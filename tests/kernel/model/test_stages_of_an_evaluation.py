"""Each stage of an evaluation reads and writes exactly the fields declared for it."""

from __future__ import annotations

from copy import copy
from dataclasses import fields, replace
from functools import cache
from typing import Any, ClassVar

import pytest
from contact_scenes import brick, floating
from every_law import yard
from heavylift.kernel.description import (
    WORLD,
    Beam,
    Body,
    Box,
    Contact,
    Drive,
    Flexible,
    Joint,
    Line,
    Measured,
    Plane,
    Point,
    RigidRope,
    System,
    Threshold,
)
from heavylift.kernel.model import FORCES, POSES, Evaluation, EvaluationStage, Program, evaluate, evaluation
from small_scenes import X, Y

CUBE = (1.0, 1.0, 1.0)
BEAM = Flexible(2, Beam(4.0, 300.0, 1e5, 1e5, 1e7, 1e5, 30.0, elements=4))
GIVEN = {"program", "t", "inside", "P"}  # to every stage
FIELDS = {f.name for f in fields(Evaluation)} - GIVEN


def whole() -> System:
    """Every law, a loop, a heavy rigid rope with a winch, a contact, thresholds on whatever there is."""
    s = yard()
    line = Line(Point("trolley", (-3.0, 0.0, 0.0)), Point("block", (-2.0, 0.0, 2.0)))
    return replace(
        s,
        bodies=(
            *s.bodies,
            *(brick(name, CUBE, 10.0) for name in ("brick", "rod", "slide")),
            Body("boom", 50.0, flexible=BEAM),
        ),
        joints=(
            *s.joints,
            floating("brick", (50.0, 0.0, 0.5)),
            Joint("pin", "revolute", WORLD, "rod", axis=Y),
            Joint("way", "prismatic", WORLD, "slide", (0.0, 1.0, 0.0), axis=X),
            Joint("tie", "spherical", "rod", "slide"),
            Joint("foot", "fixed", WORLD, "boom"),
        ),
        rigid_ropes=(RigidRope("stay", (line,), 30.0, winch=True, mass=10.0),),
        contacts=(Contact("floor", Box("brick", CUBE), Plane(), 0.3),),
        drives=(*s.drives, Drive("spin", "hinge", "speed", kv=1.0)),
        measured=(*s.measured, Measured("tilt", "angle", "block", 1)),
        thresholds=(
            *s.thresholds,
            Threshold("tense", "tension", ropes=("hoist", "stay")),
            Threshold("short", "length", ropes=("stay",)),
            Threshold("fast", "speed", of="hinge"),
            Threshold("open", "joint", of="hinge"),
            Threshold("steep", "angle", of="block"),
        ),
    )


@cache
def program() -> Program:
    return Program(whole())


class Watched(Evaluation):
    """Notes which fields are asked for."""

    touched: ClassVar[set[str]] = set()

    def __getattribute__(self, name: str) -> Any:
        Watched.touched.add(name)
        return super().__getattribute__(name)


@pytest.mark.parametrize("stage", POSES + FORCES, ids=lambda stage: stage.run.__name__)
def test_each_stage_of_the_rate_evaluation_in_the_kernel_writes_only_its_declared_fields(
    stage: EvaluationStage, monkeypatch: pytest.MonkeyPatch
) -> None:
    changed, touched = set[str](), set[str]()

    def run(x: Evaluation) -> None:
        before = {name: copy(y) if isinstance(y := vars(x)[name], dict | list) else y for name in FIELDS}
        Watched.touched.clear()
        x.__class__ = Watched
        stage.run(x)
        x.__class__ = Evaluation
        touched.update(Watched.touched & FIELDS)
        changed.update(name for name in FIELDS if not _same(before[name], vars(x)[name]))

    monkeypatch.setattr(evaluation, "FORCES", tuple(s._replace(run=run) if s is stage else s for s in POSES + FORCES))
    monkeypatch.setattr(evaluation, "POSES", ())
    evaluate(program(), 0.0, program().initial_state(), program().parameters.initial)
    reads, writes = set(stage.reads.split()), set(stage.writes.split())
    assert (changed, touched - writes) == (writes, reads - writes)


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, dict):
        return isinstance(b, dict) and a.keys() == b.keys() and all(_same(a[k], b[k]) for k in a)
    if isinstance(a, list):
        return isinstance(b, list) and len(a) == len(b) and all(map(_same, a, b))
    return a is b
