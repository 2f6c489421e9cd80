"""Loads at the start, which the passes of model levels need: loads on heavy ropes and beams, stretched lengths of
slings."""

from collections.abc import Iterator, Sequence

import msgspec
import numpy as np
from heavylift.kernel.algebra.dense import norm, product
from heavylift.kernel.description.mechanics import Joint, Line, Point, Rope, System, Vector, merge
from heavylift.nodes.plan.mechanism import BeamLoad, Bend, Heavy, Mechanism, Tie
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.scene.keys.parts import kinematics
from numpy.typing import NDArray

PLUMB = 1e-6  # of a rope's length that one end may be beside the other


def weighed(built: Plan) -> Plan:
    """Return the plan with the static loads at the start, which models of heavy ropes and bending beams need.

    Slings get their stretched lengths."""
    whole = merge([machine.system for machine in built.machines], built.gravity)
    start = _Start(whole)
    found = (
        msgspec.structs.replace(
            machine,
            heavy=tuple(row if row.below else start.hanging(machine, row) for row in machine.heavy),
            bends=tuple(row if row.stiffness else start.bent(row) for row in machine.bends),
            ties=tuple(start.tied(tie) if tie.rigging else tie for tie in machine.ties),
        )
        for machine in built.machines
    )
    return msgspec.structs.replace(built, machines=tuple(found))


class _Start:
    def __init__(self, whole: System) -> None:
        self.whole, self.at, self.g = whole, kinematics.poses(whole), whole.gravity
        self.ropes = {rope.name: rope for rope in whole.ropes}
        self.carried = {joint.child: joint for joint in reversed(whole.joints)}

    def pull(self, rope: Rope) -> float:
        """Return the static tension [N] of a rope at the start."""
        return rope.EA * max(0.0, kinematics.length(rope, self.at) - rope.L0) / rope.L0 if rope.hooked else 0.0

    def tied(self, tie: Tie) -> Tie:
        """Return a sling, with its stretched length if it carries a load at the start."""
        rope = self.ropes.get(tie.rope)
        taut = rope is not None and self.pull(rope) > 0.0
        return msgspec.structs.replace(tie, spans=kinematics.length(rope, self.at)) if rope and taut else tie

    def hanging(self, machine: Mechanism, row: Heavy) -> Heavy:
        """Return a rope with mass and its end points at the start, or with the reason why it cannot have mass."""
        rope = self.ropes.get(row.rope)
        if rope is None:
            over = any(x.name == row.rope for x in machine.system.reevings)
            why = "it runs over sheaves or edges" if over else "it cannot stretch"
            return msgspec.structs.replace(row, why=why)
        falls = rope.lines[: len(row.beside)]
        a, b = ([kinematics.place(getattr(line, end), self.at) for line in falls] for end in "ab")
        top, eye = (np.array([sum(x) / len(falls) for x in zip(*places, strict=True)]) for places in (a, b))
        distance: list[float] = (top - eye).tolist()
        apart = max(norm((p - top - q + eye).tolist()) for p, q in zip(a, b, strict=True))
        length, T = norm(distance), self.pull(rope)
        shares = abs(sum(line.share for line in falls) - 1.0)
        whys = {
            "it is slack at the start": T <= 0.0 or self.g <= 0.0,
            "it does not hang plumb from its start": max(*map(abs, distance[:2]), -distance[2]) > PLUMB * length,
            "its falls are not parallel, or do not share its length": apart > PLUMB * length or shares > PLUMB,
        }  # fmt: skip
        return msgspec.structs.replace(
            row,
            beside=tuple(_vector(q - eye) for q in b),
            ends=(_vector(top), _vector(eye)),
            lead=sum(self._length(line) for line in rope.lines[len(falls) :]),
            below=T / self.g if T > 0.0 and self.g > 0.0 else 0.0,
            why=next((why for why, holds in whys.items() if holds), ""),
        )

    def _length(self, line: Line) -> float:
        return line.share * norm((kinematics.place(line.a, self.at) - kinematics.place(line.b, self.at)).tolist())

    def bent(self, row: Bend) -> Bend:
        """Return a flexible body together with gravity and the forces on it at the start, in its own frame."""
        stations = {row.body: None} | {
            body.name: x for body in self.whole.bodies if (x := self._station(row, body.name))
        }
        gravity = self._within(row.body, [0.0, 0.0, -self.g])
        return msgspec.structs.replace(row, gravity=gravity, loads=tuple(self._loads(row, stations, gravity)))

    def _station(self, row: Bend, body: str) -> Joint | None:
        """Return the joint that attaches a body to a beam, directly or through other bodies; None if there is none."""
        joint = self.carried.get(body)
        while joint is not None and joint.parent != row.body:
            joint = self.carried.get(joint.parent)
        return joint

    def _loads(self, row: Bend, on: dict[str, Joint | None], gravity: Vector) -> Iterator[BeamLoad]:
        origin = self.at[row.body][0]
        for body in (body for body in self.whole.bodies if on.get(body.name)):
            p = self._within(row.body, (kinematics.place(Point(body.name, body.com), self.at) - origin).tolist())
            joint, (x, y, z) = on[body.name], gravity
            yield BeamLoad(x=joint.p_PJ[0] if joint else 0.0, p=p, force=(body.mass * x, body.mass * y, body.mass * z))
        for rope in self.whole.ropes:
            T = self.pull(rope)
            ends = [(line, *ends) for line in rope.lines for ends in ((line.a, line.b), (line.b, line.a))] if T else []
            for line, here, there in ends:
                if here.body in on and there.body not in on:
                    place = kinematics.place(here, self.at)
                    distance = (kinematics.place(there, self.at) - place).tolist()
                    size = T * line.share / norm(distance)
                    p, joint = self._within(row.body, (place - origin).tolist()), on[here.body]
                    force = self._within(row.body, [size * x for x in distance])
                    x = joint.p_PJ[0] if joint else here.p[0]
                    yield BeamLoad(x=x, p=p, force=force, rope=rope.name, share=line.share)

    def _within(self, body: str, way: list[float]) -> Vector:
        """Return a direction of the world frame in the frame of a body."""
        return _vector(product(self.at[body][1].T.tolist(), way))


def _vector(p: Sequence[float] | NDArray[np.float64]) -> Vector:
    x, y, z = map(float, p)
    return x, y, z
