"""A compiled scene: layout of state, parameters, guards and energy accounts, and the functions of equal parts.

State y = [q, v, w]: coordinates, velocities, and one integral per law of the work it takes or the heat it produces.
Equal trees and equal laws share one traced function each, called for every instance with its own numbers: the code
stays small however large the scene.
"""

from functools import cached_property
from types import SimpleNamespace
from typing import Any

import numpy as np
from heavylift.kernel.algebra.spatial import exact
from heavylift.kernel.compiler.function import Function
from heavylift.kernel.compiler.symbol import Array
from heavylift.kernel.constraints.contact.contact_points import ContactPointRows
from heavylift.kernel.constraints.loop_closures import CLOSURES
from heavylift.kernel.constraints.row_structure import Constraints
from heavylift.kernel.description.forces import Radiation
from heavylift.kernel.description.mechanics import JOINTS, WORLD, Drive, System
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.force_law import Poses, SampledQuantity, Setting
from heavylift.kernel.forces.reeving import check_parallel
from heavylift.kernel.forces.ropes import led_ends, straight_drives, with_rope_masses
from heavylift.kernel.forces.table import SharedForce, shared
from heavylift.kernel.multibody.continuous_angles import AXES, Label as AngleLabel, turned_at_start
from heavylift.kernel.multibody.graph import Graph, Link, build_graph
from heavylift.kernel.multibody.joint_locking import check_locks, merged
from heavylift.kernel.multibody.kinematics import kinematics
from heavylift.kernel.multibody.trees import Tree, cut

from .checks import check_description
from .parameters import PROFILE, ParameterLayout
from .quantities import check_signal, points as quantity_points
from .traced_functions import SharedTree, profile, shared_tree

Label = tuple[str, str]  # kind and name: of a law, a guard, an account
COLUMNS = ("tension", "elongation", "normal", "place", "velocity", "shown")  # groups that laws fill
_made: "list[tuple[System, tuple[object, ...], Program]]" = []  # the last ones, as descriptions that were checked
MOST = 16


def program_of(system: System, *how: Any) -> "Program":
    """Return the compiled program of a system, from a cache if it was compiled recently and contains no user code."""
    system = check_description(system)
    if system.functions:
        return Program(system, *how)
    found = next((x for of, given, x in _made if of is system and given == how), None) or Program(system, *how)
    _made[:] = [(system, how, found), *(x for x in _made if x[2] is not found)][:MOST]
    return found


