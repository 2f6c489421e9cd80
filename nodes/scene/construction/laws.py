"""Force laws along the coordinates of joints: springs, stops, brakes, locks, drives, limits and friction.

Their units are checked here, since they depend on whether the coordinate is a displacement or an angle.
"""

from collections.abc import Mapping
from math import degrees
from typing import Any

from heavylift.kernel.description import mechanics as k
from heavylift.nodes.plan import plan
from heavylift.nodes.scene.keys.base import Base
from heavylift.nodes.scene.keys.parts import mechanics
from heavylift.nodes.scene.keys.parts.forces import CharacteristicKeys
from heavylift.nodes.scene.keys.parts.joints import POSITIONS
from heavylift.nodes.scene.keys.quantities import quantity
from heavylift.nodes.scene.language.grammar import read_ramp
from heavylift.nodes.scene.text import units
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path
from heavylift.nodes.scene.text.units import Dimension

from .checking import Checking
from .scene_builder import ramp_of

TOUCH = 1e-6  # [m, rad]
EASES = 0.5  # [s] in which the tension of a tugger line reaches its highest rate
KINDS = {"springs": k.JointSpring, "stops": k.Stop, "brakes": k.Brake, "locks": k.Lock, "drives": k.Drive}


def check_laws(checks: Checking) -> None:
    """Add errors for names used twice, laws on unknown coordinates, wrong units and ranges in the wrong order."""
    _names(checks)
    driven: dict[tuple[str, str], str] = {}
    for kind, laws in checks.given.laws.items():
        for name, law in laws.items():
            path: Path = (*checks.base, kind, name)
            along = checks.along(path, law.joint, law.coordinate)
            if along:
                check_dimensions(checks, path, law, turns=along[1])
            if kind == "drives" and along and checks.own(path, law.joint):
                if other := driven.get((law.joint, along[0])):
                    message = f"the joint '{law.joint}' has two drives, '{other}' and '{name}'"
                    checks.fault((*path, "joint"), f"{message}: keep one")
                driven.setdefault((law.joint, along[0]), name)
            if kind in {"stops", "drives"} and law.range and law.range[0] >= law.range[1]:
                checks.fault((*path, "range"), "the first number must be less than the second one")
    for name, joint in checks.given.joints.items():
        own: dict[str, Mapping[str, Base]] = {"limits": joint.limits, "friction": joint.friction}
        for key, given in own.items():
            for coordinate, law in given.items():
                path = (*checks.base, "joints", name, key, coordinate)
                if coordinate in joint.coordinates:
                    check_dimensions(checks, path, law, turns=joint.turns(coordinate))
                else:
                    message = f"a {joint.type} joint has no coordinate '{coordinate}' to act on"
                    checks.fault(path, message, closest(coordinate, joint.coordinates), on_key=True)
        for coordinate, x in joint.limits.items():
            if x.range[0] >= x.range[1]:
                path = (*checks.base, "joints", name, "limits", coordinate, "range")
                checks.fault(path, "the first number must be less than the second one")
    for name, lock in checks.given.locks.items():
        path = (*checks.base, "locks", name)
        if checks.own(path, lock.joint) and lock.joint not in checks.given.joints:
            checks.fault(
                (*path, "joint"), f"there is no joint '{lock.joint}'", closest(lock.joint, checks.given.joints)
            )


def check_dimensions(checks: Checking, path: Path, law: Base, *, turns: bool) -> None:
    """Add errors if the units of a law do not fit its joint coordinate. `turns`: the coordinate is an angle."""
    for name, field in type(law).model_fields.items():
        found = quantity((*field.metadata, field.annotation))
        if found and isinstance(either := found.dimension, units.Either):
            _fits(checks, (*path, field.alias or name), either.turning if turns else either.sliding)


def _fits(checks: Checking, path: Path, dimension: Dimension) -> None:
    """Add an error if the value at a path, or a value in the list there, does not have this dimension."""
    value = checks.source.at(path)
    if isinstance(value, list):
        for i in range(len(value)):
            _fits(checks, (*path, i), dimension)
    elif value is not None:
        try:
            read_ramp(value, dimension)
        except ValueError as error:
            checks.fault(path, str(error))


