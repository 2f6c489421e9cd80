"""Random lifts by other crane types and rigging, with labels of their kinds: one scene for each seed.

Half of the lifts are by goliaths of other types than `lifts_of_kinds` has, two of which may be unlike, with an action
list and machines as there; of these, one in six stands in the wind, one in six lifts a flexible block.  The other half
are by each other type of the library, with slings, a bridle, a spreader or an equaliser below the hook, in half of them
in the wind.
"""

from __future__ import annotations

import json
from functools import cache
from random import Random
from typing import Any

from lifts_of_kinds import APART_FROM, FEW, LISTS, MANY, Drawn, Scene, _accepted, _changed, _scene, hooks
from random_lifts import TWO, awaits_lifting

GOLIATHS = ("goliath-840", "goliath-1200", "goliath-1600")
WIND = {"speed": "8 m/s", "direction": [1, 0.5, 0], "turbulence": 0.1}
CRANES: dict[str, tuple[dict[str, Any], float, tuple[float, float]]] = {  # parameters, reach [t], where its hook is
    "crawler-250": ({"radius": "14 m"}, 60.0, (14.0, 0.0)),
    "jib-60": ({"radius": "16 m"}, 30.0, (16.0, 0.0)),
    "pedestal-400": ({"radius": "27 m"}, 110.0, (27.0, 0.0)),
    "overhead-100": ({"at": "5 m", "trolley": "12 m"}, 80.0, (5.0, 12.0)),
    "rough-terrain-59": ({"radius": "9 m"}, 12.0, (9.0, 0.0)),
}
SLING = {"EA": "60 MN", "breaking": "9 MN"}


@cache
def lift_of_the_world(seed: int) -> Drawn:
    """The lift of this seed; scenes that are refused are drawn again."""
    r = Random(f"world {seed}")
    draw = _goliath if r.random() < 0.5 else _machine
    base = seed
    while True:
        if (drawn := draw(base, r)) and _accepted(drawn.text):
            return drawn
        base += APART_FROM


def _goliath(base: int, r: Random) -> Drawn | None:
    """A lift by goliaths of other types, of any kind of list."""
    scene, kind = _scene(base), r.choice(list(LISTS))
    most = MANY if r.random() < FEW else max(TWO)
    if not LISTS[kind][1] <= len(hooks(scene)) <= most:
        return None
    types = [r.choice(GOLIATHS) for _ in scene["cranes"]]
    for crane, name in zip(scene["cranes"].values(), types, strict=True):
        crane |= {"type": name, "hook spacing": "6 m", "girder": ["12 m", "128 m"], "width": "30 m"}
    drawn = _changed(scene, kind, r, awaits_lifting(base))
    changed: Scene = json.loads(drawn.text)
    kinds = [*drawn.kinds, "unlike goliaths" if len({*types}) > 1 else types[0]]
    if r.random() < 1.0 / 6.0:
        changed["wind"], kinds = WIND, [*kinds, "wind"]
    elif r.random() < 0.2:
        changed["block"]["beam"], kinds = {"EI y": "200 GN m2", "damping": "2 %"}, [*kinds, "flexible block"]
    return Drawn(json.dumps(changed, indent=1), tuple(kinds), drawn.awaits)


def _machine(base: int, r: Random) -> Drawn:
    """A lift by a crane made of parts."""
    name = r.choice([*CRANES, "twin-hook-600", "mobile-gantry-600"])
    mass = r.uniform(0.2, 1.0) * CRANES[name][1] if name in CRANES else r.uniform(60.0, 300.0)
    if name == "mobile-gantry-600":
        below, rigging, at = "single slings", _corners(), (0.0, 0.0)
    elif name == "twin-hook-600":
        below, rigging, at = "two hooks on a spreader", _twin(), (0.0, 45.0)
    else:
        below = r.choice(list(BELOW))
        rigging, at = BELOW[below], CRANES[name][2]
    fast = 1.0 if name == "mobile-gantry-600" else 4.0  # [m/min] of its hooks
    long = 20.0 if name not in CRANES else 3.0
    scene: Scene = {
        "heavylift": 1,
        "name": f"world-{base}",
        "block": {
            "mass": f"{mass:.3f} t",
            "size": [f"{long} m", "9 m" if name not in CRANES else "2 m", "2 m"],
            "at": [f"{at[0]} m", f"{at[1]} m", "1.5 m"],
            "lugs": _lugs(0.4 * long, 4.0 if name not in CRANES else 0.5),
            "supports": {
                "height": "0.5 m",
                "at": [[f"{x * 0.4 * long} m", f"{y} m"] for x in (-1, 1) for y in (-0.5, 0.5)],
            },
        },
        "cranes": {"crane": {"type": name, **CRANES.get(name, ({},))[0]}},
        "rigging": rigging,
        "actions": [
            {"stage": "take up", "all hooks": "hoist 1 m/min until all slings taut"},
            {"stage": "lift off", "all hooks": f"hoist {r.uniform(0.3, 1.0):.3f} m/min until lifted"},
            {"stage": "up", "all hooks": f"hoist {r.uniform(0.5, 1.0) * fast:.3f} m/min by 0.5 m"},
            {"stage": "swing", "wait": "20 s"},
        ],
    }
    if name == "twin-hook-600":
        for action in scene["actions"][:3]:
            order = action.pop("all hooks")
            action |= {"crane H1": order, "crane H2": order}
    kinds = [name, below]
    if r.random() < 0.5:
        scene["wind"], kinds = WIND, [*kinds, "wind"]
    return Drawn(json.dumps(scene, indent=1), tuple(kinds), True)


