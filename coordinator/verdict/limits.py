"""The columns of a run from which limits are checked."""

from collections.abc import Iterator, Mapping, Sequence
from math import atan2, ceil, cos, exp, pi, sin, sqrt

import numpy as np
from heavylift.kernel.description.findings import Check, finding
from heavylift.nodes.limits.signals import SignalColumns, hooked_in
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.plan.shapes import Shapes
from numpy.typing import NDArray

from .history import RunHistory, blocks
from .rotating import matrices

Floats = NDArray[np.float64]


def signals_of_run(
    plan: Plan,
    t: Floats,
    tensions: Mapping[str, Floats],
    poses: Mapping[str, Floats],
    rigs: Sequence[object],
    *,
    stages: Sequence[tuple[float, str]] = (),
    peaks: Mapping[str, tuple[float, float]] | None = None,
    crossings: Mapping[str, tuple[float, float]] | None = None,
    lengths: Mapping[str, Floats] | None = None,
) -> SignalColumns:
    """Return the columns of a run from which limits are checked.

    t (n,) [s], tensions (n,) [N], poses (n, 7) [m, quaternion x y z w], rope lines with the time from which they hang
    (`Rig`), exact peaks [N] and their times [s], overloads reported by load cells [N] and their times [s], unstretched
    lengths (n,) [m].
    """
    return SignalColumns(
        t=t,
        tensions=tensions,
        poses={name: (pose[:, :3], matrices(pose[:, 3:])) for name, pose in poses.items()},
        lengths=lengths or {},
        hooked=hooked_in(plan, [(rig.t_ns * 1e-9, rig.lines) for rig in rigs]),  # type: ignore[attr-defined]
        stages=stages,
        peaks=peaks or {},
        crossings=crossings or {},
        dynamic=True,
    )


def impacts(plan: Plan, past: RunHistory) -> dict[str, tuple[float, float]]:
    """Return, by name, the largest landing force [N] of a block on all its supports and on a single one, with the time
    [s].

    A pad yields as a spring with a damper, whose force at the instant of contact gives the speed; the whole mass lands
    on the pads that touch then, less what ropes and other supports carry.
    """
    found: dict[str, tuple[float, float]] = {}
    strands, pads = Shapes(plan).strands.values(), {s.name: s for m in plan.machines for s in m.system.supports}
    for limit in (x for x in plan.limits if x.quantity == "impact"):
        weight = (limit.value or 0.0) / limit.factor
        ropes = [x.rope for x in strands if limit.subject in x.ends]
        names = [name for name in limit.elements if name in pads and pads[name].d > 0.0]
        k, d = (np.array([getattr(pads[name], key) for name in names]) for key in ("k", "d"))
        for part in blocks(past) if names else ():
            F = np.array([part.tensions.get(name, np.zeros(len(part.t))) for name in names])
            pull = sum((part.tensions[rope] for rope in ropes if rope in part.tensions), np.zeros(len(part.t)))
            new = (F[:, 1:] > 0.0) & (F[:, :-1] == 0.0)
            for i in np.flatnonzero(new.any(axis=0)):
                on, now, t = new[:, i], F[:, i + 1], float(part.t[i + 1])
                others = float(now[~on].sum())
                free, speed = max(0.0, weight - others - float(pull[i + 1])), float((now[on] / d[on]).max())
                force = landing_force(weight / plan.gravity, free, float(k[on].sum()), float(d[on].sum()), speed)
                one = max(force * float(k[on].max() / k[on].sum()), float(now.max()))
                for what, value in (("impact", force + others), ("support load", one)):
                    key = f"{limit.subject} {what}"
                    found[key] = max(found.get(key, (0.0, 0.0)), (value, t), key=lambda x: x[0])
    return found


def rehits(plan: Plan, past: RunHistory, lands: Sequence[tuple[float, float]]) -> Iterator[Check]:
    """Yield a warning for each block that touches the deck of a vessel again after it was lifted off, with the number
    and the largest relative speed of these impacts; `lands`: intervals [s] in which it is set down on purpose."""
    pads = {s.name: s for m in plan.machines for s in m.system.supports if s.on and s.d > 0.0}
    for limit in (x for x in plan.limits if x.quantity == "impact"):
        names = [name for name in limit.elements if name in pads]
        d, lifted, hits = np.array([[pads[name].d] for name in names]), False, list[tuple[float, float]]()
        for part in blocks(past) if names else ():
            F = np.array([part.tensions.get(name, np.zeros(len(part.t))) for name in names])
            on = np.asarray((F > 0.0).any(axis=0))
            for i in np.flatnonzero(on[1:] != on[:-1]) + 1:
                t = float(part.t[i])
                meant = any(begin <= t <= end for begin, end in lands)
                if on[i] and lifted and not meant:
                    hits.append((float((F[:, i : i + 1] / d).max()), t))
                lifted = not meant and (lifted or not on[i])
        if hits:
            times = "once" if len(hits) == 1 else f"{len(hits)} times"
            speed = 60.0 * max(hits)[0]
            message = (
                f"{limit.subject} touched the deck again {times} after it was lifted off, at up to {speed:.2g} m/min"
            )
            yield finding("amber", "re-hit", limit.subject, f"{message}: hoist faster, or in a lower sea", t=hits[0][1])


def landing_force(mass: float, free: float, k: float, d: float, speed: float) -> float:
    """Return the largest force [N] of a spring k [N/m] with damper d [N s/m] on which a mass [kg] with uncarried weight
    `free` [N] lands at `speed` [m/s]: F = free - m a, m a'' + d a' + k a = 0."""
    a = free / mass - d * speed / mass
    slope = -(k * speed + d * a) / mass
    decay, square = d / (2.0 * mass), k / mass - (d / (2.0 * mass)) ** 2
    least, first = a, free - mass * a
    if square > 0.0:
        w = sqrt(square)
        b = (slope + decay * a) / w
        t = atan2(b * w - a * decay, a * w + b * decay) / w  # where a' = 0
        t += pi / w * max(0.0, ceil(-t * w / pi))
        for x in (t, t + pi / w):
            least = min(least, exp(-decay * x) * (a * cos(w * x) + b * sin(w * x)))
    return max(first, free - mass * least)
