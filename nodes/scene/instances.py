"""Several instances of scenes in one scene: the plan of each instance is moved to another place, with a prefix on all
its names.

`lifts: {a: {extends: lift.yaml, at: [0 m, 60 m]}}` builds the scene of each instance as if it were alone (equal ones
only once) and places the instances beside each other; their parts get names such as `a-crane`, `a-legs.sling-1`.
Nothing couples the instances, so their equilibrium paths are computed separately.
"""

import json
from collections.abc import Callable, Container, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
from heavylift.kernel.description.contacts import Ball, Box, Plane
from heavylift.kernel.description.field_types import field_names
from heavylift.kernel.description.findings import Check
from heavylift.kernel.description.forces import Characteristic
from heavylift.kernel.description.mechanics import WORLD, Joint, Point, Vector
from heavylift.nodes.plan.actions import Action, Begin, BegunCondition, Wait
from heavylift.nodes.plan.connections import frames_on_hooks
from heavylift.nodes.plan.factors import Factor
from heavylift.nodes.plan.limit import RatedLimit
from heavylift.nodes.plan.mechanism import Cargo, Heavy, Hoist, Mechanism, Shape
from heavylift.nodes.plan.plan import ActionList, Fidelity, Plan
from heavylift.nodes.plan.user_models import UserModel
from heavylift.nodes.scene.construction.resolve import build_actions
from heavylift.nodes.scene.construction.scene_builder import SceneBuilder
from heavylift.nodes.scene.construction.signals import build_interlocks
from heavylift.nodes.scene.keys.schema import ORDERED, Scene
from heavylift.nodes.scene.text.extending import over
from heavylift.nodes.scene.text.faults import raise_faults
from heavylift.nodes.scene.text.source import SourceText
from heavylift.nodes.statics import Followed, StaticState, goal_states
from heavylift.nodes.statics.findings import path_findings
from heavylift.nodes.statics.state import Acted

from .loaded_scene import LoadedScene

COMMON = ("accuracy", "ask", "samples", "method", "tolerance", "tolerance of", "step", "seed", "gravity", "microsteps")
OWN = ("at", "start", "of")  # keys of an instance that are no keys of its scene
SIDE_BY_SIDE = ("machines", "models", "interlocks", "may_touch", "gear")  # of a plan
NAMES = frozenset(  # fields of descriptions and plans that hold names of parts
    ("name", "joint", "parent", "child", "body", "of", "rope", "model", "actuator", "sling", "brake", "names", "ropes",
     "elements", "subject", "on", "taut", "closed", "slings", "lug", "machine", "hooks", "interlock", "together",
     "master", "followers", "block", "locked", "lugs", "rigging", "slides", "ties")
)  # fmt: skip
WORDS = {  # fields that hold other words
    Characteristic: ("of",),
    UserModel: ("model",),
    Factor: ("name",),
    Fidelity: ("ropes", "slings"),
}
MACHINES = (
    *("cranes", "block", "blocks", "rig", "rigging", "edges", "mechanism", "machines", "models", "limits"),
    *("wind", "waves", "current", "vessels", "floor", "obstacles"),
)
EVERY = "all"  # subject of limits of the whole scene, and its own action list


def source_of(whole: SourceText, name: str, path: Path, at: tuple[float, float]) -> SourceText:
    """Return the source of one lift of a scene: its keys merged over the scene that it extends.

    `at`: origin of the lift [m]."""
    base = ("lifts", name)
    keys, values = (
        {at[2:]: mark for at, mark in some.items() if at[:2] == base} for some in (whole.keys, whole.values)
    )
    given = whole.at(base)
    data = {key: value for key, value in given.items() if key not in OWN} if isinstance(given, dict) else {}
    data |= {key: whole.data[key] for key in COMMON if key in whole.data}
    keys |= {(key,): whole.keys[key,] for key in COMMON if (key,) in whole.keys}
    values |= {(key,): whole.values[key,] for key in COMMON if (key,) in whole.values}
    found = over(SourceText(whole.name, data, keys, values, root=whole.root, files=(whole.name,)), path, whole.root)
    raise_faults(found, found.faults)
    block = found.data.pop("block", None) if "rig" not in found.data else None
    if block is not None:
        blocks = found.data.setdefault("blocks", {})
        if isinstance(blocks, dict):
            blocks["block"] = block
        for some in (found.keys, found.values):
            some |= {("blocks", *at): mark for at, mark in some.items() if at[:1] == ("block",)}
    waves = found.data.get("waves")
    if isinstance(waves, dict):  # which meet it where it is put
        waves.setdefault("origin", [f"{-x!r} m" for x in (*at, 0.0)])
    for key in ("end", "placement"):
        found.data.pop(key, None)
    return found


