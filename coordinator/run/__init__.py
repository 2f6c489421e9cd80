"""Runs of a scene or of any DEVS model; completion of an interrupted run; what-if runs from some time on.

scene               `run`, the run of a scene; models: `run_models`; resume: from a recording that was cut off
verify              repetition of a recorded run, compared with its recording
branch              a recorded run with changes from some time on
replications        runs of a model for many seeds, with estimates of its results
units               a scene as a unit of FMI that another program steps
control             a controller in Python, called at a fixed period
simulate, result    the same for Python, in seconds and arrays
linear              `linearise`: the matrices of small motions, with inputs and outputs
arguments           checks of arguments that users pass in Python
conversation        messages with the nodes of one run, and the start of their processes
watch, progress     notifications of a run in progress, and their display
"""

from heavylift.coordinator.record.scene import RunResult
from heavylift.kernel.on_demand import face

from .scene import run

__all__ = ["RunResult", "run"]

face(__name__)
