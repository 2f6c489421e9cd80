"""The columns of a sample row, as one table: everything recorded of one instant, and of the steps to it.

The native code writes rows in this order; `samples` shows them as channels, and islands are merged column by column.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

from heavylift.kernel.compiler.function import Layout, flatten
from heavylift.kernel.compiler.symbol import Value
from heavylift.kernel.methods.method import StepState
from heavylift.kernel.model.evaluation import Evaluation
from heavylift.kernel.model.program import Program

Label = tuple[str, str, int]  # group of columns, whose, which of its own


class SampleInstant:
    """An evaluation, with values shared by several column groups."""

    def __init__(self, x: Evaluation) -> None:
        self.x, self.program = x, x.program

    @cached_property
    def energies(self) -> tuple[list[Value], Value, Value]:
        """Poses, kinetic and potential energy."""
        return self.x.poses_and_energies()

    @cached_property
    def loads(self) -> list[list[Value]]:
        """Loads of loop joints; tensions, slacks and lengths of rigid ropes."""
        values, ropes = self.x.loads(), len(self.program.system.rigid_ropes)
        first = len(values) - 3 * ropes
        return [values[:first], *(values[first + i * ropes : first + (i + 1) * ropes] for i in range(3))]


@dataclass(frozen=True)
class ColumnGroup:
    """A group of columns: unit, frame, names of its owners, function that reads it. Without `read` it is the part
    `kept` of X, which the steps maintain."""

    name: str
    unit: str
    frame: str
    owners: Callable[[Program], Sequence[str]]
    read: Callable[[SampleInstant], Value] | None = None
    kept: str = ""
    single: bool = False


def _names(group: str) -> Callable[[Program], list[str]]:
    """Return a function that lists the names of a program's elements in this group."""
    return lambda p: [x.name for x in getattr(p.system, group)]


def _coordinates(p: Program) -> list[str]:
    links = sorted(p.graph.links, key=lambda k: k.q.start)
    return [k.body.name for k in links for _ in range(k.q.start, k.q_modes.stop)]


def _velocities(p: Program) -> list[str]:
    links = sorted(p.graph.links, key=lambda k: k.v.start)
    return [k.body.name for k in links for _ in range(k.v.start, k.v_modes.stop)]


def _law(group: str, unit: str, frame: str) -> ColumnGroup:
    """Return the column group of the laws' sampled quantities in this group (see `SampledQuantity`)."""
    return ColumnGroup(
        group, unit, frame, lambda p: [x for (_, x), _, _ in p.columns[group]], lambda i: i.x.column(group)
    )


def _signals(i: int) -> Callable[[SampleInstant], list[Value]]:
    """Return a function that reads values (0) or rates (1) of the signals of elastic ropes."""
    return lambda x: [x.x.signals[r.name][i] for r in x.program.system.ropes]


def _angles(p: Program) -> list[str]:
    return [f"{kind} {name} {i}" for kind, name, i in p.angles]


def _one(p: Program) -> list[str]:
    return [""]


ROW = (
    ColumnGroup("q", "m or rad", "joint", _coordinates, lambda i: i.x.q),
    ColumnGroup("v", "m/s or rad/s", "joint", _velocities, lambda i: i.x.v),
    ColumnGroup("accounts", "J", "", lambda p: [f"{what} {x}" for what, x in p.accounts], lambda i: i.x.accounts),
    ColumnGroup("turned", "rad", "joint", _angles, lambda i: [i.x.turned[label] for label in i.program.angles]),
    _law("tension", "N", "rope"),
    ColumnGroup("length", "m", "rope", _names("ropes"), _signals(0)),
    ColumnGroup("length_rate", "m/s", "rope", _names("ropes"), _signals(1)),
    _law("elongation", "m", "rope"),
    _law("normal", "N", "world"),
    _law("place", "m or rad", "world, joint"),
    _law("velocity", "m/s or rad/s", "world, joint"),
    ColumnGroup("stored", "J", "", lambda p: [x for _, x in p.stores],
            lambda i: [i.x.stored[k] for k in i.program.stores]),
    _law("shown", "of the law", "of the law"),
    ColumnGroup("poses", "m, 1", "world", lambda p: [k.body.name for k in p.graph.links for _ in range(12)],
            lambda i: i.energies[0]),
    ColumnGroup("kinetic", "J", "", _one, lambda i: i.energies[1], single=True),
    ColumnGroup("potential", "J", "", _one, lambda i: i.energies[2], single=True),
    ColumnGroup("loop", "N, N m", "world", lambda p: [j.name for j in p.graph.loops for _ in range(6)],
            lambda i: i.loads[0]),
    ColumnGroup("pull", "N", "rope", _names("rigid_ropes"), lambda i: i.loads[1]),
    ColumnGroup("slack", "m", "rope", _names("rigid_ropes"), lambda i: i.loads[2]),
    ColumnGroup("span", "m", "rope", _names("rigid_ropes"), lambda i: i.loads[3]),
    ColumnGroup("pressing", "N", "contact", _names("contacts"), lambda i: i.x.pressing),
    ColumnGroup("axial", "N, N m", "body", lambda p: [p.graph.links[i].body.name for i in p.axial],
            lambda i: i.x.axial),
    ColumnGroup("peak", "N", "rope", _names("straight_ropes"), kept="peak"),  # since the last row, and when
    ColumnGroup("peak_time", "s", "", _names("straight_ropes"), kept="peak_time"),
    ColumnGroup("steps", "1", "", _one, kept="accepted", single=True),
)  # fmt: skip


def row_layout(program: Program) -> Layout:
    """Return the layout of the columns in a row."""
    return Layout({c.name: None if c.single else len(c.owners(program)) for c in ROW})


def columns(x: Evaluation) -> list[Value]:
    """Return the values of all columns that are computed from an evaluation."""
    instant = SampleInstant(x)
    return flatten([c.read(instant) for c in ROW if c.read])


def kept(s: StepState) -> list[Value]:
    """Return the values of the columns that the steps maintain in X."""
    return flatten([getattr(s, c.kept) for c in ROW if not c.read])


def labels(program: Program) -> list[Label]:
    """Return the owner of each column of a program's rows: group, name, number."""
    out: list[Label] = []
    for c in ROW:
        number: dict[object, int] = {}
        for name in c.owners(program):
            number[name] = number.get(name, -1) + 1
            out.append((c.name, name, number[name]))
    return out