def several(
    source: SourceText, scene: Scene, path: Path, built: Callable[[SourceText], LoadedScene]
) -> tuple[Plan, Followed, dict[str, LoadedScene]]:
    """Return the plan of all lifts of a scene, their equilibrium paths joined in one, and the scene of each lift."""
    for key in sorted(scene.model_fields_set & {*MACHINES}):
        message = "a scene of several lifts has nothing else: what belongs to one of them stands there"
        source.fault((key,), message, on_key=True)
    raise_faults(source, source.faults)
    alone: dict[str, LoadedScene] = {}
    lifts: list[tuple[str, LoadedScene]] = []
    for name in scene.lifts:
        own = source_of(source, name, path, scene.lifts[name].at)
        text = json.dumps(own.data, sort_keys=True)
        lifts.append((name, alone.get(text) or alone.setdefault(text, built(own))))
    raise_faults(source, source.faults)
    whole, acted, ranks = Plan(name=scene.name), list[Acted](), dict[str, int]()
    rests = {name: _rests(loaded, name, (*scene.lifts[name].at, 0.0)) for name, loaded in lifts}
    first_of_all = _together([x["path"][0] for x in rests.values() if x["path"]])
    states, goals = list[StaticState](), list[StaticState]()
    for name, loaded in lifts:
        given, first = scene.lifts[name], len(whole.actions)
        part = moved(loaded.plan, f"{name}-", (*given.at, 0.0))
        wait: tuple[Action, ...] = ()
        if given.start == ORDERED:
            wait = (Action(when=BegunCondition(lift=name), orders=()),)
        elif given.start:
            wait = (Action(orders=(Wait(seconds=given.start),)),)
        actions = (*wait, *(msgspec.structs.replace(x, stage=_named(name, x.stage)) for x in part.actions))
        own_list = ActionList(
            name=name,
            first=first,
            machines=tuple(machine.name for machine in part.machines),
            fidelity=part.fidelity,
            start=part.start,
        )
        more: dict[str, Any] = {of: getattr(whole, of) + getattr(part, of) for of in SIDE_BY_SIDE}
        frames = frames_on_hooks(part.machines)
        ranks |= {machine.name: _rank(machine, frames) for machine in part.machines}
        more["machines"] = tuple(sorted(more["machines"], key=lambda machine: ranks[machine.name]))
        more["limits"] = whole.limits + tuple(_own_limit(x, name) for x in part.limits)
        more |= {"actions": whole.actions + actions, "lists": (*whole.lists, own_list)}
        whole = msgspec.structs.replace(whole, **more)
        shift = first + len(wait)
        path_, goals_ = (
            [_numbered(_together([first_of_all, x]), name, shift) for x in rests[name][what]]
            for what in ("path", "goals")
        )
        states += path_
        goals += [replace(x, tensions={}, supports={}, hooked={}) for x in goals_]
        began = zip(loaded.statics.acted, rests[name]["acted"], strict=True)
        acted += [replace(x, before=_numbered(before, name, shift)) for x, before in began]
    builder = SceneBuilder(source, scene, [*whole.machines], limits=whole.limits)
    hooks = [hook for crane in builder.cranes for hook in crane.hooks if hook.eye.body != hook.rope]
    builder.hooks = {hook.eye.body.rpartition(".")[0]: _split(hook.rope) for hook in hooks}
    between, listed = build_interlocks(builder), build_actions(builder)
    _begins_each_once(source, scene, listed)
    raise_faults(source, source.faults)
    lists = (*whole.lists, ActionList(name=EVERY, first=len(whole.actions), machines=())) if listed else whole.lists
    whole = msgspec.structs.replace(
        whole, interlocks=whole.interlocks + between, actions=whole.actions + listed, lists=lists
    )
    why = next((f"{name}: {x.statics.why}" for name, x in lifts if x.statics.why), "")
    notes = tuple((t, f"{name}: {sentence}") for name, x in lifts for t, sentence in x.statics.notes)
    unstable = next((x.statics.unstable for _, x in lifts if x.statics.unstable is not None), None)
    tripped = tuple((t, f"{name}-{x}") for name, lift in lifts for t, x in lift.statics.tripped)
    found = tuple(_finding(x, name) for name, lift in lifts for x in path_findings(lift.plan, lift.statics))
    followed = Followed(tuple(states), tuple(acted), notes, why, unstable, "", tripped, tuple(goals), found)
    return whole, followed, dict(lifts)


