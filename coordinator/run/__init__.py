"""Runs: of a scene, of any DEVS model, of what a crash has left, otherwise from some time on.

scene               `run`, the run of a scene; models: `run_models`; resume: from a recording that was cut off
verify              a recorded run once more, compared with its recording in all that a run determines
branch              a recorded run, otherwise from some time on and equal before
replications        a model for many seeds, and what its results estimate
units               a scene as a unit of FMI that another program steps
control             a controller in Python, called at a fixed period
simulate, result    the same for Python, in seconds and arrays
linear              `linearise`: the matrices of small motions, with inputs and outputs
arguments           what people call from Python, checked
conversation        with the nodes of one run, whatever they model, and how they come to their hub
watch, progress     what a run tells while it runs, and what a user sees of it
"""

from heavylift.coordinator.record.scene import RunResult
from heavylift.kernel.on_demand import face

from .scene import run

__all__ = ["RunResult", "run"]

face(__name__)
