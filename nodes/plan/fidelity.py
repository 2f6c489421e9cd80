"""Model level (fidelity) of the machines, and the results and accuracy that a scene asks for, with the measured answer.

A fidelity is given in a scene under `fidelity:`, or chosen to answer what the scene asks for. The models apply it when
they declare their mechanics, so omitted parts never reach the kernel.

Quantities that a scene can ask for, and the reference of the relative error of each:

rope tension    largest tension of every rope that hangs from a machine      itself
sling tension   the same of every sling                                      itself
swing           amplitude and period in each stage that only waits           itself, or a tenth of the largest
                                                                             amplitude, or 0.01 rad of hook ropes
position        of lifted bodies, else of every joint, as stages end         the longest distance between two of them
lift-off time   how long each stage takes that lifts something off           itself, or half a second if that is more
stage ends      how long each stage takes                                    the same
support load    largest force of every support                               itself
clearance       the smallest distance of the run                             itself, or 0.1 m if that is more
limits          the highest utilisation of every limit, also of user signals the limit

Planar motion locks the joints that would leave the plane: those that slide along its normal, and those that turn about
any other axis than its normal.

The directions of axes are those at the start, including the rotations of the joints that carry them.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, Decimal
from math import inf
from typing import Annotated, Literal, get_args

import msgspec
from heavylift.kernel.algebra.dense import product
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.mechanics import IDENTITY, WORLD, Joint, Matrix, Vector

from .actions import Item
from .mechanism import Mechanism

ACROSS, ALONG = "across", "along"
NORMAL: dict[str, Vector] = {ACROSS: (1.0, 0.0, 0.0), ALONG: (0.0, 1.0, 0.0)}  # motion -> the normal of its plane
GROUPS = ("hinges", "gantries", "trolleys")  # what turns about y, slides along x, slides along y
Asked = Literal[
    "rope tension", "sling tension", "swing", "position", "lift-off time", "stage ends", "support load", "clearance",
    "limits",
]  # fmt: skip
ASKABLE: tuple[Asked, ...] = get_args(Asked)
MEANT: tuple[Asked, ...] = (
    "rope tension",
    "sling tension",
    "swing",
    "position",
    "stage ends",
)  # where nothing is asked
USUAL = 1e-2  # accuracy of what is asked without one
OF_TENSIONS = 1e-4  # of the rope tensions, where a scene asks nothing
ASKEW = 1e-9  # of an axis' part that is beside its direction
SHORTEST = 0.5  # [s] so long counts a stage in which the block comes off sooner, or at once


class Fidelity(Item, frozen=True, kw_only=True):
    """Model level of the machines, such as rigid, elastic or massive ropes.

    Each field is a key of `fidelity:` in a scene, and is applied by one pass over a machine."""

    ropes: Literal["rigid", "elastic", "massive"] = "elastic"  # massive: chains of lumps
    lumps: Annotated[int, msgspec.Meta(ge=1, le=64)] = 4  # of a massive rope
    rope_mass: Literal["none", "lumped"] = "none"  # of rigid and elastic ropes; lumped: onto trolley and hook
    slings: Literal["rigid", "elastic"] = "elastic"
    girder: Literal["rigid", "elastic"] = "rigid"  # elastic: girders and booms bend
    motion: Literal["spatial", "across", "along"] = "spatial"  # planar across the rails (y, z) or along them (x, z)
    pads: Literal["all", "standing"] = "all"  # of the block; standing: only those of the face that it stands on
    locked: tuple[str, ...] = ()  # joints that are fixed where they start, or all `hinges`, `gantries`, `trolleys`
    # of vessels in waves: they follow their own response, or radiate waves at one frequency, or with memory
    water: Literal["memory", "one frequency", "motion given"] = "memory"
    islands: Literal["apart", "together"] = "apart"  # machines that nothing connects: solved apart or as one system


def group_of(joint: Joint) -> str:
    """Return the group to which a joint belongs (hinges, gantries or trolleys), or "" if it belongs to none."""
    if joint.kind == "revolute":
        return "hinges" if joint.axis == (0.0, 1.0, 0.0) else ""
    along = {(1.0, 0.0, 0.0): "gantries", (0.0, 1.0, 0.0): "trolleys"}
    return along.get(joint.axis, "") if joint.kind == "prismatic" else ""


def leaves(joint: Joint, axis: Vector, motion: str) -> bool:
    """Return whether a joint with this axis in the world frame moves its child body out of the plane of motion."""
    along = abs(sum(a * n for a, n in zip(axis, NORMAL[motion], strict=True))) if motion in NORMAL else 1.0
    if motion not in NORMAL or joint.kind not in ("prismatic", "revolute"):
        return False
    return along > ASKEW if joint.kind == "prismatic" else along < 1.0 - ASKEW


def held_by(fidelity: Fidelity, joint: Joint) -> str:
    """Return the reason why a locked joint cannot move, with the key of `fidelity:` that unlocks it."""
    group, name = group_of(joint), joint.name
    if leaves(joint, joint.axis, fidelity.motion):
        held = f"'motion: {fidelity.motion}' of 'fidelity'; write 'motion: spatial' there"
        return f"{name} cannot move: it is held by {held}"
    without = f" and without '{group}'" if group else ""
    return f"{name} cannot move: it is held by 'locked' of 'fidelity'; write there a list without it{without}"


@dataclass(frozen=True)
class Question:
    """The quantities that a scene asks for, with the largest accepted relative error of each (0.01 is 1 %)."""

    ask: tuple[Asked, ...]
    accuracy: float


class Answer(msgspec.Struct, frozen=True, kw_only=True):
    """Model level, method and tolerance chosen for the requested quantities and accuracy, with the measured errors.

    `samples_hz`: samples per second that the results need (0: as in the plan); `errors`: the largest relative error for
    each quantity; `worst`: the result that has it; `figures`: errors of all results, including utilisations;
    `left_out`: what is not modelled; `notes`: reasons why an error exceeds the accepted one or was not measured.
    """

    fidelity: Fidelity
    method: str
    tolerance: float
    samples_hz: float = 0.0
    errors: dict[str, float] = {}
    worst: dict[str, str] = {}
    figures: dict[str, float] = {}
    left_out: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def __str__(self) -> str:
        message = ", ".join(f"{quantity} within {percent(e)}" for quantity, e in self.errors.items())
        out = ", ".join(self.left_out) or "nothing"
        return "; ".join([message + " (measured)" if message else "no error measured", f"left out: {out}", *self.notes])


def percent(error: float) -> str:
    """Return a relative error as text in per cent, rounded up to two digits."""
    if not 0.0 < error < inf:
        return "0 %" if error == 0.0 else "nothing known"
    part = Decimal(f"{100.0 * error:.12g}")
    unit = Decimal(1).scaleb(part.adjusted() - 1)
    up = (part / unit).to_integral_value(ROUND_CEILING) * unit
    return f"{float(up):.10g} %"


def planar(fidelity: Fidelity, machines: Sequence[Mechanism]) -> Fidelity:
    """Return the model level with every joint locked that would move bodies out of the plane of motion."""
    joints = [joint for machine in machines for joint in machine.system.joints]
    locked = {*fidelity.locked}
    if fidelity.motion in NORMAL:
        locked |= {joint.name for joint, axis in _axes(joints) if leaves(joint, axis, fidelity.motion)}
    order = dict.fromkeys((*(x for group in groups_of(machines).values() for x in group), *(j.name for j in joints)))
    return msgspec.structs.replace(fidelity, locked=tuple(joint for joint in order if joint in locked))


def groups_of(machines: Sequence[Mechanism]) -> dict[str, list[str]]:
    """Return the names of the joints that can be locked, by the name of their group."""
    joints = [joint for machine in machines for joint in machine.system.joints]
    return {group: [joint.name for joint in joints if group_of(joint) == group] for group in GROUPS}


def turn(axis: Vector, angle: float) -> Matrix:
    """Return the rotation (3, 3) about a unit axis by an angle [rad]."""
    (x, y, z), c, s = axis, cos(angle), sin(angle)
    t = 1.0 - c
    return (
        (t * x * x + c, t * x * y - s * z, t * x * z + s * y),
        (t * x * y + s * z, t * y * y + c, t * y * z - s * x),
        (t * x * z - s * y, t * y * z + s * x, t * z * z + c),
    )


def times(A: Matrix, B: Matrix) -> Matrix:
    """Return the product (3, 3) of two rotation matrices."""
    columns = [product(A, column) for column in zip(*B, strict=True)]
    a, b, c = ((x, y, z) for x, y, z in zip(*columns, strict=True))
    return a, b, c


def attitude(q: Sequence[float]) -> Matrix:
    """Return the rotation matrix (3, 3) of a quaternion (x, y, z, w)."""
    x, y, z, w = q
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)),
        (2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)),
        (2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)),
    )


def _axes(joints: Sequence[Joint]) -> Iterator[tuple[Joint, Vector]]:
    """Yield each revolute or prismatic joint with the direction of its axis in the world frame at the start."""
    known: dict[str, Matrix] = {WORLD: IDENTITY}
    waiting = list(joints)
    while ready := [joint for joint in waiting if joint.parent in known]:
        for joint in ready:
            frame = times(known[joint.parent], joint.R_PJ)
            x, y, z = product(frame, joint.axis)
            yield joint, (x, y, z)
            own = times(frame, _turned(joint))
            back: Matrix = tuple(zip(*joint.R_CJ, strict=True))  # type: ignore[assignment]
            known.setdefault(joint.child, times(own, back))
        waiting = [joint for joint in waiting if joint not in ready]


def _turned(joint: Joint) -> Matrix:
    if joint.kind == "revolute" and joint.q0:
        return turn(joint.axis, joint.q0[0])
    return attitude(joint.q0[3:]) if joint.kind == "free" and joint.q0 else IDENTITY
