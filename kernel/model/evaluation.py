"""The equations of a whole scene at one instant, as a list of stages: places -> laws -> rows -> accelerations.

The one text that the float oracle runs and the tracer turns into machine code.  Each stage is a function of the
evaluation that reads what stages before it have written.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from heavylift.kernel.compiler.symbol import Array, Scalar

from . import accelerations, applied_forces, poses
from .instant import Evaluation
from .program import Program

__all__ = ["FORCES", "POSES", "Evaluation", "EvaluationStage", "evaluate"]


class EvaluationStage(NamedTuple):
    """A function with the fields of `instant.Evaluation` that it reads and writes, besides program, t, inside and P."""

    run: Callable[[Evaluation], None]
    reads: str
    writes: str


POSES = (
    EvaluationStage(poses.command_masters, "", "masters"),
    EvaluationStage(poses.prescribe_joints, "masters", "references q v"),
    EvaluationStage(poses.place_bodies, "q v", "ends"),
    EvaluationStage(poses.measure_angles, "ends counted", "turned turning"),
    EvaluationStage(poses.measure_masters, "q v ends turned turning", "masters"),
    EvaluationStage(poses.follow, "masters", "references"),
)
FORCES = (
    EvaluationStage(applied_forces.read_signals, "masters", "signals"),
    EvaluationStage(applied_forces.weigh_rigid_ropes, "ends", "wrenches stored"),
    EvaluationStage(applied_forces.apply_laws, "q v counted ends signals",
          "wrenches tau shown heat work stored watched turned turning"),
    EvaluationStage(applied_forces.drive, "q v references", "tau work"),
    EvaluationStage(applied_forces.bend, "q v", "tau heat stored watched"),
    EvaluationStage(accelerations.hold_rows, "q v ends masters references wrenches tau", "rows loads lengths_of"),
    EvaluationStage(accelerations.accelerate, "q v references tau rows", "dq dv work"),
    EvaluationStage(accelerations.pull_rigid_ropes, "rows lengths_of", "watched work"),
    EvaluationStage(accelerations.press_contacts, "ends rows", "wrenches heat stored pressing watched"),
    EvaluationStage(accelerations.watch_thresholds, "q v ends turned shown signals rows lengths_of", "watched"),
    EvaluationStage(accelerations.collect, "dq dv heat work turning watched", "dy guards"),
)  # fmt: skip


def evaluate(
    program: Program, t: Scalar, y: Array, P: Array, inside: Scalar | None = None, forces: bool = True
) -> Evaluation:
    """The scene's equations at time t [s], state y, parameters P; `inside`: a time within the present step.

    Without `forces` nothing is known but where the bodies are and how they move.
    """
    q, v = program.nq, program.nq + program.nv
    behind = v + len(program.accounts)
    x = Evaluation(program, t, t if inside is None else inside, P, list(y[:q]), list(y[q:v]), list(y[v:behind]))
    x.counted, x.tau = list(y[behind:]), [0.0] * program.nv
    x.wrenches = [np.zeros(6) for _ in program.graph.links]
    for stage in POSES + FORCES if forces else POSES:
        stage.run(x)
    return x
