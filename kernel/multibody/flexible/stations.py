"""A law's point on a flexible body becomes a massless body at its station, so that laws need not know of bending.

Points of one station share it: `girder@30` stands at x = 30 m of `girder`, with the rest of the point's coordinates
as a rigid arm.  Joints that a flexible body carries stand on stations as well, but for sliders.
"""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import Any

from heavylift.kernel.description.mechanics import Body, Joint, Point, System
from msgspec import Struct, structs

from .modes import FlexibleModes, modes_of


def with_stations(system: System) -> tuple[System, dict[str, FlexibleModes]]:
    """The system with stations and every point on one of them, and the modes of its flexible bodies by name."""
    modes = {b.name: modes_of(b.name, b.flexible) for b in system.bodies if b.flexible}
    if not modes:
        return system, modes
    stations: dict[str, Joint] = {}

    def on_station(x: Any) -> Any:
        if isinstance(x, Point) and x.body in modes:
            station, place = modes[x.body].station(x.p)
            name = f"{x.body}@{station:.9g}"
            X = tuple(float(e) for e in place)
            stations.setdefault(name, Joint(name, "fixed", x.body, name, (X[0], X[1], X[2])))
            return Point(name, (x.p[0] - X[0], x.p[1] - X[1], x.p[2] - X[2]))
        if isinstance(x, Joint) and x.parent in modes and x.kind != "slider":
            point = on_station(Point(x.parent, x.p_PJ))
            return replace(x, parent=point.body, p_PJ=point.p)
        if isinstance(x, tuple):
            return tuple(on_station(e) for e in x)
        if is_dataclass(x) and not isinstance(x, type):
            return replace(x, **{f.name: on_station(getattr(x, f.name)) for f in fields(x)})
        if isinstance(x, Struct):
            return structs.replace(x, **{name: on_station(getattr(x, name)) for name in x.__struct_fields__})
        return x

    laws = [f.name for f in fields(System) if f.name not in ("bodies", "joints", "gravity")]
    joints = on_station(system.joints)
    changed = {name: on_station(getattr(system, name)) for name in laws}
    bodies = (*system.bodies, *(Body(name, 0.0) for name in stations))
    return replace(system, bodies=bodies, joints=(*joints, *stations.values()), **changed), modes
