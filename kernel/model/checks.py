"""Checks of a description before it is compiled: unique names, valid numbers.

Each violation is one KernelError that names the item, the field and the requirement.
"""

from collections.abc import Iterator
from dataclasses import fields
from itertools import chain
from math import degrees, isfinite, sqrt
from typing import Any
from weakref import WeakValueDictionary

import msgspec
import numpy as np
from heavylift.kernel.algebra.dense import dot, eigenvalues, norm
from heavylift.kernel.algebra.elementary import atan2
from heavylift.kernel.constraints.contact.pairs import check_contact
from heavylift.kernel.description.contacts import Contact
from heavylift.kernel.description.field_types import check_names, choice, field_names, item_word, plain
from heavylift.kernel.description.flexible import check_flexible
from heavylift.kernel.description.forces import wrong_wave
from heavylift.kernel.description.mechanics import JOINTS, WORLD, Body, Drive, Joint, RigidRope, Rope, Stop, System
from heavylift.kernel.description.units import wrong_sign
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.table import FORCES, check_force

PLACES = ("lines", "point", "p_PJ", "p_CJ", "com")
FARTHEST = 1e30  # [m] the squares of distances must stay finite
LARGEST = 1e100  # of any number: products of three must stay finite
FINEST = 1e-14  # of a step: below is rounding, and steps shrink without end
SHORTEST_SAMPLE = 100_000  # [ns]
MOST_SAMPLES = 1_000_000  # within one step: their rows must find room
SHARED = 1e-9  # by which shares may miss their sum
PRINTED = 3e-3  # by which moments of a thin body may exceed their sum: three printed digits each
UNIT = 1e-6  # how far an axis or a rotation may be off by rounding
# groups within which a command or an event is addressed by name alone
ADDRESSED = (
    ("drives", "ropes", "rigid_ropes", "masters", "measured", "forces"),
    ("ropes", "rigid_ropes", "supports", "stops", "brakes", "locks", "forces", "contacts", "thresholds"),
)
AXES = (0, 1)  # about which an attitude is measured
_checked: WeakValueDictionary[int, System] = WeakValueDictionary()  # by id: descriptions that are what they must be
_last: list[tuple[bytes, System, System]] = []  # the last one, encoded, as it was given and as it was checked
_items: dict[tuple[type, bytes], Any] = {}  # that were checked, by their numbers, the oldest first
MOST_KEPT = 4096


def check_description(system: System) -> System:
    """Return the description in tuples and floats (see `field_types`); raises KernelError for an invalid item."""
    if _checked.get(id(system)) is system:
        return system
    code, given, last = _encoded(system), system, _last[:]  # which other threads may replace
    if code and [(x, y) for x, y, _ in last] == [(code, system)]:  # equal to the bit, of the same classes
        return last[0][2]
    before = set[int]()  # ids of items that were checked before

    def known(x: object) -> object | None:
        if (found := _known(x)) is not None:
            before.add(id(found))
        return found

    system = plain(system, known)
    if not (isfinite(system.gravity) and abs(system.gravity) <= LARGEST):
        raise KernelError(f"gravity is {system.gravity}; it must be a finite number")
    for group in [(f.name,) for f in fields(system) if f.name not in ("bodies", "joints", "gravity")] + [*ADDRESSED]:
        seen: set[str] = set()
        for x in (x for name in group for x in getattr(system, name)):
            if x.name in seen:
                raise KernelError(
                    f"'{x.name}': this name is used twice; names of force laws, drives and masters must be unique"
                )
            seen.add(x.name)
    items = [x for f in fields(system) if f.name != "gravity" for x in getattr(system, f.name)]
    new = [x for x in items if id(x) not in before]
    for x in new:
        _check_item(x)
    check_names(system)
    for x in new:
        _check_kind(x)
    _check_shared_water(system)
    for x in new if len(items) < MOST_KEPT else ():
        if encoded := _encoded(x):
            _items[type(x), encoded] = x
    for old in list(_items)[: max(0, len(_items) - MOST_KEPT)]:
        _items.pop(old, None)
    _checked[id(system)] = system
    _last[:] = [(code, given, system)] if code else []
    return system


def _check_shared_water(system: System) -> None:
    """Raise KernelError unless the added mass of each pair of bodies resists every motion."""
    given = {b.name: b for b in system.bodies}
    for b in system.bodies:
        if b.shared and (other := given.get(b.shared.beside)):
            if not b.added or not other.added:
                raise KernelError(f"body '{b.name}': it shares water with '{other.name}'; give both bodies added mass")
            C, own = np.array(b.shared.added), [np.array(x.added) for x in (other, b)]
            A = np.block([[own[0], C.T], [C, own[1]]])
            size = np.sqrt(np.maximum(A.diagonal(), np.finfo(float).tiny))
            if (least := float(np.linalg.eigvalsh(A / np.outer(size, size)).min())) < -UNIT:
                message = f"its added mass with '{other.name}' beside it would drive some motion"
                raise KernelError(
                    f"body '{b.name}': {message}; the eigenvalue {least:g} of the scaled matrix must not be negative"
                )


