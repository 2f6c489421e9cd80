"""The `mechanism:` of a scene file as a part of the plan.

This module makes the joint tree, its bodies, forces and contacts; ropes and laws along coordinates have modules of
their own. The result is a description for the kernel, with the actuators that orders can move and the parts that carry
a load at the start.
"""

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path as FilePath
from typing import Any

from heavylift.kernel.constraints.contact.pairs import check_contact
from heavylift.kernel.description import forces as forces, mechanics as k
from heavylift.kernel.description.contacts import Contact
from heavylift.kernel.description.flexible import check_flexible
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.reeving import check_parallel
from heavylift.kernel.forces.table import check_force
from heavylift.kernel.model.checks import check_inertia, check_joint
from heavylift.kernel.multibody.graph import build_graph
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.mechanism import Bend
from heavylift.nodes.scene.keys.base import written
from heavylift.nodes.scene.keys.parts import contacts, joints, kinematics, mechanics
from heavylift.nodes.scene.keys.parts.forces import CharacteristicKeys
from heavylift.nodes.scene.keys.parts.rigging import Edge
from heavylift.nodes.scene.text.source import Path, SourceText

from .checking import NONE, moments
from .elastic import SLICES, ElasticParts
from .environment.footings import footing_of
from .laws import actuators, check_curve, check_laws, laws_of
from .rigging.hooks import Hung, hang
from .rigging.tree import RiggingTree
from .ropes import reeving_of, rope_of, span

TOO_SHORT = 1e-6  # [m] that a rigid rope may lack at the start by rounding
WIRE = 1e7  # stiffness from which a rope can only be a wire rope, of 16 mm or more [N]
BREAKS = 0.02  # strain at which steel wire has broken: 1770 MPa over 105 GPa is 1.7 %
NO_LIFT = k.System()
TOUCH = 1e-9  # a rope or support this close carries [m]


def build_mechanism(
    source: SourceText,
    given: mechanics.Parts[Any],
    gravity: float,
    lift: k.System = NO_LIFT,
    base: Path = ("mechanism",),
    tree: RiggingTree | None = None,
    edges: Mapping[str, Edge] = NONE,
) -> plan.Mechanism:
    """Build a mechanism of the plan, which may also act on bodies of a lift; errors are added to the scene.

    `base`: path of the mechanism in the scene; `tree`: rigging of the scene; `edges`: edges of the scene."""
    return _Assembly(source, given, lift, base, edges).build(gravity, tree)


