"""The columns of a sample row as one table: all recorded values of one instant and of the steps before it.

The native code writes rows in this order; `samples` shows them as channels, and islands are merged column by column.

Traced functions on the constraint rows of one scene.

projection   onto the rows: one Newton step of positions and velocities, weighted with the inertia.  It runs
             where a step is accepted, so that drift never accumulates, and for every sample, so that samples
             are consistent; assembly repeats it
surveying, kicking   the rows' matrix for the pivoting solver; impulses along the rows
halted       joints locked in motion: the state after the impulse (see `joint_locking`), with its heat and work
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.function import Function, Layout, flatten
from heavylift.kernel.compiler.symbol import Value
from heavylift.kernel.methods.method import StepState
from heavylift.kernel.model.evaluation import Evaluation, evaluate
from heavylift.kernel.model.program import Program
from heavylift.kernel.multibody.motion import rates

Label = tuple[str, str, int]  # group of columns, whose, which of its own


class SampleInstant:
    """An evaluation of the equations, together with values that several column groups of a sample share."""

    def __init__(self, x: Evaluation) -> None:
        self.x, self.program = x, x.program

    @cached_property
    def energies(self) -> tuple[list[Value], Value, Value]:
        """Poses of all bodies, kinetic energy and potential energy [J]."""
        return self.x.poses_and_energies()

    @cached_property
    def loads(self) -> list[list[Value]]:
        """Loads of loop joints [N, N m], and tension [N], slack and length [m] of each rigid rope."""
        values, ropes = self.x.loads(), len(self.program.system.rigid_ropes)
        first = len(values) - 3 * ropes
        return [values[:first], *(values[first + i * ropes : first + (i + 1) * ropes] for i in range(3))]


@dataclass(frozen=True)
class ColumnGroup:
    """A group of columns of a sample row, with its unit, frame, owners, and the function `read` that computes it."""

    name: str
    unit: str
    frame: str
    owners: Callable[[Program], Sequence[str]]  # names of the items that own its columns
    read: Callable[[SampleInstant], Value] | None = None
    kept: str = ""  # without `read`: its part of the state block X, which the steps maintain
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
    """Return a function that reads the values (i = 0) or rates (i = 1) of the signals of elastic ropes."""
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
    """Return the layout of the columns in a sample row."""
    return Layout({c.name: None if c.single else len(c.owners(program)) for c in ROW})


def columns(x: Evaluation) -> list[Value]:
    """Return the values of all sample columns that are computed from an evaluation."""
    instant = SampleInstant(x)
    return flatten([c.read(instant) for c in ROW if c.read])


def kept(s: StepState) -> list[Value]:
    """Return the sample columns that steps maintain in the state block X, such as peak tensions."""
    return flatten([getattr(s, c.kept) for c in ROW if not c.read])


def labels(program: Program) -> list[Label]:
    """Return, for each column of a program's sample rows, its group, the name of its owner, and its number."""
    out: list[Label] = []
    for c in ROW:
        number: dict[object, int] = {}
        for name in c.owners(program):
            number[name] = number.get(name, -1) + 1
            out.append((c.name, name, number[name]))
    return out


