"""The force table: a new force is a new entry here and its dataclass in `forces.py`.

`shared` turns the forces of a scene into traced functions, one per shape, that evaluation calls for each force with
its own numbers, ends, signal and joint.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from heavylift.kernel.compiler.function import Function
from heavylift.kernel.description.forces import (
    Bushing,
    Characteristic,
    Force,
    Load,
    Reeving,
    Signal,
    Spring,
    Torsion,
    UserLaw,
    Wind,
)
from heavylift.kernel.multibody.graph import Graph

from .characteristic import CharacteristicLaw
from .force_law import Answer, ForceLaw, Poses
from .loads import LoadLaw, WindLaw
from .reeving import ReevingLaw
from .springs import BushingLaw, SpringLaw, TorsionLaw
from .user_laws import UserLawEntry

LISTS = ("guards", "shown", "turned", "turning")

__all__ = ["FORCES", "SharedForce", "check_force", "law_of", "shared", "signals"]

FORCES: dict[type, ForceLaw] = {
    Load: LoadLaw(),
    Wind: WindLaw(),
    Spring: SpringLaw(),
    Torsion: TorsionLaw(),
    Bushing: BushingLaw(),
    Characteristic: CharacteristicLaw(),
    UserLaw: UserLawEntry(),
    Reeving: ReevingLaw(),
}


def law_of(f: Force) -> ForceLaw:
    """The entry of a force."""
    return FORCES[type(f)]


@dataclass(frozen=True)
class SharedForce:
    """A force with its function; `ends`: link numbers of the bodies it acts on, -1 the ground."""

    force: Any
    law: ForceLaw
    ends: tuple[int, ...]
    numbers: list[float]
    function: Function
    key: str

    @property
    def name(self) -> str:
        return str(self.force.name)

    @property
    def angles(self) -> int:
        return self.law.angles(self.force)

    @property
    def structure(self) -> tuple[object, ...]:
        """Equal for forces that the same machine code serves in the same place of a scene."""
        s = self.law.signal(self.force)
        return self.key, self.ends, s and (s.driven, bool(s.times))


def shared(forces: tuple[Force, ...], graph: Graph, poses: Poses, end: int) -> tuple[SharedForce, ...]:
    """The forces of a scene; `end`: numbers that describe a body to a law."""
    functions: dict[str, Function] = {}
    out = []
    for f in forces:
        law = law_of(f).between(f, graph, poses)
        ends, numbers = f.points, [float(x) for x in law.numbers(f, poses)]
        key = repr((type(f).__name__, law.shape(f), len(numbers), len(ends), bool(f.along)))
        if key not in functions:
            functions[key] = _function(f"force{len(functions)}", f, law, len(numbers), len(ends), end)
        numbered = tuple(graph.number(e.body) for e in ends)
        out.append(SharedForce(f, law, numbered, numbers, functions[key], key))
    return tuple(out)


def signals(forces: tuple[Force, ...]) -> dict[str, Signal]:
    """The signals of the forces that have one, by the forces' names."""
    return {f.name: s for f in forces if (s := law_of(f).signal(f))}


def check_force(f: Force) -> None:
    """Raises KernelError for a force that cannot be."""
    law = law_of(f)
    law.check(f)
    s = law.signal(f)
    if s and (s.times or s.values):
        n, m = len(s.times), len(s.values)
        law.demand(f, "signal", n == m, f"has {n} times and {m} values; give one value for each time")
        late = next((b for a, b in pairwise(s.times) if b < a), None)
        law.demand(f, "signal", late is None, f"goes back to {late} s; its times must not fall")
        law.demand(f, "signal", not s.driven, "has a history and is driven; it can only be one of them")


def _function(name: str, f: Any, law: ForceLaw, numbers: int, ends: int, end: int) -> Function:
    blocks = {"p": numbers, **{f"e{i}": end for i in range(ends)}}
    blocks |= {"s": 2} if law.signal(f) else {}
    blocks |= {"x": 2} if f.along else {}
    blocks |= {"t": 1} if law.timed else {}
    n = law.angles(f)
    blocks |= {"c": n} if n else {}

    def body(p: Any, s: Any = None, x: Any = None, t: Any = (0.0,), c: Any = None, **bodies: Any) -> Mapping[str, Any]:
        counted = {"counted": c} if n else {}
        a: Answer = law.answer(f, p, [bodies[f"e{i}"] for i in range(ends)], s, x, t[0], **counted)
        one = {k: [getattr(a, k)] for k in ("effort", "heat", "work", "stored")}
        return {**one, **{k: getattr(a, k) for k in LISTS}, **{f"w{i}": w for i, w in enumerate(a.wrenches)}}

    return Function(name, body, blocks)
