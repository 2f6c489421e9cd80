"""The parts of a scene that can be moved by hand: where the text gives their positions, and which bodies or points move
with them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.scene.text.source import Data, read
from heavylift.nodes.scene.text.units import LENGTH

TROLLEY = " trolley"


def handles(text: str, plan: Plan) -> dict[str, list[dict[str, Any]]]:
    """Return the parts of a scene that can be dragged by hand, because their positions are written as lengths.

    `moving` with path, bodies, coordinates [m] and free axes; lugs and supports as points `p` of a body; hooks, to
    which lugs snap.
    """
    data = read(text, "scene.yaml").data
    hooks = [{"name": x.rope, "body": x.eye.body, "p": x.eye.p} for machine in plan.machines for x in machine.hooks]
    return {"moving": [*_cranes(data, plan), *_blocks(data, plan), *_obstacles(data)], "hooks": hooks}


def _cranes(data: dict[str, Data], plan: Plan) -> Iterator[dict[str, Any]]:
    bodies = {machine.name: [body.name for body in machine.system.bodies] for machine in plan.machines}
    for name, keys in _mapping(data.get("cranes")).items():
        if name not in bodies:
            continue
        for key, written in _mapping(keys).items():
            at, trolley = _lengths(written), f"{name}.{key.removesuffix(TROLLEY)}"
            if key == "at" and at:
                yield _handle(["cranes", name, key], bodies[name], at, "x" if len(at) == 1 else "xy")
            elif key.endswith(TROLLEY) and at and trolley in bodies[name]:
                yield _handle(["cranes", name, key], [trolley], at, "y")


def _blocks(data: dict[str, Data], plan: Plan) -> Iterator[dict[str, Any]]:
    cargo = [x.body for machine in plan.machines for x in machine.cargo]
    alone = [(["block"], cargo[0], data["block"])] if len(cargo) == 1 and "block" in data else []
    several = [(["blocks", name], name, keys) for name, keys in _mapping(data.get("blocks")).items() if name in cargo]
    for path, body, keys in (*alone, *several):
        block = _mapping(keys)
        if at := _lengths(block.get("at")):
            yield _handle([*path, "at"], [body], at, "xy")
        for name, written in _mapping(block.get("lugs")).items():
            if p := _lengths(written):
                yield _point([*path, "lugs", name], p, "xyz", body, p, name)
        under = {x.name: x.point.p for machine in plan.machines for x in machine.system.supports}
        places = _mapping(block.get("supports")).get("at")
        for i, written in enumerate(places if isinstance(places, list) else ()):
            p, name = _lengths(written), f"{body}.lower-{i + 1}"
            if p and name in under:
                yield _point([*path, "supports", "at", i], p, "xy", body, list(under[name]), f"support {i + 1}")


def _obstacles(data: dict[str, Data]) -> Iterator[dict[str, Any]]:
    for name, keys in _mapping(data.get("obstacles")).items():
        obstacle = _mapping(keys)
        if (at := _lengths(obstacle.get("at"))) and obstacle.get("on", "world") == "world":
            yield _handle(["obstacles", name, "at"], [name], at, "xyz")


def _point(path: list[str | int], at: list[float], free: str, body: str, p: list[float], name: str) -> dict[str, Any]:
    return _handle(path, [], at, free) | {"point": name, "body": body, "p": p}


def _handle(path: Sequence[str | int], bodies: list[str], at: list[float], free: str) -> dict[str, Any]:
    return {"path": list(path), "bodies": bodies, "at": at, "free": free, "listed": len(at) > 1}


def _mapping(data: Data) -> dict[str, Data]:
    return data if isinstance(data, dict) else {}


def _lengths(written: Data) -> list[float]:
    """A length or a list of them [m]; empty for anything else."""
    try:
        return [LENGTH.read(x) for x in (written if isinstance(written, list) else [written])]
    except (ValueError, TypeError, AttributeError):
        return []