def projection(program: Program) -> Function:
    """Return the traced function that projects a state y onto the constraints.

    t, y, P -> place (the projected y), gap and slip (n,) of the constraint rows before, pivot (n,) (see
    `ConstraintRows.pivots`).
    """

    def body(t: Value, y: Value, P: Value) -> dict[str, Value]:
        e = evaluate(program, t[0], y, P, forces=False)
        rows = e.constraint_rows()
        gap, slip = rows.held([r.gap for r in rows.rows]), rows.held([r.rate for r in rows.rows])
        place, speed = rows.change(rows.solve([-x for x in gap])), rows.change(rows.solve([-x for x in slip]))
        out = list(y)
        for i, dx in place.items():
            tree = program.instances[i][0]
            for b in tree.bodies:
                at = tree.q.start
                q, u = e.q[at + b.q.start : at + b.q.stop], dx[b.v]
                dq = rates(b.kind, np.array(q), u)
                out[at + b.q.start : at + b.q.stop] = [x + d for x, d in zip(q, dq, strict=True)]
                for k, m in zip(range(b.q_modes.start, b.q_modes.stop), dx[b.v_modes], strict=True):
                    out[at + k] = out[at + k] + m
            first = program.nq + tree.v.start
            for k, du in enumerate(speed[i]):
                out[first + k] = out[first + k] + du
        return {"place": out, "gap": gap, "slip": slip, "pivot": rows.pivots}

    return Function("project", body, {"t": 1, "y": program.ny, "P": len(program.parameters.initial)})


def surveying(program: Program) -> Function:
    """Return the traced function that computes matrix, speeds and free accelerations of the constraint rows.

    Its arguments are t, y and P; its results: delassus (n * n,): matrix; speed, free (n,): velocities and free
    accelerations of the rows.
    """

    def body(t: Value, y: Value, P: Value) -> dict[str, Value]:
        rows = evaluate(program, t[0], y, P, t[1]).constraint_rows()
        return {
            "delassus": rows.entries(),
            "speed": rows.held([r.rate for r in rows.rows]),
            "free": rows.held(rows.free),
        }

    return Function("survey_rows", body, {"t": 2, "y": program.ny, "P": len(program.parameters.initial)})


def kicking(program: Program) -> Function:
    """Return the traced function t, y, P, x -> after: the state after impulses x (n,) on the constraint rows [N s]."""

    def body(t: Value, y: Value, P: Value, x: Value) -> dict[str, Value]:
        rows = evaluate(program, t[0], y, P, forces=False).constraint_rows()
        out = list(y)
        for i, dv in rows.change(x).items():
            first = program.nq + program.instances[i][0].v.start
            for k, du in enumerate(dv, first):
                out[k] = out[k] + du
        return {"after": out}

    sizes = {"t": 1, "y": program.ny, "P": len(program.parameters.initial), "x": len(program.constraints)}
    return Function("kick_rows", body, sizes)


def survey(s: StepState, P: Value, f: Function, inside: Value) -> None:
    """Write Delassus matrix, speeds and free accelerations of the constraint rows at (t, y) into the work block."""
    x = f(t=[s.t, inside], y=s.y, P=P)
    s.delassus, s.speed, s.free = x.delassus, x.speed, x.free


def kick(s: StepState, P: Value, f: Function) -> None:
    """Apply the impulses [N s] in the work block to the state y in the same block."""
    s.y = f(t=[s.t], y=s.y, P=P, x=s.impulse).after


def halted(x: Evaluation) -> Value:
    """Return the state (ny,) after impulses stop all locked joints, with their heat and work in the energy accounts."""
    p = x.program
    v, accounts = list(x.v), dict(zip(p.accounts, x.accounts, strict=True))
    locks = {lock.joint: lock.name for lock in p.system.locks}
    drives = {p.driven(d)[1]: d.name for d in p.system.drives}
    for i, (tree, shared) in enumerate(p.instances):
        if not tree.locked_dofs:
            continue
        out = shared.halt(q=x.q[tree.q], v=x.v[tree.v], P=x.numbers("tree", str(i)))
        v[tree.v] = list(out.after)
        for k, impulse in zip(tree.prescribed_dofs, out.impulse, strict=True):
            n, speed = tree.v.start + k, x.v[tree.v.start + k]
            if k in tree.locked_dofs:
                joint = p.graph.links[tree.first + tree.body_of_dof[k]].joint.name
                account, work = ("heat", locks[joint]), -0.5 * impulse * speed
            else:
                account, work = ("work", drives[n]), impulse * speed
            accounts[account] = accounts[account] + work
    return join(x.q, v, list(accounts.values()), x.counted)
