"""Ropes of a mechanism: between points, along several lines with the same tension, over points and sheaves, wound on
winches."""

from itertools import pairwise

from heavylift.kernel.description import forces as forces, mechanics as k
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.reeving import ReevingLaw
from heavylift.kernel.forces.table import check_force
from heavylift.nodes.scene.keys.base import BodyPoint
from heavylift.nodes.scene.keys.parts import kinematics, mechanics
from heavylift.nodes.scene.text.source import Path

from .checking import Checking
from .rigging.edges import along_edges


def rope_of(checks: Checking, name: str, rope: mechanics.RopeKeys) -> k.Rope | k.RigidRope:
    """Return a rope between points, which may run over further frictionless points."""
    path: Path = (*checks.base, "ropes", name)
    lines = [(line.start, line.end, line.share, (*path, "lines", i)) for i, line in enumerate(rope.lines)]
    for start, end, _, at in lines:
        checks.known((*at, "start", "body"), start.body)
        checks.known((*at, "end", "body"), end.body)
        checks.on_beam((*at, "start", "at"), start.body, start.at[0])
        checks.on_beam((*at, "end", "at"), end.body, end.at[0])
    if rope.start and rope.end and not rope.lines:
        nodes = _nodes(checks, path, rope.start, rope.over, rope.end)
        lines = [(a, b, 1.0, path) for a, b in pairwise(nodes)]
    elif rope.start or rope.end or rope.over or not rope.lines:
        checks.fault(path, "a rope has either 'start' and 'end' or 'lines'", on_key=True)
    _wound(checks, path, rope)
    _stretch(checks, path, rope)
    made = tuple(k.Line(k.Point(a.body, a.at), k.Point(b.body, b.at), share) for a, b, share, _ in lines)
    winch = rope.winch is not None
    if rope.rigid:
        return k.RigidRope(name, made, rope.length, winch, rope.hooked)
    return k.Rope(name, made, rope.EA or 1.0, rope.length, rope.damping or 0.0, winch, rope.hooked)


def _stretch(checks: Checking, path: Path, rope: mechanics.RopeKeys) -> None:
    """Add an error unless an elastic rope has a stiffness and a rigid rope has neither stiffness nor damping."""
    if not rope.rigid:
        if rope.EA is None:
            checks.fault(
                path, "the key 'EA' is missing; for a rope that cannot stretch, write 'rigid: true'", on_key=True
            )
        return
    for key in ("EA", "damping"):
        if getattr(rope, key) is not None:
            checks.fault((*path, key), f"a rigid rope cannot stretch: remove '{key}' or 'rigid'", on_key=True)


def reeving_of(checks: Checking, name: str, rope: mechanics.RopeKeys) -> forces.Reeving:
    """Return a rope over sheaves that have a radius or friction."""
    path: Path = (*checks.base, "ropes", name)
    if rope.start is None or rope.end is None or rope.lines:
        message = "a rope over sheaves or edges has 'start' and 'end', no 'lines'"
        checks.fault(path, message, on_key=True)
    start, end = (x or BodyPoint(body=k.WORLD) for x in (rope.start, rope.end))
    _nodes(checks, path, start, rope.over, end)
    _wound(checks, path, rope)
    _stretch(checks, path, rope)
    if rope.rigid:
        message = "a rigid rope runs over points only: leave 'radius', 'friction' and 'efficiency' of its sheaves away"
        checks.fault((*path, "rigid"), message, on_key=True)
    sheaves: tuple[forces.Sheave, ...] = tuple(s.built() for s in rope.over)
    signal = forces.InputSignal(rope.length, driven=rope.winch is not None)
    ends = k.Point(start.body, start.at), k.Point(end.body, end.at)
    faults = len(checks.source.faults)
    coms = {body.name: body.com for body in checks.lift.bodies} | {x: b.com for x, b in checks.given.bodies.items()}
    sheaves += along_edges(checks.source, path, rope.over_edges, checks.edges, ends, coms, checks.start)
    made = forces.Reeving(name, ends[0], sheaves, ends[1], rope.EA or 1.0, signal, rope.damping or 0.0, rope.hooked)
    if len(checks.source.faults) == faults:
        checks.checked(path, check_force, made)
    return made


def _nodes(
    checks: Checking, path: Path, start: BodyPoint, over: list[mechanics.Over], end: BodyPoint
) -> list[BodyPoint]:
    """Return start, intermediate points and end of a rope; add errors for unknown bodies."""
    placed: list[tuple[Path, BodyPoint]] = [((*path, "start"), start)]
    placed += [((*path, "over", i), node) for i, node in enumerate(over)]
    for at, node in [*placed, ((*path, "end"), end)]:
        checks.known((*at, "body"), node.body)
        checks.on_beam((*at, "at"), node.body, node.at[0])
    return [start, *over, end]


def _wound(checks: Checking, path: Path, rope: mechanics.RopeKeys) -> None:
    """Add an error unless the length of a rope is within the range of its winch."""
    if rope.winch and not rope.winch.shortest <= rope.length <= rope.winch.longest:
        ends = f"{rope.winch.shortest:g} and {rope.winch.longest:g} m"
        checks.fault((*path, "length"), f"{rope.length:g} m of rope is not between {ends}")


def span(checks: Checking, rope: forces.Reeving, at: kinematics.Poses) -> float:
    """Return the length [m] of a rope over its sheaves at the start."""
    try:
        return ReevingLaw().start_length(rope, lambda body: (at[body][1], at[body][0]))
    except KernelError as error:
        checks.fault((*checks.base, "ropes", rope.name), str(error), on_key=True)
        return 0.0
