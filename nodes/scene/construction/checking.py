"""Checks of the references between the parts of a mechanism: bodies, joints, stations on beams, coordinates.

Faults are collected with their place in the file, never raised, so that all of them are reported at once.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from heavylift.kernel.description import mechanics as k
from heavylift.kernel.errors import KernelError
from heavylift.nodes.scene.keys import mechanics
from heavylift.nodes.scene.keys.flexible import Beam
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path, Source

__all__ = ["Checking"]

Made = TypeVar("Made")


class Checking:
    """A mechanism as it is written, with the source that its faults are added to."""

    def __init__(self, source: Source, given: mechanics.Mechanism) -> None:
        self.source, self.given, self.fault = source, given, source.fault
        self.bodies = [k.WORLD, *given.bodies]

    def checked(self, path: Path, check: Callable[[Made], object], made: Made) -> None:
        """What the kernel would refuse is a fault of the scene."""
        try:
            check(made)
        except KernelError as error:
            self.fault(path, str(error), on_key=True)

    def known(self, path: Path, body: str) -> None:
        """The world or a body has this name."""
        if body not in self.bodies:
            self.fault(path, f"there is no body '{body}'", closest(body, self.bodies))

    def beam(self, body: str) -> Beam | None:
        """The beam that a body is, if it is one."""
        return self.given.bodies[body].beam if body in self.given.bodies else None

    def on_beam(self, path: Path, body: str, x: float) -> None:
        """What stands on a beam stands between its ends."""
        beam = self.beam(body)
        if beam and not 0.0 <= x <= beam.length:
            self.fault(path, f"{x:g} m is not on the beam of '{body}', which reaches from 0 to {beam.length:g} m")

    def along(self, path: Path, name: str, coordinate: str) -> tuple[str, bool] | None:
        """The coordinate that a law acts along, and whether it is an angle."""
        joint = self.given.joints.get(name)
        if joint is None:
            self.fault((*path, "joint"), f"there is no joint '{name}'", closest(name, self.given.joints))
        elif not joint.coordinates:
            self.fault((*path, "joint"), f"a {joint.type} joint has no single coordinate to act on: '{name}'")
        elif not coordinate and len(joint.coordinates) > 1:
            words = " or ".join(f"'coordinate: {c}'" for c in joint.coordinates)
            self.fault((*path, "joint"), f"the {joint.type} joint '{name}' has several coordinates: add {words}")
        elif coordinate and coordinate not in joint.coordinates:
            message = f"a {joint.type} joint has no coordinate '{coordinate}'"
            self.fault((*path, "coordinate"), message, closest(coordinate, joint.coordinates))
        else:
            along = coordinate or joint.coordinates[0]
            return along, joint.turns(along)
        return None