class Program:
    """A compiled system: layout of its state and parameters, and its traced functions.

    Raises KernelError if a law names a missing part or two drives act on one joint.

    `formulation`: equations for the accelerations, see `kernel.multibody.formulations`; `locked`: names of the engaged
    locks, None for those engaged at the start; `clamped`, `at_rest`, `calm`: see `Setting`.
    """

    def __init__(
        self,
        system: System,
        formulation: str = "recursive",
        locked: frozenset[str] | None = None,
        clamped: bool = True,
        at_rest: bool = False,
        calm: frozenset[str] = frozenset(),
    ) -> None:
        system = check_description(system)
        self.formulation, self.clamped, self.at_rest = formulation, clamped, at_rest
        trees = self._cut(system, locked)
        system = self.system
        setting = Setting(self.graph, self.poses_at_start, system.gravity, clamped, at_rest, calm)
        self.laws = shared(system.laws, setting)
        self.parameters = ParameterLayout.of(system, self.graph, trees, self.laws)
        self.nq, self.nv = self.graph.nq, self.graph.nv
        self._label()
        self.ny = self.nq + self.nv + len(self.accounts) + len(self.angles)
        self.quaternions = [
            k.q.start + start for k in self.graph.links if (start := JOINTS[k.joint.kind].quaternion) is not None
        ]
        self.profile = Function("profile", profile, {"t": 2, "p": PROFILE})
        self.calm = calm

    def _cut(self, system: System, locked: frozenset[str] | None) -> list[Tree]:
        """Build the graph, the rows, the trees with their functions and the start poses; return the trees with the
        numbers that are used for tracing."""
        modes = None
        if any(b.flexible for b in system.bodies):
            from heavylift.kernel.multibody.flexible.tracks import (
                with_stations,  # needs linear algebra, which rigid scenes do not
            )

            system, modes = with_stations(system)
            if self.formulation != "recursive":
                raise KernelError(
                    f"body '{next(iter(modes))}' is flexible, but formulation '{self.formulation}' "
                    "supports only rigid bodies; choose recursive"
                )
        self.system = with_rope_masses(system)
        self.graph = build_graph(self.system, modes)
        self.led = [*led_ends(self.system, self.graph)]
        self.moved_by = {name: body for name, (body, _) in straight_drives(self.system, self.graph).items()}
        self._check_loops()
        if self.formulation != "recursive" and (pair := next((b for b in system.bodies if b.shared), None)):
            message = f"body '{pair.name}' shares water, but formulation '{self.formulation}' keeps bodies apart"
            raise KernelError(f"{message}; choose recursive")
        self._check_contacts()
        self._check()
        self.locked = frozenset(x.name for x in system.locks if x.engaged) if locked is None else locked
        held = frozenset(x.joint for x in system.locks if x.name in self.locked)
        self.trees = cut(self.graph, {self.driven(d)[1] for d in system.drives if d.kind == "prescribed"}, held)
        traced = [merged(tree) for tree in self.trees] if self.formulation == "recursive" else self.trees
        self.poses_at_start = _poses_at_start(self.graph, traced)
        for rope in self.system.reevings:
            check_parallel(rope, self.graph, self.poses_at_start)
        self.contacts = ContactPointRows(self.system, self.graph)
        self.constraints = Constraints(self.graph, self.system.rigid_ropes, self.contacts)
        self.instances = self._share(traced)
        self.constraints.link(self.instances)
        return traced

    def _label(self) -> None:
        """List accounts, angles, guards and columns by kind and name, in the order of the state and of samples."""
        s, laws = self.system, [(x.law.kind, x.name) for x in self.laws]
        bending, rigid = ([(kind, name) for name in names] for kind, names in (
            ("bending", [k.body.name for k in self.graph.links if k.n_modes]),
            ("rigid", [r.name for r in s.rigid_ropes]),
        ))  # fmt: skip
        self.stores: list[Label] = [*laws, *bending, *rigid, *(("contact", c.name) for c in s.contacts)]
        self.heats: list[Label] = [*self.stores, *(("lock", x.name) for x in s.locks)]
        self.works: list[Label] = [label for label, x in zip(laws, self.laws, strict=True) if x.law.works]
        self.works += [("drive", d.name) for d in s.drives] + [("rigid", r.name) for r in s.rigid_ropes if r.winch]
        self.accounts = [(what, name) for what, of in (("heat", self.heats), ("work", self.works)) for _, name in of]
        attitudes = {("body", m.of, m.axis) for m in s.measured if m.kind == "angle"}
        attitudes |= {("body", h.of, h.axis) for h in s.thresholds if h.quantity == "angle"}
        self.angles: list[AngleLabel] = sorted(attitudes)
        self.angles += [("force", x.name, i) for x in self.laws for i in range(x.angles)]
        self.of_guard: dict[Label, SharedForce] = {(guard, x.name): x for x in self.laws for guard in x.guards}
        self.guards: list[Label] = [*self.of_guard, *bending, *rigid, *self.contacts.guards]
        self.guards += [("threshold", h.name) for h in s.thresholds]
        self.columns: dict[str, list[tuple[Label, int, SampledQuantity]]] = {group: [] for group in COLUMNS}
        self._places: dict[Label, list[tuple[str, int]]] = {label: [] for label in laws}
        for label, x in zip(laws, self.laws, strict=True):
            for i, shown in enumerate(x.shows):
                column = self.columns[shown.column]
                self._places[label].append((shown.column, len(column)))
                column.append((label, i, shown))

    def shown(self, law: SharedForce, row: SimpleNamespace) -> np.ndarray:
        """Return the sampled quantities of a force law from a sample row, in the order of `LawOutput.shown`."""
        return np.array([getattr(row, group)[i] for group, i in self._places[law.law.kind, law.name]])

    def _check(self) -> None:
        s = self.system
        along = [(x.name, *x.along) for x in s.laws if x.along]
        along += [(m.name, m.of, m.coordinate) for m in s.measured if m.kind == "joint"]
        along += [(h.name, h.of, h.coordinate) for h in s.thresholds if h.quantity in ("joint", "speed")]
        for name, joint, coordinate in along:
            self.graph.coordinate(name, joint, coordinate)
        drives: dict[int, str] = {}
        for d in s.drives:
            k = self.driven(d)[1]
            if k in drives:
                raise KernelError(f"drive '{d.name}': joint '{d.joint}' already has the drive '{drives[k]}'")
            drives[k] = d.name
        check_locks(s, self.graph)
        for h in s.thresholds:
            check_signal(h, s, f"threshold '{h.name}'")

    def driven(self, drive: Drive) -> tuple[int, int]:
        """Return the indices of a drive's joint coordinate in q and of its rate in v."""
        return self.graph.coordinate(drive.name, drive.joint, drive.coordinate)

    def _check_loops(self) -> None:
        for j in self.graph.loops:
            if j.kind not in CLOSURES:
                raise KernelError(
                    f"joint '{j.name}': a {j.kind} joint cannot close a loop; close it by another of its joints"
                )
            if self.formulation != "recursive":
                raise KernelError(
                    f"joint '{j.name}' closes a loop, but formulation '{self.formulation}' "
                    "supports only trees; choose recursive"
                )
            for k in self.graph.links:
                if k.modes and k.body.name in (j.parent, j.child):
                    raise KernelError(
                        f"joint '{j.name}' closes a loop on the flexible body '{k.body.name}'; attach a "
                        "rigid body to it there, and connect the joint to that body"
                    )

    def _check_contacts(self) -> None:
        for c in self.system.contacts:
            if self.formulation != "recursive":
                raise KernelError(
                    f"contact '{c.name}': formulation '{self.formulation}' does not support contacts; choose recursive"
                )
            if c.a.body == "world":
                raise KernelError(f"contact '{c.name}': its first shape belongs to the ground; name a body first")
            for k in self.graph.links:
                if k.modes and k.body.name in (c.a.body, c.b.body):
                    raise KernelError(
                        f"contact '{c.name}': '{k.body.name}' is flexible; attach a rigid body to it for the contact"
                    )

    def initial_state(self) -> np.ndarray:
        """Return the state (ny,) at the start of a run."""
        y = np.zeros(self.ny)
        for k in self.graph.links:
            y[k.q.start : k.q_modes.stop] = k.q0
            y[self.nq + k.v.start : self.nq + k.v.stop] = k.joint.v0 or (0.0,) * (k.v.stop - k.v.start)
        return y

    @cached_property
    def memory(self) -> dict[tuple[str, int], int]:
        """Indices in the state y of the memory states of wave radiation, by force and number."""
        names, first = {x.name for x in self.system.forces if isinstance(x, Radiation)}, self.ny - len(self.angles)
        of = {(name, n): first + i for i, (kind, name, n) in enumerate(self.angles) if kind == "force"}
        return {label: place for label, place in of.items() if label[0] in names}

    @cached_property
    def axial(self) -> list[int]:
        """For each entry of the list `Evaluation.axial` of axial loads, the link number of the loaded flexible body."""
        number = self.graph.number
        return [number(k.body.name) for k, on, _ in self.compressible for _ in range(3 * (2 + len(on)))]

    @cached_property
    def compressible(self) -> list[tuple[Link, list[Link], slice]]:
        """Flexible bodies that may buckle, each with the links attached to it and the indices of its axial loads."""
        found, first = list[tuple[Link, list[Link], slice]](), 0
        for i, link in enumerate(self.graph.links):
            if link.n_modes:
                on = [k for k in self.graph.links if k.parent == i]
                found.append((link, on, slice(first, first + len(on) + 2)))
                first += len(on) + 2
        return found

    @cached_property
    def sliders(self) -> list[tuple[Link, float]]:
        """The sliders on beams, each with the length of its beam [m]."""
        carriers = ((k, self.graph.links[k.parent].modes) for k in self.graph.links if k.joint.kind == "slider")
        return [(k, x.flexible.beam.length if x and x.flexible.beam else 0.0) for k, x in carriers]

    def turned_at_start(self, label: AngleLabel) -> float:
        """Return the angle [rad] by which joints have turned two bodies relative to each other before the start."""
        kind, name, i = label
        if kind == "body":
            a, b, axis = WORLD, name, np.array(AXES[i])
        else:
            force = next(x for x in self.laws if x.name == name)
            if not (turns := force.law.turns(force.force, self.poses_at_start)):
                return 0.0
            a, b, axis = turns
        return turned_at_start(self.graph, self.poses_at_start, a, b, axis)

    def sharing(self, tree: Tree) -> str:
        """Return a key that is equal for trees which share their traced functions."""
        return tree.kind

    def _share(self, trees: list[Tree]) -> list[tuple[Tree, SharedTree]]:
        s, number = self.system, self.graph.number
        bodies = [p.body for x in s.laws for p in x.points] + [m.of for m in s.measured if m.kind == "angle"]
        bodies += [point.body for h in s.thresholds for point in quantity_points(h, s)]
        bodies += [h.of for h in s.thresholds if h.quantity == "angle"]
        bodies += [body for x in self.led for body in (x.body, *(self.moved_by[d] for d in x.drives))]
        used = {number(b) for b in bodies} | set(self.constraints.bodies)
        kinds: dict[str, SharedTree] = {}
        out = []
        for t in trees:
            ends = tuple(i for i in range(len(t.bodies)) if t.first + i in used)
            held = tuple(i for i in ends if t.first + i in self.constraints.bodies)
            key = self.sharing(t) + str(ends) + str(held)
            if key not in kinds:
                kinds[key] = shared_tree(key, len(kinds), t, ends, held, self.formulation)
            out.append((t, kinds[key]))
        return out


def _poses_at_start(graph: Graph, trees: list[Tree]) -> Poses:
    """Return the initial poses as a function: body -> rotation and origin, for laws that depend on them."""

    def pose(body: str) -> tuple[Array, Array]:
        i = graph.number(body)
        if i < 0:
            return exact(np.eye(3)), exact(np.zeros(3))
        tree = next(t for t in trees if t.first <= i < t.first + len(t.bodies))
        links = graph.links[tree.first : tree.first + len(tree.bodies)]
        q = exact([x for k in links for x in k.q0])
        at_rest = np.zeros(tree.v.stop - tree.v.start)
        K = kinematics(tree, q, at_rest, 0.0, [0.0] * len(tree.prescribed_dofs))
        return K.R[i - tree.first], K.o + K.r[i - tree.first]

    return pose
