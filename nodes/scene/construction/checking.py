"""Checks of the references between the parts of a mechanism: bodies, joints, positions along beams, coordinates.

Errors are collected with their place in the file instead of being raised, so that all of them are reported together.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, TypeVar

from heavylift.kernel.description import mechanics as k
from heavylift.kernel.description.mechanics import JOINTS
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.checks import check_inertia
from heavylift.nodes.scene.keys.parts import kinematics, mechanics
from heavylift.nodes.scene.keys.parts.flexible import BeamKeys
from heavylift.nodes.scene.keys.parts.joints import POSITIONS
from heavylift.nodes.scene.keys.parts.rigging import Edge
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path, SourceText

from .scene_builder import box

Made = TypeVar("Made")
NONE: Mapping[str, Edge] = MappingProxyType({})


class Checking:
    """A mechanism as written in the scene, with methods that check it; errors are added to the scene.

    `lift`: declarations of the scene's other machines, on whose bodies and joints the mechanism can act; `base`: path
    of the mechanism in the scene; `edges`: edges of the scene; `start`: poses of all bodies at the start, available
    once the joints are known.
    """

    def __init__(
        self,
        source: SourceText,
        given: mechanics.Parts[Any],
        lift: k.System,
        base: Path,
        edges: Mapping[str, Edge] = NONE,
    ) -> None:
        self.source, self.given, self.lift, self.fault = source, given, lift, source.fault
        self.base, self.edges = base, edges
        self.start: Callable[[], kinematics.Poses] = dict
        self.carried = [body.name for body in lift.bodies]
        self.bodies = [k.WORLD, *given.bodies, *self.carried]
        self.joints: dict[str, k.JointKind] = {name: joint.type for name, joint in given.joints.items()}
        self.joints |= {joint.name: joint.kind for joint in lift.joints}

    def checked(self, path: Path, check: Callable[[Made], object], made: Made) -> None:
        """Call `check` on the description `made`; its KernelError becomes an error of the scene at `path`."""
        try:
            check(made)
        except KernelError as error:
            self.fault(path, str(error), on_key=True)

    def known(self, path: Path, body: str) -> None:
        """Add an error unless `body` is the name of a body or the world."""
        if body not in self.bodies:
            self.fault(path, f"there is no body '{body}'", closest(body, self.bodies))

    def beam(self, body: str) -> BeamKeys | None:
        """Return the beam of a body; None if the body has no beam."""
        return self.given.bodies[body].beam if body in self.given.bodies else None

    def on_beam(self, path: Path, body: str, x: float) -> None:
        """Add an error unless position x lies between the ends of the body's beam."""
        beam = self.beam(body)
        if beam and not 0.0 <= x <= beam.length:
            self.fault(path, f"{x:g} m is not on the beam of '{body}', which reaches from 0 to {beam.length:g} m")

    def along(self, path: Path, name: str, coordinate: str) -> tuple[str, bool] | None:
        """Return the joint coordinate on which a force law acts, and whether it is an angle. If the joint or coordinate
        is unknown, add an error and return None."""
        kind = self.joints.get(name)
        if kind is None:
            self.fault((*path, "joint"), f"there is no joint '{name}'", closest(name, self.joints))
            return None
        coordinates = JOINTS[kind].actable
        if not coordinates:
            self.fault((*path, "joint"), f"a {kind} joint has no single coordinate to act on: '{name}'")
        elif not coordinate and len(coordinates) > 1:
            words = " or ".join(f"'coordinate: {c}'" for c in coordinates)
            self.fault((*path, "joint"), f"the {kind} joint '{name}' has several coordinates: add {words}")
        elif coordinate and coordinate not in coordinates:
            message = f"a {kind} joint has no coordinate '{coordinate}'"
            self.fault((*path, "coordinate"), message, closest(coordinate, coordinates))
        else:
            along = coordinate or coordinates[0]
            return along, JOINTS[kind].turns(coordinates.index(along))
        return None

    def own(self, path: Path, name: str) -> bool:
        """Return whether a joint belongs to the mechanism, as drives and locks require; if not, add an error."""
        theirs = any(joint.name == name for joint in self.lift.joints)
        if theirs:
            message = f"the joint '{name}' belongs to the lift: a spring, stop, brake or force can act on it, no other"
            self.fault((*path, "joint"), message)
        return not theirs

    def check_tree(self) -> None:
        """Add errors for joints between unknown bodies, and for bodies that are not connected to the world."""
        carried: dict[str, str] = {}
        for name, joint in self.given.joints.items():
            path: Path = (*self.base, "joints", name)
            self.known((*path, "parent"), joint.parent)
            if joint.type == "slider":
                if joint.parent in self.bodies and not self.beam(joint.parent):
                    self.fault(
                        (*path, "parent"), f"a slider moves along a flexible beam, but '{joint.parent}' has none"
                    )
                self.on_beam((*path, "start"), joint.parent, *joint.values(POSITIONS))
            else:
                self.on_beam((*path, "at"), joint.parent, joint.at[0])
            self.known((*path, "child"), joint.child)
            if joint.child in self.carried:
                message = f"the body '{joint.child}' belongs to the lift, which carries it: make it the 'parent'"
                self.fault((*path, "child"), message)
            if joint.child != k.WORLD:  # that closes a loop, as every further joint of a body does
                carried.setdefault(joint.child, name)
            free = joint.type == "free" and joint.child in self.given.bodies
            if free and not self._solid(joint.child) and self._possible(joint.child):
                message = f"the body '{joint.child}' moves freely and nothing resists its turning: give it moments"
                self.fault((*self.base, "bodies", joint.child), f"{message} with 'inertia'", on_key=True)
        connected = self._connected()
        for body in (b for b in self.given.bodies if b not in connected):
            above, seen = body, set[str]()
            while above in carried and above not in seen:
                seen.add(above)
                above = self.given.joints[carried[above]].parent
            if above == body and not seen:
                self.fault((*self.base, "bodies", body), f"no joint carries the body '{body}'", on_key=True)
            elif above in seen:
                message = f"the joints of '{body}' form a loop that is not connected to the world"
                self.fault((*self.base, "bodies", body), message, on_key=True)

    def _connected(self) -> set[str]:
        """Return the bodies that are connected to the world by joints, in either direction."""
        found, before = {k.WORLD, *self.carried}, 0
        while len(found) > before:
            before = len(found)
            for joint in self.given.joints.values():
                if {joint.parent, joint.child} & found:
                    found |= {joint.parent, joint.child}
        return found

    def _solid(self, body: str) -> bool:
        """Return whether a body has all moments of inertia, or may get them from carried bodies, a box or a beam."""
        carries = any(joint.parent == body for joint in self.given.joints.values())
        given = self.given.bodies[body]
        return carries or bool(given.beam or given.matrices or given.box) or all(given.inertia[:3])

    def _possible(self, body: str) -> bool:
        """Return whether the inertia of a body is physically possible."""
        given = self.given.bodies[body]
        try:
            check_inertia(k.Body(body, given.mass or 0.0, inertia=moments(given)))
        except KernelError:
            return False
        return True


def moments(body: mechanics.BodyKeys) -> k.Matrix:
    """Return the inertia matrix about the centre of mass, as written or computed for a uniform box."""
    i: tuple[float, ...] = box(body.mass or 0.0, body.box) if body.box else body.inertia
    xx, yy, zz, xy, xz, yz = (*i, 0.0, 0.0, 0.0)[:6]
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
