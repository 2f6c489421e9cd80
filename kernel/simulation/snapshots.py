"""A simulation between two calls as plain numbers, and a simulation that goes on from them bit for bit.

Step size and its history, the tentative step, armed guards and modes are in X, P and M; beside them stand laws with
their starts, accounts and the number of the next sample.
"""

from __future__ import annotations

from copy import deepcopy
from hashlib import sha256
from typing import Any

import numpy as np
from heavylift.kernel.errors import KernelError
from heavylift.kernel.methods.peers import Peer

__all__ = ["BLOCKS", "KEPT", "foreign", "go_on", "kept"]

BLOCKS = ("X", "P", "M")
KEPT = (
    *BLOCKS,
    "rows",
    "epoch",
    "_samples",
    "_fallen",
    "_event_ns",
    "_instant",
    "_still",
    "_rested",
    "_snapshot",
    "_missed",
    "_checked",
    "notes",
)


def kept(s: Any) -> dict[str, Any]:
    """All that the future depends on; raises KernelError for a method of SciPy, which keeps its history to itself."""
    if isinstance(s.method.method, Peer):
        raise KernelError(f"method {s.method.method.name}: SciPy keeps its history; choose a method of our own")
    beside = {"locked": sorted(s.program.locked), "balance": vars(s._balance)}
    beside |= {"calm": sorted(s._calm), "rattles": s._rattling.counts}
    beside |= {"patience": vars(s._patience), "phase": s.order.phase, "scene": _scene(s)}
    led = {"actuators": s.references.actuators, "watched": s.switches.watched}
    return deepcopy({**{name: getattr(s, name) for name in KEPT}, **beside, **led})


def go_on(s: Any, snapshot: dict[str, Any]) -> None:
    """Bring a started simulation to the point of a snapshot; raises KernelError for one of another scene."""
    if not isinstance(snapshot, dict) or snapshot.get("scene") != _scene(s):
        raise foreign()
    kept = deepcopy(snapshot)
    kept.pop("scene")
    s.order.phase = kept.pop("phase")
    s._calm = frozenset(kept.pop("calm"))
    s._use(frozenset(kept.pop("locked")))
    s._rattling.counts = kept.pop("rattles")
    vars(s._patience).update(kept.pop("patience"))
    for name in BLOCKS:  # in place, for parts of them are in other hands
        if (block := kept.pop(name)) is not None:
            getattr(s, name)[:] = block
    vars(s._balance).update(kept.pop("balance"))
    s.references.actuators.update(kept.pop("actuators"))
    s.switches.watched.update(kept.pop("watched"))
    vars(s).update(kept)


def foreign() -> KernelError:
    """A snapshot of something else."""
    return KernelError(
        "the snapshot was not taken from this scene with these options; restore it in a simulation of the same system, "
        "method, tolerance and sample period"
    )


def _scene(s: Any) -> str:
    """What tells scenes with their options apart: names, numbers at the start, places in X, method, steps, samples."""
    p, options = s.program, [s._sample_ns, *(s[name] for name in ("tol", "h_max"))]
    names = [[b.name for b in p.system.bodies], [k.joint.name for k in p.graph.links], p.guards, p.accounts]
    layout = [s.method.method.name, s._step, *options, list(s.method.layout.at)]
    start = p.parameters.initial.tobytes() + np.ascontiguousarray(p.initial_state()).tobytes()
    return sha256(repr((names, layout)).encode() + start).hexdigest()