def _own_limit(limit: RatedLimit, name: str) -> RatedLimit:
    """Return a limit of an instance; a limit on the instance's whole scene gets the instance's name as subject."""
    rest = limit.rest and msgspec.structs.replace(limit.rest, stage=_named(name, limit.rest.stage))
    return msgspec.structs.replace(limit, subject=name if limit.subject == EVERY else limit.subject, rest=rest)


def _rank(machine: Mechanism, frames: Container[str]) -> int:
    """Return the sort key for the order of nodes: cranes with frames on their hooks first, then the frames, the bodies
    that they lift, and others."""
    if any(hook.ends for hook in machine.hooks):
        return 0
    return 1 if machine.name in frames else 2 if frames and machine.cargo else 3


def _split(rope: str) -> tuple[str, str]:
    """Return the names of the crane and of the hook to which a hook rope belongs."""
    crane, _, hook = rope.rpartition(".")
    return crane, hook


def _begins_each_once(source: SourceText, scene: Scene, listed: Sequence[Action]) -> None:
    """Add errors of the common action list: orders to machines, a lift begun twice, a lift never begun."""
    begun: list[str] = []
    for order in (order for action in listed for order in action.orders):
        at = source.path_of(order.where)
        if isinstance(order, Begin):
            if order.lift in begun:
                source.fault(at, f"{order.lift} is begun twice", on_key=True)
            begun.append(order.lift)
        elif not isinstance(order, Wait):
            message = "this list begins lifts (`b: begin`); their machines obey the lists of their own scenes"
            source.fault(at, message, on_key=True)
    for name, lift in scene.lifts.items():
        if lift.start == ORDERED and name not in begun:
            message = f"nothing begins {name}: write an action `{name}: begin` in this scene, with its condition `when`"
            source.fault(("lifts", name, "start"), message)
        if name == EVERY:
            source.fault(("lifts", name), f"a lift cannot be called '{EVERY}'", on_key=True)


def _named(name: str, stage: str) -> str:
    return f"{name}: {stage}" if stage else ""


def _numbered(state: StaticState, name: str, shift: int) -> StaticState:
    number = state.action + shift if state.action else 0
    return replace(state, stage=_named(name, state.stage), action=number)


def _rests(loaded: LoadedScene, name: str, d: Vector) -> dict[str, list[StaticState]]:
    """Return, for an instance at its place, the states of its equilibrium path, the states in which its actions begin,
    and the states at the ends of its moves."""
    known: dict[int, StaticState] = {}

    def here(state: StaticState) -> StaticState:
        if id(state) not in known:
            known[id(state)] = _moved_state(state, f"{name}-", d)
        return known[id(state)]

    path = loaded.statics
    each = {"path": path.states, "acted": [x.before for x in path.acted], "goals": goal_states(loaded.plan, path)[1:]}
    return {what: [*map(here, states)] for what, states in each.items()}