def _lugs(x: float, y: float) -> Scene:
    corners = {"A": (-1, 1), "B": (1, 1), "C": (-1, -1), "D": (1, -1)}
    return {name: [f"{i * x} m", f"{j * y} m", "1.05 m"] for name, (i, j) in corners.items()} | {
        "M": ["0 m", "0 m", "1.05 m"]
    }


def _corners() -> Scene:
    ends = {"front-left": "B", "front-right": "D", "rear-left": "A", "rear-right": "C"}
    return {f"s-{h}": {"on": f"crane {h}", "to": [lug], "length": "3 m", "slack": "0.1 m"} for h, lug in ends.items()}


def _twin() -> Scene:
    frame = {"type": "spreader", "mass": "9 t", "size": ["16 m", "0.8 m", "1 m"]}
    points = {
        "w": ["-6 m", "0 m", "0.5 m"],
        "e": ["6 m", "0 m", "0.5 m"],
        "a": ["-8 m", "0 m", "-0.5 m"],
        "b": ["8 m", "0 m", "-0.5 m"],
    }
    return {
        "links": {"on": ["crane H1", "crane H2"], "to": ["beam.w", "beam.e"], "length": "3 m"},
        "beam": {**frame, "points": points},
        "west": {"on": "beam.a", "to": ["A", "C"], "length": "8 m"},
        "east": {"on": "beam.b", "to": ["B", "D"], "length": "8 m"},
    }


def _slings(*to: str) -> Scene:
    return {"legs": {"on": "crane main", "to": [*to], "length": "4 m", "sling": SLING}}


BELOW: dict[str, Scene] = {
    "one sling": _slings("M"),
    "two slings": _slings("A", "D"),
    "three slings": _slings("A", "B", "M"),
    "four slings": _slings("A", "B", "C", "D"),
    "bridle": {
        "top": {"on": "crane main", "to": ["ring"], "length": "1.5 m", "sling": SLING},
        "ring": {"type": "link", "mass": "0.1 t", "size": ["0.3 m", "0.3 m", "0.3 m"]},
        "legs": {"on": "ring", "to": ["A", "B", "C", "D"], "length": "3 m", "sling": SLING},
    },
    "spreader": {
        "top": {"on": "crane main", "to": ["beam.p", "beam.q"], "length": "1.6 m", "sling": SLING},
        "beam": {
            "type": "spreader", "mass": "0.4 t", "size": ["2.4 m", "0.2 m", "0.2 m"],
            "points": {
                "p": ["-1 m", "0 m", "0.1 m"], "q": ["1 m", "0 m", "0.1 m"], "a": ["-1.2 m", "0 m", "-0.1 m"],
                "b": ["1.2 m", "0 m", "-0.1 m"],
            },
        },
        "west": {"on": "beam.a", "to": ["A", "C"], "length": "2 m", "sling": SLING},
        "east": {"on": "beam.b", "to": ["B", "D"], "length": "2 m", "sling": SLING},
    },
    "equaliser": {
        "west": {"type": "equaliser", "on": "crane main", "to": ["A", "B"], "length": "7 m", "sling": SLING},
        "east": {"type": "equaliser", "on": "crane main", "to": ["C", "D"], "length": "7 m", "sling": SLING},
    },
}  # fmt: skip
