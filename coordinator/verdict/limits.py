"""The limits of a run: their worst values and what was beyond them, as a table for the report."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from heavylift.nodes.limits.judging import judge, uses_of
from heavylift.nodes.limits.sharing import dynamics_foreseen, hoisting_foreseen, shared
from heavylift.nodes.limits.signals import Signals, hooked_in
from heavylift.nodes.limits.telling import HEAD, rows, unjudged
from heavylift.nodes.plan.finding import Finding
from heavylift.nodes.plan.limit import Use
from heavylift.nodes.plan.plan import Plan
from heavylift.recordings.read.verdict import LimitTable
from numpy.typing import NDArray

from .rotating import matrices

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Judged:
    """The worst of each limit in a run, and what was found: red ones first."""

    plan: Plan
    uses: Sequence[Use]
    findings: Sequence[Finding]


def judged(plan: Plan, parts: Iterable[Signals]) -> Judged:
    """The limits of a run, of which each part begins with the last instant of the one before it."""
    uses = uses_of(plan, parts)
    return Judged(plan, uses, judge(plan, uses, dynamic=True))


def table(found: Judged) -> LimitTable:
    """The rows as the report shows them."""
    plan = found.plan
    red = {f.subject + f.kind for f in found.findings if f.severity == "red"}
    foreseen = dynamics_foreseen(plan)
    return LimitTable(
        head=HEAD,
        rows=tuple(rows(found.uses)),
        red=bool(red),
        findings=tuple((f.severity, f.subject, f.sentence, f.t) for f in found.findings),
        told=(*hoisting_foreseen(plan), *shared(plan), *unjudged(plan.limits, found.uses)),
        dynamic=foreseen,
    )


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
) -> Signals:
    """The columns of a run.

    t (n,) [s], tensions (n,) [N], poses (n, 7) [m, quaternion x y z w], the rope lines that hang from when on (`Rig`),
    exact peaks [N] and when [s], overloads that load cells told [N] and when [s], unstretched lengths (n,) [m].
    """
    return Signals(
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
