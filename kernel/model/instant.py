"""The state of a scene at one instant: fields that the stages of an evaluation fill in, and quantities computed from
them.

Every field is written by the stages that name it (see `evaluation`); a label is the kind and the name of a law.

The first stages of an evaluation: references of drives and winches, then poses and twists of all bodies.

Prescribed joints follow commanded masters only, so that poses are known before anything is measured; servos and winches
may follow measured ones as well. A reference is a profile plus f(s) = k1 s + kc cos s + ks sin s of masters.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from operator import add
from types import SimpleNamespace
from typing import cast

import numpy as np
from heavylift.kernel.algebra.elementary import atan2, cos, sin
from heavylift.kernel.algebra.spatial import cross
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, maximum, minimum, named, sqrt
from heavylift.kernel.constraints.rows import ConstraintRows
from heavylift.kernel.description.forces import InputSignal
from heavylift.kernel.description.mechanics import Drive, RigidRope
from heavylift.kernel.forces.force_law import Poses
from heavylift.kernel.multibody.continuous_angles import Label as AngleLabel, on_turn

from .program import Label, Program

GROUND = np.concatenate([np.eye(3).ravel(), np.zeros(12)])
ROUNDED = 1e-14  # part of the coordinates that rows may gape by rounding
Reference = tuple[Scalar, Scalar, Scalar]  # value, rate, acceleration
Master = tuple[Scalar, Scalar, Scalar, Scalar, Scalar]  # s, ds/dt, d2s/dt2, sin s, cos s


@dataclass
class Evaluation:
    """Result of evaluating the equations of a scene at one state, in floats or symbols; steps use `dy` and `guards`."""

    program: Program
    t: Scalar  # [s] since the epoch
    inside: Scalar  # a time within the present step, which says what piece of a profile is meant
    P: Array
    q: list[Scalar]
    v: list[Scalar]
    accounts: list[Scalar]
    counted: list[Scalar] = field(default_factory=list)  # integrals of the angles

    masters: list[Master] = field(default_factory=list)
    references: dict[str, Reference] = field(default_factory=dict)  # of drives
    ends: dict[int, Array] = field(default_factory=lambda: {-1: GROUND})  # (21,) of bodies with laws, see `attachment`
    turned: dict[AngleLabel, Scalar] = field(default_factory=dict)  # angles over all their turns
    turning: dict[AngleLabel, Scalar] = field(default_factory=dict)  # their rates

    leading: dict[str, Scalar] = field(default_factory=dict)  # power of a drive on rope ends beyond its joint [W]
    wrenches: list[Array] = field(default_factory=list)  # (6,) per link about its tree's point
    tau: list[Scalar] = field(default_factory=list)  # (nv,)
    signals: dict[str, list[Scalar]] = field(default_factory=dict)  # value and rate
    shown: dict[Label, list[Scalar]] = field(default_factory=dict)  # what samples hold of each law
    heat: dict[Label, Scalar] = field(default_factory=dict)  # [W]
    work: dict[Label, Scalar] = field(default_factory=dict)  # [W]
    stored: dict[Label, Scalar] = field(default_factory=dict)  # [J]
    watched: dict[Label, list[Scalar]] = field(default_factory=dict)  # guards by their names

    lengths_of: dict[str, Reference] = field(default_factory=dict)  # of rigid ropes
    rows: ConstraintRows | None = None
    loads: Callable[[], list[Scalar]] = list  # of the joints that close loops
    pressing: list[Scalar] = field(default_factory=list)  # normal force per contact
    dq: list[Scalar] = field(default_factory=list)
    dv: list[Scalar] = field(default_factory=list)
    dy: Array = field(default_factory=lambda: np.zeros(0))  # (ny,) derivative of the state
    guards: list[Scalar] = field(default_factory=list)  # in the order of the program

    def numbers(self, kind: str, name: str) -> Array:
        """Return the parameters of an item, such as a law or a tree, from the parameter block P."""
        return self.P[self.program.parameters.at[kind, name]]

    @property
    def gravity(self) -> Scalar:
        g: Scalar = self.numbers("gravity", "")[0]
        return g

    def push(self, body: int, wrench: Array) -> None:
        """Add a wrench (6,) to the wrenches on a body."""
        if body >= 0:
            self.wrenches[body] = self.wrenches[body] + wrench

    def arguments(self, i: int) -> dict[str, Scalars]:
        """Return the arguments (coordinates, velocities, forces) of the equations of motion of the i-th tree."""
        tree, shared = self.program.instances[i]
        return {
            "q": self.q[tree.q],
            "v": self.v[tree.v],
            "tau": self.tau[tree.v] or [0.0],
            "P": self.numbers("tree", str(i)),
            "g": [self.gravity],
            "a": [self.references[d.name][2] if d else 0.0 for d in self.prescribed(i)] or [0.0],
            **{f"w{b}": self.wrenches[tree.first + b] for b in shared.ends},
        }

    def prescribed(self, i: int) -> list[Drive | None]:
        """Return, for each prescribed degree of freedom of the i-th tree in order, the drive that prescribes it, or
        None if it is locked."""
        drives = {self.program.driven(d)[1]: d for d in self.program.system.drives if d.kind == "prescribed"}
        tree = self.program.instances[i][0]
        return [drives.get(tree.v.start + k) for k in tree.prescribed_dofs]

    def own(self, name: str) -> Reference:
        """Return the reference (value, rate, acceleration) from an actuator's or master signal's own speed profile."""
        x = self.program.profile(t=[self.t, self.inside], p=self.numbers("reference", name))
        return x.x[0], x.v[0], x.a[0]

    def reference(self, name: str) -> Reference:
        """Return the reference of an actuator: its own profile plus functions f(s) of followed master signals s.

        f(s) = k1 s + kc cos s + ks sin s.
        """
        ref, dref, ddref = self.own(name)
        follow = self.numbers("follow", name)
        for i, (s, ds, dds, sine, cosine) in enumerate(self.masters):
            k1, kc, ks = follow[3 * i : 3 * i + 3]
            slope = k1 - kc * sine + ks * cosine
            ref = ref + k1 * s + kc * cosine + ks * sine
            dref = dref + slope * ds
            ddref = ddref + slope * dds - (kc * cosine + ks * sine) * ds * ds
        return named(f"s({name})", ref), named(f"ds({name})", dref), named(f"dds({name})", ddref)

    def wave(self, name: str, given: Drive | InputSignal) -> Reference:
        """Return the sum of all waves of a drive or signal, with two derivatives; zero when equilibria are sought."""
        found: Reference = (0.0, 0.0, 0.0)
        if self.program.at_rest:
            return found
        if given.wave:
            found = self._regular(name)
        if given.waves:
            start, a, b, c, d = self.numbers("waves", name)
            u = self.t - start
            piece = a + u * (b + u * (c + u * d)), b + u * (2.0 * c + 3.0 * u * d), 2.0 * c + 6.0 * u * d
            found = cast(Reference, tuple(map(add, found, piece)))
        return found

    def _regular(self, name: str) -> Reference:
        amplitude, frequency, phase, rate = self.numbers("wave", name)
        t = self.numbers("clock", "")[0] + self.t
        u = minimum(t * rate, 1.0)
        r, dr = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u), 30.0 * u * u * (1.0 - u) * (1.0 - u) * rate
        ddr = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) * rate * rate
        c, s = amplitude * cos(frequency * t + phase), amplitude * frequency * sin(frequency * t + phase)
        return r * c, dr * c - r * s, ddr * c - 2.0 * dr * s - r * frequency * frequency * c

    def length_of(self, r: RigidRope) -> Reference:
        """Return the unstretched length of a rigid rope [m] and its first two derivatives."""
        return self.reference(r.name) if r.winch else (self.numbers("reference", r.name)[1], 0.0, 0.0)

    def constraint_rows(self) -> ConstraintRows:
        """Return the constraint rows under the forces known so far; after `accelerate`, with their multipliers."""
        if self.rows:
            return self.rows
        for r in self.program.system.rigid_ropes:
            self.lengths_of[r.name] = self.length_of(r)
        arguments = {i: self.arguments(i) for i in self.program.constraints.linked}
        return ConstraintRows(self.program, arguments, self.ends, self.numbers, self.lengths_of)

    # ---- what steps ask for -------------------------------------------------------------------------------

    @property
    def pulls(self) -> list[Scalar]:
        """The tensions [N] of all ropes over straight lines: elastic ones, then rigid ones."""
        return [*self.tensions, *(self.rows.end_tensions.values() if self.rows else ())]

    @property
    def tensions(self) -> list[Scalar]:
        """Tensions of elastic ropes over straight lines [N]."""
        return self.column("tension")

    @property
    def lengths(self) -> list[Scalar]:
        """Unstretched lengths of the elastic ropes [m]."""
        return [self.signals[r.name][0] for r in self.program.system.ropes]

    @property
    def reach(self) -> Scalar:
        """Longest step [s] from this state in which shapes in contact cannot pass through each other."""
        longest: Scalar = self.program.contacts.reach(self.numbers, self.ends)
        return longest

    @property
    def window(self) -> Scalar:
        """Longest step [s] in which shapes in contact cannot pass through each other, for checks of fixed steps."""
        return self.reach

    @property
    def drift(self) -> Scalar:
        """The largest residual of active constraint rows [m or rad], less the round-off of the coordinates."""
        widest: Scalar = 0.0
        for gap in self.rows.held([abs(row.gap) for row in self.rows.rows]) if self.rows else ():
            widest = maximum(widest, gap)
        widest = maximum(widest - ROUNDED * sqrt(sum(x * x for x in self.q)), 0.0)
        return widest

    # ---- what samples ask for -----------------------------------------------------------------------------

    def column(self, group: str) -> list[Scalar]:
        """Return the values of one group of sampled quantities, such as all tensions, over all force laws."""
        return [self.shown[label][i] for label, i, _ in self.program.columns[group]]

    @property
    def axial(self) -> list[Scalar]:
        """Forces [N], accelerations [m/s2] and angular velocities [rad/s] that load flexible bodies axially."""
        out: list[Scalar] = []
        for i, (tree, shared) in enumerate(self.program.instances):
            if shared.axial:
                known = {k: x for k, x in self.arguments(i).items() if k not in ("tau", "a")}
                out += list(shared.axial(**known, dv=self.dy[self.program.nq :][tree.v]).loads)
        return out

    def poses_and_energies(self) -> tuple[list[Scalar], Scalar, Scalar]:
        """Return origin and rotation of every body (12 numbers each), and the kinetic and gravitational energy [J]."""
        poses: list[Scalar] = []
        kinetic: Scalar = 0.0
        potential: Scalar = 0.0
        for i, (tree, shared) in enumerate(self.program.instances):
            numbers = self.numbers("tree", str(i))
            x = shared.pose(q=self.q[tree.q], v=self.v[tree.v], P=numbers, g=[self.gravity])
            poses += list(x.poses)
            kinetic, potential = kinetic + x.energy[0], potential + x.energy[1]
        return poses, kinetic, potential


def command_masters(x: Evaluation) -> None:
    """Compute the commanded master signals, which actuators follow, from their speed profiles."""
    for m in x.program.system.masters:
        value, rate, acceleration = x.own(m.name)
        s = named(f"s({m.name})", value)
        rates = named(f"ds({m.name})", rate), named(f"dds({m.name})", acceleration)
        x.masters.append((s, *rates, sin(s), cos(s)))


def prescribe_joints(x: Evaluation) -> None:
    """Set the joint coordinates that drives prescribe."""
    for d in x.program.system.drives:
        if d.kind == "prescribed":
            x.references[d.name] = x.reference(d.name)
            if d.wave or d.waves:
                x.references[d.name] = tuple(map(add, x.references[d.name], x.wave(d.name, d)))
            i, k = x.program.driven(d)
            x.q[i], x.v[k], _ = x.references[d.name]


def place_bodies(x: Evaluation) -> None:
    """Compute poses and twists of all bodies on which force laws act."""
    for i, (tree, shared) in enumerate(x.program.instances):
        if shared.ends:
            out = shared.place(q=x.q[tree.q], v=x.v[tree.v], P=x.numbers("tree", str(i)))
            x.ends |= {tree.first + b: np.array(getattr(out, f"b{b}"), dtype=object) for b in shared.ends}


def measure_angles(x: Evaluation) -> None:
    """Compute the attitudes of bodies that are measured or guarded, including full turns."""
    for i, label in enumerate(x.program.angles):
        kind, body, axis = label
        if kind == "body":
            sine, cosine, rate = attitude(x.ends[x.program.graph.number(body)], axis)
            x.turned[label] = on_turn(atan2(sine, cosine), x.counted[i])
            x.turning[label] = rate / (sine * sine + cosine * cosine)


def measure_masters(x: Evaluation) -> None:
    """Compute the measured master signals: joint coordinates and attitudes that actuators follow."""
    for m in x.program.system.measured:
        if m.kind == "joint":
            i, k = x.program.graph.coordinate(m.name, m.of, m.coordinate)
            s, ds, sine, cosine = x.q[i], x.v[k], sin(x.q[i]), cos(x.q[i])
        else:
            s, ds = x.turned["body", m.of, m.axis], x.turning["body", m.of, m.axis]
            sine, cosine, _ = attitude(x.ends[x.program.graph.number(m.of)], m.axis)
            n = 1.0 / sqrt(sine * sine + cosine * cosine)
            sine, cosine = sine * n, cosine * n
        x.masters.append((named(f"s({m.name})", s), named(f"ds({m.name})", ds), 0.0, sine, cosine))


def follow(x: Evaluation) -> None:
    """Compute the references that servo drives and speed drives follow."""
    for d in x.program.system.drives:
        if d.kind != "prescribed":
            x.references[d.name] = x.reference(d.name)


def attitude(body: Array, axis: int) -> tuple[Scalar, Scalar, Scalar]:
    """Return sine and cosine (times a common factor) of the tilt of a body's z axis, and a term for the tilt rate.

    The term is sin' cos - sin cos'. Tilt towards +y (axis 0, about -x) or +x (axis 1, about +y).
    """
    w = np.reshape(body[:9], (3, 3))[:, 2]
    dw = cross(body[15:18], w)
    i = 1 if axis == 0 else 0
    return w[i], w[2], dw[i] * w[2] - w[i] * dw[2]


def poses_of(program: Program, row: SimpleNamespace) -> Poses:
    """Return the poses in a sample row as a function from a body's name to R_WB (3, 3) and p_WB (3,)."""
    frames = row.poses.reshape(-1, 12)

    def pose(body: str) -> tuple[np.ndarray, np.ndarray]:
        i = program.graph.number(body)
        return (np.eye(3), np.zeros(3)) if i < 0 else (frames[i, 3:].reshape(3, 3), frames[i, :3])

    return pose
