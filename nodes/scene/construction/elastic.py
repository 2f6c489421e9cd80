"""Parts of a mechanism that bend, yield or have a mass at some model levels, from the section `elastic`."""

from collections.abc import Iterator

from heavylift.kernel.algebra.dense import norm, product
from heavylift.kernel.description import mechanics as k
from heavylift.kernel.description.flexible import Beam, Flexible
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.mechanism import Bend, Heavy, Servo
from heavylift.nodes.scene.keys.parts import mechanics
from heavylift.nodes.scene.keys.parts.flexible import Elastic, GirderKeys, RopeMass, ServoKeys
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path

from .checking import Checking
from .laws import check_dimensions

SLICES = 6  # as which a body that bends is drawn and collides
LEVEL = 1e-9  # of an axis that is level or vertical
OFF = 1e-6  # [m] from the middle of a body, by rounding


class ElasticParts(Checking):
    """Resolves the entries under `elastic` of a mechanism, and adds errors for parts that cannot be elastic."""

    def servos(self, made: tuple[k.Joint, ...]) -> Iterator[Servo]:
        """Yield the drives under `elastic` that can be compliant; add an error for a drive that gravity would move."""
        joints = {joint.name: joint for joint in made}
        for name, x in self.given.elastic.items():
            if not isinstance(x, ServoKeys):
                continue
            path, drive = (*self.base, "elastic", name), self.given.drives.get(name)
            if drive is None or drive.type != "prescribed":
                self.fault(path, f"there is no prescribed drive '{name}', body or rope", on_key=True)
                continue
            joint, along = joints.get(drive.joint), self.along(path, drive.joint, drive.coordinate)
            if along:
                check_dimensions(self, path, x, turns=along[1])
            if joint and not self.source.faults:
                x_, y, z = product(self.start()[joint.parent][1].tolist(), product(joint.R_PJ, joint.axis))
                if max((abs(z),) if joint.kind == "prismatic" else (abs(x_), abs(y))) > LEVEL:
                    message = "weight acts on this drive, which would begin to move: only one that slides level, or "
                    words = f"{message}turns about a vertical axis, is prescribed and has a stiffness"
                    self.fault((*path, "stiffness"), words, on_key=True)
            yield Servo(drive=name, stiffness=x.stiffness, damping=x.damping)

    def heavy(self) -> Iterator[Heavy]:
        """Yield the ropes under `elastic` that can have mass."""
        for name, x in self.given.elastic.items():
            rope = self.given.ropes.get(name)
            if isinstance(x, RopeMass) and rope is None:
                self.fault((*self.base, "elastic", name), f"there is no rope '{name}'", on_key=True)
            elif isinstance(x, RopeMass) and rope and (start := rope.lines[0].start if rope.lines else rope.start):
                other = ((0.0, 0.0, 0.0),) * max(1, len(rope.lines) or len(rope.over) + 1)
                yield Heavy(rope=name, line=x.mass_per_length, on=start.body, beside=other)

    def bends(self, bodies: tuple[k.Body, ...]) -> Iterator[Bend]:
        """Yield the bodies under `elastic` that can bend, with the mass that takes part in the bending."""
        known = {body.name: body for body in bodies}
        for name, x in self.given.elastic.items():
            path, body = (*self.base, "elastic", name), known.get(name)
            if not isinstance(x, GirderKeys | Elastic):
                continue
            if body is None or body.flexible:
                self.fault(path, f"there is no rigid body '{name}'", on_key=True)
            elif isinstance(x, GirderKeys):
                for i, slide in enumerate(x.slides):
                    if slide not in self.joints:
                        self.fault((*path, "slides", i), f"there is no joint '{slide}'", closest(slide, self.joints))
                beam = Beam(x.span, x.mass / x.span, EI_y=x.stiffness * x.span * x.span * x.span / 48.0)
                flexible = Flexible(1, beam, frame="simply supported", damping=x.damping)
                yield Bend(
                    body=name, mass=x.mass, flexible=flexible, slides=tuple(x.slides), stiffness=x.stiffness,
                    height=x.height,
                )  # fmt: skip
            else:
                yield from self._boom(path, name, body, x)

    def _boom(self, path: Path, name: str, body: k.Body, x: Elastic) -> Iterator[Bend]:
        """Yield a body that bends as a beam, starting at the origin of its frame."""
        box = self.given.bodies[name].box
        length, mass = x.length or (box[0] if box else 0.0), x.mass or body.mass
        middle = (length / 2.0, 0.0, 0.0)
        if not length or not 0.0 < mass <= body.mass * (1.0 + mechanics.ROUNDING):
            self.fault(path, "a body that bends needs a length or a 'box', and at most its own mass as bending 'mass'")
        elif mass >= body.mass and norm([a - b for a, b in zip(body.com, middle, strict=True)]) > OFF:
            self.fault(
                path, "if all mass of a body bends, its 'com' must be at the middle of its length; let less 'mass' bend"
            )
        else:
            beam = Beam(length, mass / length, x.EI, x.EI, polar=mass / body.mass * body.inertia[0][0] / length)
            flexible = Flexible(x.modes, beam, frame=x.frame, damping=x.damping)
            yield Bend(body=name, mass=min(mass, body.mass), flexible=flexible)

    def slices(self, bends: list[Bend]) -> Iterator[tuple[k.Body, k.Joint, plan.Shape]]:
        """Yield massless bodies fixed along a bending body, each with a slice of that body's box as its shape.

        The first slice stays on the body."""
        for bend in bends:
            given, beam = self.given.bodies[bend.body], bend.flexible.beam
            if given.box is None or bend.body in self.given.shapes or beam is None:
                continue
            (x, y, z), (a, b, c) = given.com, given.box
            for i in range(1, SLICES):
                middle, name = x + a * ((i + 0.5) / SLICES - 0.5), f"{bend.body}~{i + 1}"
                at = min(max(middle, beam.start), beam.start + beam.length)
                joint = k.Joint(f"{name}.on", "fixed", bend.body, name, p_PJ=(at, 0.0, 0.0))
                shape = plan.Shape(body=name, centre=(middle - at, y, z), size=(a / SLICES, b, c), thing=bend.body)
                yield k.Body(name, 0.0), joint, shape