def check_curve(checks: Checking, path: Path, force: CharacteristicKeys, turns: bool) -> None:
    """Add errors if the units of a characteristic curve do not fit its joint coordinate.

    `turns`: the coordinate is an angle."""
    place = (units.LENGTH, units.ANGLE) if force.over == "position" else (units.SPEED, units.RATE)
    for i in range(len(force.curve)):
        for j, dimensions in enumerate((place, (units.FORCE, units.MOMENT))):
            _fits(checks, (*path, "curve", i, j), dimensions[turns])


def _names(checks: Checking) -> None:
    """Add an error for each name that is used twice: among joints, ropes, supports, laws and contacts, or also by a
    machine of the scene."""
    taken = {body.partition(".")[0]: "machines" for body in checks.carried}
    for name in (name for name in checks.given.bodies if name in taken):
        message = f"the name '{name}' is given twice: one of the machines has it, too"
        checks.fault((*checks.base, "bodies", name), message, on_key=True)
    kinds = ("joints", "ropes", "supports", "springs", "stops", "brakes", "locks", "drives", "forces", "contacts")
    for kind in kinds:
        for name in getattr(checks.given, kind):
            if name in taken:
                message = f"the name '{name}' is given twice: one of the {taken[name]} has it, too"
                checks.fault((*checks.base, kind, name), message, on_key=True)
            taken.setdefault(name, kind)


def laws_of(given: mechanics.Parts[Any]) -> dict[str, tuple[Any, ...]]:
    """Return the force laws of a mechanism for the kernel, by the field of `System` that stores them."""
    own = [law for name, joint in given.joints.items() for law in joint.laws(name)]
    return {
        key: (*(x.built(name) for name, x in getattr(given, key).items()), *(x for x in own if isinstance(x, kind)))
        for key, kind in KINDS.items()
    }


def _place(checks: Checking, drive: mechanics.DriveKeys, x: float | None) -> str:
    """Return a position of a drive as text: in degrees if its joint is revolute, else in metres without the unit."""
    turns = getattr(checks.given.joints.get(drive.joint), "type", "") == "revolute"
    return f"{degrees(x or 0.0):.4g} deg" if turns else f"{x or 0.0:g}"


def actuators(checks: Checking) -> list[plan.Actuator]:
    """Return the drives, winches and tugger lines of a mechanism, with their start, ramp and end positions."""
    found = []
    for name, drive in checks.given.drives.items():
        lower, upper = drive.range or (None, None)
        where = checks.source.where((*checks.base, "drives", name))
        start = _start(checks, drive)
        accel, pulses = ramp_of(drive.ramp)
        ordered = lower is not None and upper is not None and lower < upper
        if drive.range and ordered and not drive.range[0] - TOUCH <= start <= drive.range[1] + TOUCH:
            first, *ends = (_place(checks, drive, x) for x in (start, lower, upper))
            message = f"{plan.driven(name)} begins at {first}, past the end of its range, {' to '.join(ends)}"
            checks.fault((*checks.base, "joints", drive.joint, "start"), message)
        found.append(
            plan.Actuator(
                name=name, start=start, accel=accel, lower=lower, upper=upper, pulses=pulses, verb=drive.verb or "",
                speed=drive.speed, emergency=drive.emergency, where=where,
            )
        )  # fmt: skip
    for name, rope in checks.given.ropes.items():
        if rope.winch:
            where, winch = checks.source.where((*checks.base, "ropes", name, "winch")), rope.winch
            lower, upper = winch.shortest, winch.longest
            found.append(
                plan.Actuator(name=name, start=rope.length, accel=winch.ramp, lower=lower, upper=upper, where=where)
            )
    for name, line in checks.given.forces.items():
        rate, start = (getattr(line, key, 0.0) for key in ("rate", "tension"))
        if rate:
            where, accel = checks.source.where((*checks.base, "forces", name)), rate / EASES
            found.append(plan.Actuator(name=name, start=start, accel=accel, lower=0.0, speed=rate, where=where))
    return found


def _start(checks: Checking, drive: mechanics.DriveKeys) -> float:
    """Return the start value of a drive's coordinate."""
    joint = checks.given.joints.get(drive.joint)
    named = dict(zip(joint.coordinates, joint.values(POSITIONS), strict=False)) if joint else {}
    return named.get(drive.coordinate, next(iter(named.values()), 0.0))