class _Assembly(ElasticParts):
    @property
    def called(self) -> str:
        """The name of the machine that is being built."""
        return str(self.base[-1]) if len(self.base) > 1 else self.given.name

    def build(self, gravity: float, tree: RiggingTree | None) -> plan.Mechanism:
        given = self.given
        for key in ("bodies", "joints"):
            if not (getattr(given, key) or self.carried):
                self.fault(self.base, f"the key '{key}' is missing: there is nothing else to act on", on_key=True)
        if isinstance(given.model_file, str):
            self.fault(
                (*self.base, "from"),
                "name the model file in the scene itself: settings are applied after it has been read",
            )
        self.check_tree()
        check_laws(self)
        made, bodies = tuple(self._joints()), tuple(self._bodies())
        if not self.source.faults:
            self.start = lambda: kinematics.poses(k.merge([self.lift, k.System(bodies, made)], gravity))
        plain = {name: rope for name, rope in given.ropes.items() if rope.plain}
        ropes = [rope_of(self, name, rope) for name, rope in plain.items()]
        reevings = [reeving_of(self, name, rope) for name, rope in given.ropes.items() if name not in plain]
        for name, support in given.supports.items():
            self.known((*self.base, "supports", name, "body"), support.body)
            self.on_beam((*self.base, "supports", name, "at"), support.body, support.at[0])
        bends = tuple(self.bends(bodies))
        booms = [bend for bend in bends if not bend.stiffness]
        slices = list(self.slices(booms))
        system = k.System(
            bodies=(*bodies, *(body for body, _, _ in slices)), joints=(*made, *(joint for _, joint, _ in slices)),
            ropes=tuple(r for r in ropes if isinstance(r, k.Rope)),
            rigid_ropes=tuple(r for r in ropes if isinstance(r, k.RigidRope)),
            supports=tuple(support.built(name) for name, support in given.supports.items()),
            forces=(*reevings, *self._forces()), contacts=tuple(self._contacts()), gravity=gravity, **laws_of(given),
        )  # fmt: skip
        whole = k.merge([self.lift, system], gravity)
        if not self.source.faults:
            self.checked((*self.base, "joints"), kinematics.poses, whole)
        servos = tuple(self.servos(made))
        hung = hang(self, whole, tree, gravity) if given.hooks and not self.source.faults else Hung()
        if given.hooks:
            own = k.System(tuple(hung.bodies), tuple(hung.joints), ropes=tuple(hung.ropes), forces=tuple(hung.reevings))
            system = k.merge([system, own], gravity)
            whole = k.merge([self.lift, system], gravity)
        for rope in system.reevings if not self.source.faults else ():
            self.checked((*self.base, "ropes", rope.name), partial(self._parallel, whole), rope)
        if not self.source.faults:
            self.checked(self.base, self._resisting, whole)
        taut, closed = self._carrying(system, kinematics.poses(whole)) if not self.source.faults else ((), ())
        return plan.Mechanism(
            name=self.called,
            system=system,
            actuators=(*actuators(self), *hung.actuators),
            taut=taut,
            closed=closed,
            hooks=tuple(hung.hooks),
            shapes=(*self._shapes(booms), *(shape for _, _, shape in slices), *hung.shapes),
            ties=tuple(hung.ties),
            heavy=(*hung.heavy, *self.heavy()),
            bends=bends,
            servos=servos,
            footing=footing_of(self.source, self.base, given.stands, self.bodies, ""),
            lacks=tuple(given.model_file.lacks) if isinstance(given.model_file, mechanics.ModelFile) else (),
            where=self.source.where(self.base),
        )  # fmt: skip

    def _body(self, name: str, body: mechanics.BodyKeys) -> k.Body:
        path: Path = (*self.base, "bodies", name)
        flexible, made = body.beam or body.matrices, None
        if flexible is None and body.mass is None:
            self.fault((*path, "mass"), "the key 'mass' is missing", on_key=True)
        if body.beam and body.matrices:
            self.fault((*path, "matrices"), "a flexible body has either a 'beam' or 'matrices'", on_key=True)
        elif flexible:
            at: Path = (*path, "beam" if body.beam else "matrices")
            try:
                made = flexible.built(FilePath(self.source.mark(path).file).parent, self.source.root)
                check_flexible(name, made)
            except (KernelError, ValueError) as error:
                self.fault(at, str(error), on_key=True)
        if body.box and any(body.inertia):
            self.fault((*path, "box"), "a body has either 'inertia' or the moments of its 'box'", on_key=True)
        return k.Body(name, body.mass or 0.0, body.com, moments(body), made)

    def _shapes(self, bends: list[Bend]) -> Iterator[plan.Shape]:
        for key in ("load_cells", "shapes"):
            for name in getattr(self.given, key):
                self.known((*self.base, written(key), name), name)
        for name, body in self.given.bodies.items():
            for drawn in self.given.shapes.get(name, ()):
                thing = f"{drawn.thing} of {self.called}" if drawn.thing else ""
                yield plan.Shape(body=name, centre=drawn.at, size=drawn.size, thing=thing, part=drawn.part)
            if body.box and name not in self.given.shapes:
                (x, y, z), (a, b, c) = body.com, body.box
                n = SLICES if any(bend.body == name for bend in bends) else 1
                yield plan.Shape(body=name, centre=(x + a * (0.5 / n - 0.5), y, z), size=(a / n, b, c))

    def _carrying(self, system: k.System, at: kinematics.Poses) -> tuple[tuple[str, ...], tuple[str, ...]]:
        spans = {r.name: span(self, r, at) for r in system.reevings}
        reeved = [r.name for r in system.reevings if r.hooked and spans[r.name] > r.L0 + TOUCH]
        stretched = {r.name: kinematics.length(r, at) - r.L0 for r in system.straight_ropes if r.hooked}
        for rigid in system.rigid_ropes:
            if stretched.get(rigid.name, 0.0) > TOO_SHORT:
                short = f"{stretched[rigid.name] * 1e3:.3g} mm too short for its ends at the start"
                self.fault((*self.base, "ropes", rigid.name, "length"), f"the rope is rigid and {short}")
        for rope in system.ropes:
            self._overstretched(rope, stretched.get(rope.name, 0.0))
        for reeving in (r for r in system.reevings if r.hooked):
            self._overstretched(reeving, (spans[reeving.name] or 0.0) - reeving.L0)
        taut = [r.name for r in system.ropes if stretched.get(r.name, 0.0) > TOUCH]
        taut += [r.name for r in system.rigid_ropes if stretched.get(r.name, -1.0) > -TOUCH]
        closed = (s.name for s in system.supports if kinematics.place(s.point, at)[2] < s.height - TOUCH)
        touching = (c.name for c in system.contacts if contacts.touches(c, at, TOUCH))
        return (*taut, *reeved), (*closed, *touching)

    def _parallel(self, whole: k.System, rope: forces.Reeving) -> None:
        """Check that edges of different bodies stay parallel if the same rope bends over them."""
        if rope.apart:
            at = kinematics.poses(whole)
            check_parallel(rope, build_graph(whole), lambda body: (at[body][1], at[body][0]))

    def _overstretched(self, rope: k.Rope | forces.Reeving, stretch: float) -> None:
        """Add an error if a wire rope starts beyond its breaking strain; softer ropes may be of any material and are
        not checked."""
        if rope.EA >= WIRE and stretch > BREAKS * rope.L0:
            message = (
                f"the rope begins stretched by {stretch / rope.L0:.1%} with {rope.EA * stretch / rope.L0 / 1e3:.4g} kN"
            )
            message += (
                f", where wire ropes break at {BREAKS:.0%}: its ends are {rope.L0 + stretch:.6g} m apart at the start"
            )
            self.fault((*self.base, "ropes", rope.name, "length"), message)

    def _bodies(self) -> Iterator[k.Body]:
        """Yield the kernel's bodies, after a check of their inertias."""
        for name, body in self.given.bodies.items():
            made = self._body(name, body)
            self.checked((*self.base, "bodies", name, "inertia"), check_inertia, made)
            yield made

    def _joints(self) -> Iterator[k.Joint]:
        """Yield the kernel's joints, with the axes that their types define."""
        for name, joint in self.given.joints.items():
            path: Path = (*self.base, "joints", name)
            faults = len(self.source.faults)
            for key in joint.directions:
                axis = getattr(joint, key.replace(" ", "_"))
                if axis is not None and not any(axis):
                    self.fault((*path, key), "an axis needs a direction, such as [0, 0, 1]")
            if isinstance(joint, joints.Spherical | joints.Free) and not any(joint.attitude):
                self.fault(
                    (*path, "attitude"), "the quaternion [x, y, z, w] must not be zero; [0, 0, 0, 1] means no rotation"
                )
            made = joint.built(name)
            if len(self.source.faults) == faults:
                self.checked(path, check_joint, made)
            yield made

    def _resisting(self, system: k.System) -> None:
        """Add an error if a body can move in a direction in which neither it nor a body that it carries has mass or
        inertia."""
        if all(b.flexible or (b.mass and all(row[i] for i, row in enumerate(b.inertia))) for b in system.bodies):
            return
        from heavylift.kernel.model.program import Program  # slow to import, and rarely needed
        from heavylift.kernel.simulation.safeguards.failures import check_resistance

        try:
            program = Program(system)
            check_resistance(program, program.initial_state())
        except KernelError as error:
            body = next((b.name for b in system.bodies if f"body '{b.name}'" in str(error)), "")
            self.fault((*self.base, "bodies", body) if body else self.base, str(error), on_key=True)

    def _forces(self) -> Iterator[forces.Force]:
        """Yield the forces; add errors for unknown bodies or joints and for forces that the kernel cannot build."""
        for name, force in self.given.forces.items():
            path: Path = (*self.base, "forces", name)
            for keys, body in force.bodies:
                self.known((*path, *keys), body)
            joint = getattr(force, "joint", "")
            along = self.along(path, joint, getattr(force, "coordinate", "")) if joint else None
            if along and isinstance(force, CharacteristicKeys):
                check_curve(self, path, force, along[1])
            made = force.built(name, folder=FilePath(self.source.mark(path).file).parent)
            self.checked(path, check_force, made)
            yield made

    def _contacts(self) -> Iterator[Contact]:
        """Yield the contacts; add errors for unknown bodies and shapes."""
        for name, given in self.given.contacts.items():
            path: Path = (*self.base, "contacts", name)
            self.known((*path, "body"), given.body)
            self.known((*path, "against", "body"), given.against.body)
            made = contacts.built(name, given)
            self.checked(path, check_contact, made)
            yield made