def _known(x: object) -> object | None:
    """Return the bitwise equal item checked before, else None; variants of a scene share nearly all items."""
    found = _items.get((type(x), code)) if (code := _encoded(x)) else None
    return found if found == x else None


def _check_kind(x: Any) -> None:
    """Check the additional requirements of an item by its kind."""
    if type(x) in FORCES:
        check_force(x)
    match x:
        case Contact():
            check_contact(x)
        case Body():
            if x.name == WORLD:
                raise KernelError(f"body '{WORLD}': this name is reserved for the ground; choose another one")
            check_inertia(x)
            if x.added and any(
                abs(a - b) > UNIT * abs(a)
                for a, b in zip(chain(*x.added), chain(*zip(*x.added, strict=True)), strict=True)
            ):
                raise KernelError(f"body '{x.name}': its added mass must be a symmetric matrix")
            if x.flexible:
                check_flexible(x.name, x.flexible)
        case Joint():
            check_joint(x)
        case Rope() | RigidRope():
            if not x.lines:
                raise KernelError(f"rope '{x.name}': it has no straight part (line); give it at least one")
            for i, line in enumerate(x.lines, 1):
                if line.a == line.b:
                    raise KernelError(
                        f"rope '{x.name}': line {i} begins and ends at the same point, so its length is zero"
                    )
            if x.mass and abs(sum(line.share for line in x.lines) - 1.0) > SHARED:
                message = "it has a mass, which its lines share; let their shares add up to 1"
                raise KernelError(f"rope '{x.name}': {message}")
        case Drive():
            if (x.wave or x.waves) and x.kind != "prescribed":
                raise KernelError(f"drive '{x.name}': only prescribed drives can follow a wave")
            if fault := wrong_wave(x.wave, x.waves):
                raise KernelError(f"drive '{x.name}': it {fault}")
        case Stop():
            if x.lower > x.upper:
                raise KernelError(f"stop '{x.name}': its lower limit {x.lower:g} is above the upper one, {x.upper:g}")


def _encoded(system: object) -> bytes:
    """Return the exact bytes of all numbers of a description; empty if it contains other data."""
    try:
        return msgspec.msgpack.encode(system)
    except (TypeError, ValueError, OverflowError, RecursionError):
        return b""


def accepted(part: System) -> System:
    """Mark a system as checked, so that it is not checked again, and return it."""
    _checked[id(part)] = part
    return part


def _check_item(x: Any) -> None:
    """Check that all numbers of an item are finite and have the required sign."""
    kind, where = type(x).__name__, f"{item_word(x)} '{x.name}'"
    for field, value in _numbers(x):
        if not isfinite(value):
            raise KernelError(f"{where}: {field} is {value}; it must be a finite number")
        if abs(value) > LARGEST:
            raise KernelError(f"{where}: {field} is {value:g}; it must lie within {LARGEST:g}")
        if field in PLACES and abs(value) > FARTHEST:
            raise KernelError(f"{where}: {field} is {value:g} m; it must lie within {FARTHEST:g} m")
    if kind in ("Measured", "Threshold") and x.axis not in AXES:
        raise KernelError(f"{where}: axis is '{x.axis}'; it must be {choice(AXES)}")
    field, message = wrong_sign(x)
    if field:
        raise KernelError(f"{where}: {field} {message}")


def _numbers(x: Any, field: str = "") -> Iterator[tuple[str, float]]:
    """Yield all numbers of a description with their fields."""
    if type(x) is float:  # as most are
        yield field, x
    elif isinstance(x, tuple):
        for e in x:
            yield from _numbers(e, field)
    elif isinstance(x, float | int):
        yield field, x
    else:
        for name in field_names(x.__class__):
            yield from _numbers(getattr(x, name), field or name)


def check_inertia(b: Body) -> None:
    """Check that an inertia matrix is symmetric and that a mass distribution with its principal moments can exist.

    The second is not required of a body without mass, such as a geared rotor.
    """
    I = b.inertia
    for i, j in ((0, 1), (0, 2), (1, 2)):
        if abs(I[i][j] - I[j][i]) > UNIT * max(abs(I[i][j]), abs(I[j][i])):
            xy, yx = f"I{'xyz'[i]}{'xyz'[j]}", f"I{'xyz'[j]}{'xyz'[i]}"
            raise KernelError(
                f"body '{b.name}': its inertia must be a symmetric matrix, but {xy} is {I[i][j]:g} and {yx} is "
                f"{I[j][i]:g} kg m2; give both the same value"
            )
    for i, axis in enumerate("xyz"):
        if I[i][i] < 0.0:
            raise KernelError(
                f"body '{b.name}': its moment of inertia I{axis}{axis} is {I[i][i]:g} kg m2; none can be negative"
            )
    moments = eigenvalues(I)
    found = f"body '{b.name}': its principal moments of inertia are {', '.join(f'{x:g}' for x in moments)} kg m2"
    if moments[0] < -UNIT * moments[2]:
        raise KernelError(
            f"{found}, but a principal moment cannot be negative: the products "
            f"of inertia Ixy {I[0][1]:g}, Ixz {I[0][2]:g}, "
            f"Iyz {I[1][2]:g} are too large for the moments; reduce them"
        )
    if b.mass > 0.0 and moments[2] > (1.0 + PRINTED) * (moments[0] + moments[1]):
        raise KernelError(
            f"{found}; none can be larger than the sum of the other two (for a flat plate Ixx + Iyy = Izz): "
            f"{_remedy(b, moments)}"
        )


