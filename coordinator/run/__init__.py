"""Runs: of a scene, of any DEVS model, of what a crash has left.

scene               `run`, the run of a scene; models: `run_models`; resume: from a recording that was cut off
in_memory           the same without a file, a process or the bus; simulate: for Python, in seconds and arrays
conversation        with the nodes of one run, whatever they model; joining: how they come to their hub
watch, progress     what a run tells while it runs, and what a user sees of it
"""

from .scene import Result, run

__all__ = ["Result", "run"]
