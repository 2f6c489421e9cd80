"""The columns of a run that limits are read from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from heavylift.nodes.limits.signals import Signals, hooked_in
from heavylift.nodes.plan.plan import Plan
from numpy.typing import NDArray

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
