"""A simulation between two calls as plain numbers, and a simulation that goes on from them bit for bit.

Step size and its history, the tentative step, armed guards and modes are in X, P and M; beside them stand laws with
their starts, accounts and the number of the next sample.  `parts` are those of `Simulation.parts`.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy, deepcopy
from hashlib import sha256
from typing import Any

import numpy as np
from heavylift.kernel.errors import KernelError
from heavylift.kernel.simulation.native.native_state import NativeState

__all__ = ["back", "foreign", "go_on", "kept", "mark"]

State = dict[str, dict[str, Any]]
Parts = Mapping[str, object]

KEPT: dict[str, tuple[str, ...]] = {  # part of a simulation -> its state; (): all of it
    "simulation": ("still",),
    "order": ("phase",),
    "native": ("X", "P", "M", "epoch", "notes"),
    "recorder": ("rows", "number", "rested"),
    "steps": ("lengths", "missed"),
    "balance": (),
    "events": ("fallen", "t_ns", "before", "instant"),
    "patience": ("since", "crowd", "spell"),
    "rattling": ("counts",),
    "references": ("actuators",),
    "switches": ("watched",),
}
IN_PLACE = ("X", "P", "M", "rows", "notes")  # as all tables are: they are in other hands, too
COMMANDED = ("rattling", "references", "switches")  # what changes only where something happens


def _state(part: object, names: tuple[str, ...]) -> dict[str, Any]:
    return {name: getattr(part, name) for name in names or vars(part)}


def _write(part: object, state: Mapping[str, Any]) -> None:
    """Bring a part to a state."""
    for name, x in state.items():
        mine = getattr(part, name)
        if name in IN_PLACE and mine is not None:
            mine[:] = x
        elif isinstance(mine, dict):
            mine.clear()
            mine.update(x)
        else:
            setattr(part, name, x)


def kept(parts: Parts, native: NativeState) -> dict[str, Any]:
    """All that the future depends on."""
    state = {name: _state(part, KEPT[name]) for name, part in parts.items()}
    variant = {"locked": sorted(native.program.locked), "calm": sorted(native.calm)}
    return deepcopy({**state, "variant": variant, "scene": _scene(native)})


def go_on(parts: Parts, native: NativeState, snapshot: dict[str, Any]) -> None:
    """Bring a started simulation to the point of a snapshot; raises KernelError for one of another scene."""
    if not isinstance(snapshot, dict) or snapshot.get("scene") != _scene(native):
        raise foreign()
    state = deepcopy(snapshot)
    native.calm = frozenset(state["variant"]["calm"])
    native.use(frozenset(state["variant"]["locked"]))
    for name, part in parts.items():
        _write(part, state[name])


def mark(parts: Parts) -> State:
    """What a run changes as long as nothing happens, for `back`; cheaper than a snapshot."""
    changed = {name: part for name, part in parts.items() if name not in COMMANDED}
    return {name: {k: copy(x) for k, x in _state(part, KEPT[name]).items()} for name, part in changed.items()}


def back(parts: Parts, marked: State) -> None:
    """Stand again where `mark` was made, before anything happened."""
    for name, state in marked.items():
        _write(parts[name], state)


def foreign() -> KernelError:
    """A snapshot of something else."""
    return KernelError(
        "the snapshot was not taken from this scene with these options; restore it in a simulation of the same system, "
        "method, tolerance and sample period"
    )


def _scene(native: NativeState) -> str:
    """What tells scenes with their options apart: names, numbers at the start, places in X, method, steps, samples."""
    p, o = native.program, native.options
    names = [[b.name for b in p.system.bodies], [k.joint.name for k in p.graph.links], p.guards, p.accounts]
    layout = [o.method, o.step, o.sample_ns, native["tol"], native["h_max"], list(native.at)]
    start = p.parameters.initial.tobytes() + np.ascontiguousarray(p.initial_state()).tobytes()
    return sha256(repr((names, layout)).encode() + start).hexdigest()
