"""The equations of a whole scene at one instant: places -> laws -> forces -> accelerations.

The one text that the float oracle runs and the tracer turns into machine code.  Each method is one stage; they run in
the order in which they stand: `poses`, then `applied_forces`, then here accelerations, thresholds, and what samples
show.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.symbol import maximum, sqrt
from heavylift.kernel.constraints.rows import Rows
from heavylift.kernel.description.mechanics import Drive, RigidRope, Threshold
from heavylift.kernel.forces import laws

from .applied_forces import Applying
from .poses import Reference
from .program import Program

__all__ = ["Evaluation", "evaluate"]

ROUNDED = 1e-14  # part of the coordinates that rows may gape by rounding


def evaluate(program: Program, t: Any, y: Any, P: Any, inside: Any = None, forces: bool = True) -> Evaluation:
    """The scene's equations at time t [s]; `inside`: a time within the present step (see `laws.profile`)."""
    return Evaluation(program, t, y, P, t if inside is None else inside, forces)


class Evaluation(Applying):
    """`dy`, `tensions`, `guards` and what samples show, at time t [s], state y, parameters P.

    Without `forces` nothing is known but where the bodies are and how they move.
    """

    def __init__(self, program: Program, t: Any, y: Any, P: Any, inside: Any, forces: bool = True) -> None:
        super().__init__(program, t, y, P, inside, forces)
        self.loads: Callable[[], list[Any]] = list  # of the joints that close loops
        self.lengths_of: dict[str, Reference] = {}  # of rigid ropes
        self._held: Rows | None = None
        self.pressing: list[Any] = []  # normal force per contact
        if forces:
            self._accelerate()
            self._thresholds()

    @property
    def pulls(self) -> list[Any]:
        """Tensions of all ropes of straight lines, the rigid ones last [N]."""
        rigid = self._held.told if self._held else {}
        return [*self.tensions, *(rigid.get(r.name, 0.0) for r in self.system.rigid_ropes)]

    @property
    def reach(self) -> Any:
        """Longest step from here in which no shape passes through another [s]."""
        return self.program.contacts.reach(self.numbers, self._ends)

    @property
    def window(self) -> Any:
        """The same, for steps that it does not bound."""
        return self.reach

    @property
    def drift(self) -> Any:
        """Widest gap of the rows that are there [m or rad], beyond what round-off makes of the coordinates."""
        widest: Any = 0.0
        for gap in self._held.held([abs(row.gap) for row in self._held.rows]) if self._held else ():
            widest = maximum(widest, gap)
        return maximum(widest - ROUNDED * sqrt(sum(x * x for x in self.q)), 0.0)

    # ---- accelerations and guards ------------------------------------------------------------------------

    def _accelerate(self) -> None:
        dq: list[Any] = []
        dv: list[Any] = []
        rows = self._held = self.constraint_rows() if len(self.program.constraints) else None
        if rows:
            rows.accelerate()
            self.loads = rows.loads
        for i, (_, shared) in enumerate(self.program.instances):
            drives = self._prescribed(i)
            tied = i in self.program.constraints.linked  # by more than a rope that is left out
            x = rows.motion(i) if rows and tied else shared.accelerate(**self._arguments(i))
            dq += list(x.dq)
            dv += list(x.dv)
            for d, force in zip(drives, x.reaction, strict=False):
                if d:  # it carries what the other laws of its joint do not
                    self._drive_work[d.name] = force * self._references[d.name][1]
        fell = rows.guards() if rows else {}
        self.guards += [fell.get(r.name, 1.0) for r in self.system.rigid_ropes]
        self._heat += [0.0 for _ in self.system.rigid_ropes]  # made at once, see `constraints.rigid_ropes`
        self.stored += self._own.values()
        self._contacts(rows)
        self._heat += [0.0 for _ in self.system.locks]  # made at once, see `joint_locking`
        for body, wrench in rows.wrenches() if rows else ():
            self._push(body, wrench)
        self._work += [self._drive_work[d.name] for d in self.system.drives]
        for r in self.system.rigid_ropes:
            if r.winch:
                pulls = rows and r.name in rows.tensions
                self._work.append(-rows.tensions[r.name] * self.lengths_of[r.name][1] if rows and pulls else 0.0)
        self.dy = join(dq, dv, self._heat, self._work, [self.turning[label] for label in self.program.angles])

    def _contacts(self, rows: Rows | None) -> None:
        contacts = self.program.contacts
        slots, pushes = (rows.slots, rows.multipliers[len(rows.rows) - len(contacts.held) :]) if rows else ([], [])
        guards, heat, self.pressing = contacts.loads(slots, pushes)
        self.guards += contacts.watched(self.numbers, self._ends) + guards
        self._heat += heat
        self.stored += [0.0 for _ in heat]

    def _prescribed(self, i: int) -> list[Drive | None]:
        """Drives that prescribe degrees of freedom of a tree, in their order; None: locked."""
        drives = {self.program.driven(d)[1]: d for d in self.system.drives if d.kind == "prescribed"}
        tree = self.program.instances[i][0]
        return [drives.get(tree.v.start + k) for k in tree.prescribed_dofs]

    def _arguments(self, i: int) -> dict[str, Any]:
        """What the motion of the i-th tree depends on."""
        tree, shared = self.program.instances[i]
        return {
            "q": self.q[tree.q],
            "v": self.v[tree.v],
            "tau": self._tau[tree.v] or [0.0],
            "P": self.numbers("tree", str(i)),
            "g": [self.gravity],
            "a": [self._references[d.name][2] if d else 0.0 for d in self._prescribed(i)] or [0.0],
            **{f"w{b}": self._wrenches[tree.first + b] for b in shared.ends},
        }

    def length_of(self, r: RigidRope) -> Reference:
        """Of a rigid rope, with two rates."""
        return self._reference(r.name) if r.winch else (self.numbers("reference", r.name)[1], 0.0, 0.0)

    def constraint_rows(self) -> Rows:
        """The constraint rows under the forces known so far; those of the accelerations once these are known."""
        if self._held:
            return self._held
        arguments = {i: self._arguments(i) for i in self.program.constraints.linked}
        for r in self.system.rigid_ropes:
            self.lengths_of[r.name] = self.length_of(r)
        return Rows(self.program, arguments, self._ends, self.numbers, self.lengths_of)

    def _thresholds(self) -> None:
        self.guards += [self._threshold(h) for h in self.system.thresholds]

    def _threshold(self, h: Threshold) -> Any:
        """a x + b; Python sets a and b when a threshold is armed."""
        p = self.numbers("threshold", h.name)
        a, b = p[:2]
        if h.quantity == "angle":
            return a * self.turned["body", h.of, h.axis] + b
        ropes = zip(self.system.ropes, self.tensions, self.lengths, strict=True)
        known = {r.name: (tension, length) for r, tension, length in ropes} | self._reeved
        told = self._held.told if self._held else {}
        for r in self.system.rigid_ropes:  # one that is left out pulls nothing
            known[r.name] = told.get(r.name, 0.0), (self.lengths_of.get(r.name) or self.length_of(r))[0]
        if h.quantity == "height":
            assert h.point is not None, "checked by the program"
            x = laws.attachment(self._ends[self.graph.number(h.point.body)], p[2:5])[1][2]
        elif h.quantity == "tension":
            x = sum((known[r][0] for r in h.ropes), 0.0)
        elif h.quantity == "length":
            x = known[h.ropes[0]][1]
        else:
            x = self._joint(h.name, h.of, h.coordinate)[1 if h.quantity == "joint" else 2]
        return a * x + b

    @property
    def axial(self) -> list[Any]:
        """What flexible bodies carry along themselves (see `multibody.inverse_dynamics.axial_loads`)."""
        out: list[Any] = []
        dv = self.dy[self.program.nq : self.program.nq + self.program.nv]
        for i, (tree, shared) in enumerate(self.program.instances):
            if shared.axial:
                given = self._arguments(i)
                known = {k: given[k] for k in given if k not in ("tau", "a")}
                out += list(shared.axial(**known, dv=dv[tree.v]).loads)
        return out

    # ---- for samples -------------------------------------------------------------------------------------

    def poses_and_energies(self) -> tuple[list[Any], Any, Any]:
        """Origin and rotation of every body (12 numbers each), kinetic and gravitational energy [J]."""
        poses: list[Any] = []
        kinetic: Any = 0.0
        potential: Any = 0.0
        for i, (tree, shared) in enumerate(self.program.instances):
            numbers = self.numbers("tree", str(i))
            x = shared.pose(q=self.q[tree.q], v=self.v[tree.v], P=numbers, g=[self.gravity])
            poses += list(x.poses)
            kinetic, potential = kinetic + x.energy[0], potential + x.energy[1]
        return poses, kinetic, potential
