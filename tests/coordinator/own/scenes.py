"""Scenes with models beside the kernel."""

from __future__ import annotations

from hashlib import blake2b
from pathlib import Path

from heavylift.nodes.scene import LoadedScene, load

SLEDGE = """\
heavylift: 1
name: sledge
end: 5 s
samples: 2 Hz
mechanism:
  name: sledge
  bodies:
    cart: {mass: 4 t}
    load: {mass: 1 t, inertia: [1 t m2, 1 t m2, 1 t m2]}
  joints:
    rail: {type: prismatic, child: cart, axis: [1, 0, 0]}
    float: {type: free, child: load, at: [0, 0, -10.01 m]}
  ropes:
    fall: {start: {body: cart}, end: {body: load}, length: 10 m, EA: 10 MN, damping: 10 kN s/m}
  drives:
    pusher: {joint: rail, type: servo, stiffness: 1 MN/m, damping: 0.4 MN s/m, ramp: 0.5 m/s2, range: [-1 m, 1 m]}
"""
HAND = """\
models:
  hand:
    model: beside.py:Hand
    period: 100 ms
    signals: {heard: position of rail}
    orders: {speed: pusher}
    parameters: {one: 18 m/min, two: -6 m/min, three: 0}
"""


def scene(folder: Path, *parts: str, sets: tuple[str, ...] = ()) -> LoadedScene:
    """The scene of these parts of a text, in the folder of its models."""
    file = folder / f"{blake2b(repr(parts).encode(), digest_size=6).hexdigest()}.yaml"
    file.write_text("".join(parts))
    return load(file, sets)


def listening(folder: Path, name: str, signal: str, period: str, sets: tuple[str, ...] = ()) -> LoadedScene:
    """A bundled scene to which somebody listens."""
    model = f"models: {{ear: {{model: beside.py:Ear, period: {period}, signals: {{heard: {signal}}}}}}}\n"
    return scene(folder, f"heavylift: 1\nextends: {name}\nname: {name}\n", model, sets=sets)
