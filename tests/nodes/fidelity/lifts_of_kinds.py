"""Random lifts with labels of their kinds: one scene for each seed.

A scene of `random_lifts` whose action list is changed by one kind of `LISTS`, or by none, and in two lifts of five its
machines by one of `MACHINES`.  So each kind has at least a twentieth of the lifts.

unhook            a hook is let go under load, where three or more carry
off-lead along, off-lead across   the block stands up to 0.6 m beside its hooks
different speeds  of hooks of two cranes, or of one; the ways are the same
moves             3 to 24 sideways, the median 8, there and back, in time with the swing to a tenth of its period
short moves       by less than their ramps need, at up to 1 m/s2, along or across
set down          and lifted again; in half of them the load was moved sideways before
jogs              3 to 10 of the hooks, by up to 20 mm, at up to 0.5 m/s2, up, or up and down
drop              lowered onto its supports at up to full speed, and lifted again in half of them
tilt              one hook is hoisted alone by up to 0.4 m
skew              one trolley, or one of two cranes, goes up to 0.3 m farther than the others
soft servos, no damping, light hooks, long ropes   of all machines: 0.15 to 0.5 Hz, none of ropes, slings and girders,
                  a tenth of the mass, 20 to 50 m more
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import pi, sqrt
from random import Random
from typing import Any

from heavylift.kernel import SceneError
from heavylift.nodes.scene import parse
from random_lifts import TWO, awaits_lifting, random_lift
from ruamel.yaml import YAML

Scene = dict[str, Any]
Actions = list[dict[str, str]]
ALTERED = 0.4  # part of the lifts whose machines are of a kind of their own
STRONG = dict.fromkeys(("hook capacity", "upper capacity", "lower capacity", "capacity"), "9000 t") | {
    "fall breaking": "20 MN",
    "tandem": 1,
}  # cranes that nothing which is drawn overloads
FEW, MANY = 0.8, 4  # so many of the lifts have so many hooks at most: the reference of more takes half a minute
LAST = "20 s"  # what is left of the swing is seen for so long
APART_FROM = 1_000_000  # seeds of lifts whose list is changed, until one suits the kind


@dataclass(frozen=True)
class Drawn:
    """A scene file, its kinds, and whether it waits for its lift-off."""

    text: str
    kinds: tuple[str, ...]
    awaits: bool


@cache
def lift_of_kinds(seed: int) -> Drawn:
    """The lift of this seed; lifts without hooks enough for its kind, and scenes that are refused, are drawn again."""
    r = Random(f"kinds {seed}")
    kind = r.choice(list(LISTS))
    most = MANY if r.random() < FEW else max(TWO)
    base = seed
    while True:
        scene = _scene(base)
        if LISTS[kind][1] <= len(hooks(scene)) <= most:
            drawn = _changed(scene, kind, r, awaits_lifting(base))
            if _accepted(drawn.text):
                return drawn
        base += APART_FROM


def _changed(scene: Scene, kind: str, r: Random, awaits: bool) -> Drawn:
    """The scene with its list, and perhaps its machines, changed."""
    kinds = [kind]
    LISTS[kind][0](scene, r)
    if r.random() < ALTERED:
        kinds.append(r.choice(list(MACHINES)))
        MACHINES[kinds[-1]](scene, r)
    scene["actions"][-1]["wait"] = LAST
    scene["rig"]["sling"]["breaking"] = "40 MN"
    for crane in scene["cranes"].values():
        crane |= STRONG
    return Drawn(json.dumps(scene, indent=1), tuple(kinds), awaits)


def _accepted(text: str) -> bool:
    """Whether the list can be carried out: a block may tilt onto a support that it should hang above."""
    try:
        parse(text)
    except SceneError:
        return False
    return True


def _scene(seed: int) -> Scene:
    scene: Scene = YAML(typ="safe", pure=True).load(random_lift(seed))
    return scene


def hooks(scene: Scene) -> list[str]:
    """Names of all that carry."""
    return [str(loader["hook"]) for loader in scene["rig"]["loaders"].values()]


def _plain(scene: Scene, r: Random) -> None:
    """As it is."""


def _after_hoisting(scene: Scene) -> tuple[Actions, int]:
    """The action list, and the place behind its stage "up"."""
    actions: Actions = scene["actions"]
    return actions, next(i for i, a in enumerate(actions) if a["stage"] == "up") + 1


def _perhaps_nothing_sideways(scene: Scene, r: Random) -> None:
    """In half of the lifts nothing but what the kind does makes the load swing."""
    if r.random() < 0.5:
        scene["actions"] = [a for a in scene["actions"] if a["stage"] not in ("sideways", "along")]


def _unhook(scene: Scene, r: Random) -> None:
    _perhaps_nothing_sideways(scene, r)
    actions, i = _after_hoisting(scene)
    actions[i - 1]["all hooks"] = (
        f"hoist {r.uniform(1.5, 3.0):.3f} m/min by 2.5 m"  # it tilts, but not onto its supports
    )
    actions.insert(r.choice([i, len(actions) - 1]), {"stage": "unhook", r.choice(hooks(scene)): "unhook"})


def _off_lead(axis: int) -> Callable[[Scene, Random], None]:
    def off_lead(scene: Scene, r: Random) -> None:
        _perhaps_nothing_sideways(scene, r)
        distance = r.choice([-1.0, 1.0]) * r.uniform(0.1, 0.6)
        at = [float(x.split()[0]) for x in scene["block"]["at"]]
        cranes = scene["cranes"].values()
        if axis == 0:
            for crane in cranes:
                crane["at"] = f"{float(str(crane['at']).split()[0]) + distance:.4f} m"
            return
        lugs = scene["block"]["lugs"]
        for name, crane in scene["cranes"].items():
            for loader in (x for x in scene["rig"]["loaders"].values() if x["hook"].startswith(name)):
                trolley = "lower trolley" if loader["hook"].endswith("H3") else "upper trolley"
                y = sum(float(lugs[lug][1].split()[0]) for lug in loader["lugs"]) / 2.0
                crane[trolley] = f"{at[1] + y + distance:.4f} m"

    return off_lead


def _different_speeds(scene: Scene, r: Random) -> None:
    _perhaps_nothing_sideways(scene, r)
    actions, names = scene["actions"], hooks(scene)
    slow = names[0].split()[0] if len(scene["cranes"]) == 2 else names[0]
    part, which = r.uniform(0.4, 0.9), r.choice(["up", "both"])
    for action in actions:
        if action["stage"] == "up" or (action["stage"] == "lift off" and which == "both"):
            verb, speed, rest = action.pop("all hooks").split(" ", 2)
            for name in names:
                at = float(speed) * (part if name.startswith(slow) else 1.0)
                action[name] = f"{verb} {at:.4f} {rest}"


def _moves(scene: Scene, r: Random) -> None:
    actions, i = _after_hoisting(scene)
    exit_ = max(float(crane["upper exit"].split()[0]) for crane in scene["cranes"].values())
    low = min(float(crane["lower exit"].split()[0]) for crane in scene["cranes"].values())
    long = (exit_ if any(not h.endswith("H3") for h in hooks(scene)) else low) - 6.0
    half = pi * sqrt(long / 9.81) * r.uniform(0.9, 1.1)
    speed, ramp, distance = r.uniform(5.0, 20.0) / 60.0, r.uniform(0.1, 0.3), r.uniform(0.1, 0.4)
    lasts = distance / speed + speed / ramp if distance > speed * speed / ramp else 2.0 * sqrt(distance / ramp)
    new: Actions = []
    for k in range(round(3.0 * 8.0 ** r.random())):
        go = f"traverse {60.0 * speed:.3f} m/min ramp {ramp:.3f} m/s2 by {distance if k % 2 == 0 else -distance:.3f} m"
        new += [
            {"stage": f"move {k}", "trolleys": go},
            {"stage": f"rest {k}", "wait": f"{max(0.1, half - lasts):.3f} s"},
        ]
    actions[i:-1] = new


def _short_moves(scene: Scene, r: Random) -> None:
    actions, i = _after_hoisting(scene)
    new: Actions = []
    for k in range(r.randint(1, 3)):
        what, verb = r.choice([("cranes", "travel"), ("trolleys", "traverse")])
        go = f"{verb} {r.uniform(10.0, 20.0):.3f} m/min ramp {r.uniform(0.3, 1.0):.3f} m/s2"
        new += [{"stage": f"short {k}", what: f"{go} by {r.choice([-1.0, 1.0]) * r.uniform(0.02, 0.3):.3f} m"}]
        new += [{"stage": f"rest {k}", "wait": f"{r.uniform(0.5, 6.0):.3f} s"}]
    actions[i:-1] = new


def _again(scene: Scene, r: Random) -> Actions:
    return [
        {"stage": "slacken", "all hooks": "lower 0.3 m/min by 0.05 m"},
        {"stage": "take up again", "all hooks": f"hoist {r.uniform(0.3, 1.5):.3f} m/min until all slings taut"},
        {"stage": "lift again", "all hooks": f"hoist {r.uniform(0.3, 1.5):.3f} m/min until lifted"},
        {"stage": "up again", "all hooks": f"hoist {r.uniform(1.0, 3.0):.3f} m/min by {r.uniform(0.2, 0.5):.3f} m"},
    ]


def _down(scene: Scene, speed: float) -> Actions:
    return [{"stage": "set down", "all hooks": f"lower {speed:.3f} m/min until landed and all slings slack"}]


def _set_down(scene: Scene, r: Random) -> None:
    _perhaps_nothing_sideways(scene, r)
    lowers = {"stage": "lower", "all hooks": f"lower {r.uniform(1.0, 3.0):.3f} m/min by 0.4 m"}
    down = [lowers, *_down(scene, r.uniform(0.3, 0.8)), *_again(scene, r)]
    scene["actions"][-1:-1] = down


def _drop(scene: Scene, r: Random) -> None:
    scene["actions"] = [a for a in scene["actions"] if a["stage"] not in ("sideways", "along")]
    down = _down(scene, r.uniform(1.0, 3.0)) + (_again(scene, r) if r.random() < 0.5 else [])
    scene["actions"][-1:-1] = down


def _jogs(scene: Scene, r: Random) -> None:
    actions, i = _after_hoisting(scene)
    back, pause = r.random() < 0.5, r.uniform(0.2, 2.0)
    ramp, distance = r.uniform(0.05, 0.5), r.uniform(0.005, 0.02)
    new: Actions = []
    for k in range(r.randint(3, 10)):
        verb = "lower" if back and k % 2 else "hoist"
        new += [{"stage": f"jog {k}", "all hooks": f"{verb} 3 m/min ramp {ramp:.3f} m/s2 by {distance:.4f} m"}]
        new += [{"stage": f"pause {k}", "wait": f"{pause:.3f} s"}]
    actions[i:i] = new


def _tilt(scene: Scene, r: Random) -> None:
    _perhaps_nothing_sideways(scene, r)
    actions, i = _after_hoisting(scene)
    verb = r.choice(["hoist", "lower"])
    go = f"{verb} {r.uniform(0.5, 3.0):.3f} m/min by {r.uniform(0.05, 0.4):.3f} m"
    actions.insert(i, {"stage": "tilt", r.choice(hooks(scene)): go})


def _skew(scene: Scene, r: Random) -> None:
    actions, i = _after_hoisting(scene)
    farther, names = r.uniform(0.05, 0.3), list(scene["cranes"])
    if len(names) == 2 and r.random() < 0.5:
        actions.insert(i, {"stage": "skew", names[0]: f"travel {r.uniform(5.0, 20.0):.3f} m/min by {farther:.3f} m"})
        return
    trolley = f"{names[0]} {'lower' if hooks(scene)[0].endswith('H3') else 'upper'} trolley"
    actions.insert(i, {"stage": "skew", trolley: f"traverse {r.uniform(4.0, 20.0):.3f} m/min by {farther:.3f} m"})


def _soft_servos(scene: Scene, r: Random) -> None:
    frequency = r.uniform(0.15, 0.5)
    for crane in scene["cranes"].values():
        crane["servo frequency"] = f"{frequency:.3f} Hz"


def _no_damping(scene: Scene, r: Random) -> None:
    for crane in scene["cranes"].values():
        crane |= {"rope damping": 0, "girder damping": 0}
    scene["rig"]["sling"]["damping"] = 0
    for loader in scene["rig"]["loaders"].values():
        loader["hinge damping"] = "0 N m s/rad"


def _light_hooks(scene: Scene, r: Random) -> None:
    for crane in scene["cranes"].values():
        crane["hook block"] = "2.5 t"
    for loader in scene["rig"]["loaders"].values():
        loader |= {"upper mass": "1 t", "lower mass": "1 t"}


def _long_ropes(scene: Scene, r: Random) -> None:
    more = r.uniform(20.0, 50.0)
    for crane in scene["cranes"].values():
        for key in ("upper exit", "lower exit", "highest hook"):
            crane[key] = f"{float(crane[key].split()[0]) + more:.4f} m"
        crane["drum"] = "200 m"


LISTS: dict[str, tuple[Callable[[Scene, Random], None], int]] = {  # and the fewest hooks that it needs
    "plain": (_plain, 1),
    "unhook": (_unhook, 4),
    "off-lead along": (_off_lead(0), 1),
    "off-lead across": (_off_lead(1), 1),
    "different speeds": (_different_speeds, 2),
    "moves": (_moves, 1),
    "short moves": (_short_moves, 1),
    "set down": (_set_down, 1),
    "jogs": (_jogs, 1),
    "drop": (_drop, 1),
    "tilt": (_tilt, 2),
    "skew": (_skew, 2),
}
MACHINES: dict[str, Callable[[Scene, Random], None]] = {
    "soft servos": _soft_servos,
    "no damping": _no_damping,
    "light hooks": _light_hooks,
    "long ropes": _long_ropes,
}