def _finding(check: Check, name: str) -> Check:
    """Return a finding about an instance's equilibrium path, with the name of the instance added."""
    words = {"subject": f"{name}-{check.subject}", "stage": _named(name, check.stage)}
    return msgspec.structs.replace(check, sentence=f"{name}: {check.sentence}", **words)


PARTS = ("tensions", "supports", "poses", "coordinates", "references", "speeds", "hooked", "modes")


def _together(states: list[StaticState]) -> StaticState:
    """Return one state merged from the states of all instances, with the time, stage and texts of the last one."""
    whole: dict[str, Any] = {part: dict(getattr(states[0], part)) for part in PARTS}  # one copy: that is often done
    for state in states[1:]:
        for part, known in whole.items():
            known.update(getattr(state, part))
    return replace(states[-1], **whole)


# names and places


def moved(x: Any, prefix: str, d: Vector) -> Any:
    """Return a plan or description moved by d [m] in the world frame, with a prefix added to all names."""
    if isinstance(x, tuple):
        return tuple(moved(each, prefix, d) for each in x)
    if isinstance(x, dict):
        return {key: moved(each, prefix, d) for key, each in x.items()}
    if not (names := field_names(x.__class__)):
        return x
    words = next((words for kinds, words in WORDS.items() if isinstance(x, kinds)), ())
    fields = ((name, getattr(x, name)) for name in names)
    changed = {name: value if name in words else _changed(name, value, prefix, d) for name, value in fields}
    if isinstance(x, Point | Ball | Box | Plane) and x.body == WORLD:
        changed["p"] = _sum(x.p, d)
    if isinstance(x, Heavy | Hoist) and x.ends:
        changed["ends"] = tuple(_sum(p, d) for p in x.ends)
    if isinstance(x, Shape) and x.thing:
        *kind, thing = x.thing.split(" ")
        changed["thing"] = " ".join([*kind, _renamed(thing, prefix)])
    if isinstance(x, Cargo):
        changed |= {"faces": {_renamed(support, prefix): face for support, face in x.faces.items()}}
        changed |= {"marks": {_renamed(lug, prefix): where for lug, where in x.marks.items()}}
    if isinstance(x, Joint) and x.parent == WORLD:
        free = x.kind == "free" and x.q0
        changed |= {"q0": (*_sum(x.q0[:3], d), *x.q0[3:])} if free else {"p_PJ": _sum(x.p_PJ, d)}
    return type(x)(**changed)


def _changed(name: str, value: Any, prefix: str, d: Vector) -> Any:
    words = value if isinstance(value, tuple) else (value,)
    if name in NAMES and (isinstance(value, dict) or all(isinstance(x, str) for x in words)):
        return _renamed(value, prefix)
    return moved(value, prefix, d)


def _renamed(value: Any, prefix: str) -> Any:
    """Return names with a prefix; the name of the ground and empty names stay unchanged."""
    if isinstance(value, str):
        return value if value in ("", WORLD, EVERY) else f"{prefix}{value}"
    if isinstance(value, dict):
        return {_renamed(key, prefix): _renamed(x, prefix) for key, x in value.items()}
    if not isinstance(value, tuple):
        return value
    return tuple(_renamed(x, prefix) for x in value)


def _sum(p: Sequence[float], d: Vector) -> Vector:
    x, y, z = (a + b for a, b in zip(p, d, strict=True))
    return x, y, z


def _moved_state(x: StaticState, prefix: str, d: Vector) -> StaticState:
    def named(given: Any) -> dict[str, Any]:
        return {f"{prefix}{key}": value for key, value in given.items()}

    poses = {f"{prefix}{body}": (_sum(p, d), R) for body, (p, R) in x.poses.items()}
    parts: dict[str, Any] = {name: named(getattr(x, name)) for name in PARTS if name not in ("poses", "hooked")}
    hooked = {f"{prefix}{sling}": _renamed(lug, prefix) for sling, lug in x.hooked.items()}
    return replace(x, poses=poses, hooked=hooked, **parts)