def _remedy(b: Body, moments: list[float]) -> str:
    """Describe the smallest change that makes moments of inertia possible, without products of inertia."""
    if any(b.inertia[i][j] for i, j in ((0, 1), (0, 2), (1, 2))):
        return "make the largest smaller or the others larger"
    own = [b.inertia[i][i] for i in range(3)]
    largest = own.index(max(own))
    missing = (moments[2] - moments[1] - moments[0]) / 2.0
    least = ", ".join(f"{x if i == largest else x + missing:g}" for i, x in enumerate(own))
    return f"where the other two do not matter, as in plane motion, write [{least}] kg m2"


def check_joint(j: Joint) -> None:
    if j.kind not in JOINTS:
        raise KernelError(f"joint '{j.name}': there is no joint type '{j.kind}'; joint types are {', '.join(JOINTS)}")
    joint = JOINTS[j.kind]
    for name in ("R_PJ", "R_CJ"):
        x, y, z = R = getattr(j, name)
        skewed = max(abs(dot(R[a], R[b]) - (a == b)) for a in range(3) for b in range(3))
        handed = dot(x, (y[1] * z[2] - y[2] * z[1], y[2] * z[0] - y[0] * z[2], y[0] * z[1] - y[1] * z[0]))
        if skewed > UNIT or handed < 0.0:
            raise KernelError(f"joint '{j.name}': {name} is not a rotation; its rows must be right-handed unit vectors")
    for which, axis in (("axis", j.axis), ("second axis", j.second)):
        length = norm(axis)
        if abs(length - 1.0) > UNIT:
            raise KernelError(f"joint '{j.name}': its {which} has length {length:g}; it must be a unit vector")
    aligned = dot(j.axis, j.second)
    if joint.axes > 1 and abs(aligned) > UNIT:
        angle = degrees(atan2(sqrt(max(0.0, 1.0 - aligned * aligned)), aligned))
        raise KernelError(
            f"joint '{j.name}': the angle between its axes is {angle:.4g} deg; the second "
            f"axis of a {j.kind} joint must be perpendicular to the first"
        )
    if joint.pitched and j.pitch == 0.0:
        raise KernelError(
            f"joint '{j.name}': its pitch is 0; give the pitch of a screw in m/rad, or make the joint revolute"
        )
    if not joint.pitched and j.pitch != 0.0:
        raise KernelError(f"joint '{j.name}': pitch is {j.pitch:g}; a {j.kind} joint has no pitch")
    quaternion = j.q0[-4:] if joint.quaternion is not None else ()
    if quaternion and not any(quaternion):
        raise KernelError(f"joint '{j.name}': its initial quaternion is zero; it must have length 1")


def check_options(tolerance: float, sample_ns: int, h_max: float, step: float | None, opt: int) -> None:
    """Raise KernelError for invalid options of a simulation."""
    numbers = {"tolerance": tolerance, "sample_ns": sample_ns, "h_max": h_max, "step": 1.0 if step is None else step}
    for name, x in numbers.items():
        if not isinstance(x, float | int | np.number):
            raise KernelError(f"{name} is {x!r}; it must be a number")
    if not FINEST <= tolerance < 1.0:
        raise KernelError(f"tolerance {tolerance:g}: it must lie between {FINEST:g} and 1")
    if not isinstance(sample_ns, int | np.integer) or sample_ns < SHORTEST_SAMPLE:
        raise KernelError(f"samples every {sample_ns} ns: they must be at least {SHORTEST_SAMPLE} ns apart")
    if not (isfinite(h_max) and h_max > 0.0):
        raise KernelError(f"h_max {h_max:g} s: the longest step must be positive and finite")
    longest = step or h_max
    if isfinite(longest) and longest * 1e9 > MOST_SAMPLES * sample_ns:
        raise KernelError(f"a step of {longest:g} s has more than {MOST_SAMPLES} samples; make the step shorter")
    if opt not in (0, 1, 2, 3):
        raise KernelError(f"opt {opt!r}: choose an optimisation level of the compiler, 0, 1, 2 or 3")
