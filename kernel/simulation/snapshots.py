"""Snapshots: the state of a simulation between two calls as plain numbers, from which another continues bit for bit.

Step size and its history, the tentative step, armed guards and modes are in X, P and M; in addition snapshots hold the
references with their starts, the log and notes, and the number of the next sample.
"""

from collections.abc import Mapping
from hashlib import sha256
from operator import attrgetter
from pickle import dumps, loads
from typing import Any

import numpy as np
from heavylift.kernel.errors import KernelError
from heavylift.kernel.simulation.native.native_state import NativeState

Snapshot = dict[str, Any]
Table = Mapping[str, tuple[str, ...]]  # part of a run, by its path -> names of its state; (): all that it has

CHANGED: Table = {  # by a run in which nothing happens
    "": ("still",),
    "order": ("phase",),
    "native": ("X", "P", "M", "epoch", "notes"),
    "recorder": ("rows", "number", "rested"),
    "recorder.steps": ("lengths", "missed"),
    "recorder.energy.balance": (),
    "events": ("fallen", "t_ns", "before", "instant"),
    "events.patience": (),
}
KEPT: Table = {
    **CHANGED,
    "events.rattling": ("counts",),
    "references": ("actuators",),
    "switches": ("watched",),
}
CHANGEABLE = (np.ndarray, list, dict)
IN_PLACE = ("X", "P", "M", "rows", "notes")  # as all tables are: they are in other hands, too


def _part(run: object, path: str) -> object:
    return attrgetter(path)(run) if path else run


def read(run: object, table: Table) -> Snapshot:
    """Return the state of all parts of a simulation by name, without copying it."""
    found = {path: (vars(x), names) for path, names in table.items() if (x := _part(run, path)) is not None}
    return {path: {name: of[name] for name in names or of} for path, (of, names) in found.items()}


def write(run: object, state: Snapshot) -> None:
    """Restore the state of all parts of a simulation that `read` returned."""
    for path, values in state.items():
        part = _part(run, path)
        for name, x in values.items():
            mine = getattr(part, name)
            if name in IN_PLACE and mine is not None:
                mine[:] = x
            elif isinstance(mine, dict):
                mine.clear()
                mine.update(x)
            else:
                setattr(part, name, x)


def copied(state: Snapshot) -> Snapshot:
    """Return a copy of a state that shares nothing with a simulation; about ten times as fast as `deepcopy`."""
    state = loads(dumps(state, -1))
    return state


def kept(run: object, native: NativeState) -> Snapshot:
    """Return a snapshot: the complete state from which a simulation can continue."""
    variant = {"locked": sorted(native.program.locked), "calm": sorted(native.calm)}
    return copied({"state": read(run, KEPT), "variant": variant, "scene": _scene(native)})


def go_on(run: object, native: NativeState, snapshot: Snapshot) -> None:
    """Continue a started simulation from a snapshot; raises KernelError for a snapshot of another scene."""
    if not isinstance(snapshot, dict) or snapshot.get("scene") != _scene(native):
        raise foreign()
    native.calm = frozenset(snapshot["variant"]["calm"])
    native.use(frozenset(snapshot["variant"]["locked"]))
    write(run, copied(snapshot["state"]))


def mark(run: object) -> Snapshot:
    """Return a copy of the state that changes between events, which `back` restores; cheaper than a snapshot."""
    return {path: {k: _own(x) for k, x in values.items()} for path, values in read(run, CHANGED).items()}


def back(run: object, marked: Snapshot) -> None:
    """Roll a simulation back to a state that `mark` saved after the last event; the state can be reused."""
    for path, values in marked.items():
        part = vars(_part(run, path))
        for name, x in values.items():
            if name not in IN_PLACE:
                part[name] = _own(x)
            elif x is not None:
                part[name][:] = x


def _own(x: Any) -> Any:
    return x.copy() if isinstance(x, CHANGEABLE) else x


def foreign() -> KernelError:
    """Return the error for a snapshot that was taken from another scene."""
    return KernelError(
        "the snapshot was not taken from this scene with these options; restore it in a simulation of the same system, "
        "method, tolerance and sample period"
    )


def _scene(native: NativeState) -> str:
    """Return the key of a scene with options: names, initial numbers, layout of X, method, steps, samples."""
    p, o = native.program, native.options
    names = [[b.name for b in p.system.bodies], [k.joint.name for k in p.graph.links], p.guards, p.accounts]
    layout = [o.method, o.step, o.sample_ns, native["tol"], native["h_max"], list(native.at)]
    start = p.parameters.initial.tobytes() + np.ascontiguousarray(p.initial_state()).tobytes()
    return sha256(repr((names, layout)).encode() + start).hexdigest()
