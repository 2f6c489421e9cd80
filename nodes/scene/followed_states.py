"""The steps of a followed action list as points of an equilibrium path, so that limits are judged on either.

Ropes hang plumb and stretch under what they carry; slings of one loader share its load.
"""

from __future__ import annotations

import math

from heavylift.nodes.statics.state import Pose, StaticState

from . import plan, schema
from .follow import Following, Step
from .standing import Standing
from .yard import exit_height

__all__ = ["states_of"]

LEVEL = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def states_of(scene: schema.Scene, built: plan.Plan, followed: Following) -> list[StaticState]:
    """One state for each step."""
    numbers = {order.where: n for n, action in enumerate(built.actions, 1) for order in (action, *action.orders)}
    return [_state(scene, built, step, numbers.get(step.where, 0)) for step in followed.steps]


def _state(scene: schema.Scene, built: plan.Plan, step: Step, action: int) -> StaticState:
    assert scene.rig is not None
    at = Standing(scene, built)
    at.state = step.state
    loads, g = step.loads or {}, built.gravity
    c, s = math.cos(step.state.theta), math.sin(step.state.theta)
    poses: dict[str, Pose] = {"block": (step.state.at, ((1.0, 0.0, 0.0), (0.0, c, s), (0.0, -s, c)))}
    for crane in built.cranes:
        x = step.state.cranes[crane.name]
        poses[f"{crane.name}.main"] = ((x, 0.0, 0.0), LEVEL)
        for trolley in ("upper", "lower"):
            poses[f"{crane.name}.{trolley}"] = ((x, step.state.trolleys[crane.name, trolley], 0.0), LEVEL)
    tensions: dict[str, float] = {}
    for rope in built.rig.hook_ropes:
        given, loader = scene.cranes[rope.crane], scene.rig.loaders[rope.carries]
        below = given.hook_block + loader.upper_mass + loader.lower_mass + loads.get(rope.carries, 0.0)
        tensions[rope.name] = below * g
        x, y, _ = at.eye(rope.carries)
        z = exit_height(given, rope.hook) - step.state.ropes[rope.name] * (1.0 + below * g / rope.EA)
        poses[f"{rope.carries}.upper"] = ((x, y, z), LEVEL)
        poses[f"{rope.carries}.lower"] = ((x, y, z - loader.hinge), LEVEL)
    for sling in built.rig.slings:
        pair = [x for x in built.rig.slings if x.loader == sling.loader and x.name in step.state.lugs]
        hangs = sling.name in step.state.lugs
        tensions[sling.name] = loads.get(sling.loader, 0.0) * g / len(pair) if hangs else 0.0
    return StaticState(
        t=0.0,
        action=action,
        stage=step.stage,
        event="",
        tensions=tensions,
        supports={},
        poses=poses,
        coordinates={},
        references=dict(step.state.ropes),
        speeds={},
        hooked=step.state.lugs,
        grounded=step.state.grounded,
        stiffness=0.0,
    )
