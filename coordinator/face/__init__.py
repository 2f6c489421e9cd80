"""heavylift in Python: what `import heavylift` gives; every name is imported when it is first used.

simulate(scene or system, until, ...) -> Result     a run as named arrays, in seconds
sweep(scene, ["block.mass=200..400 t by 25 t"], into="study")      many variants of one scene, on any Executor
tabulate(function, {"servers": [1, 2, 3]})           a function, System or DEVS model for values of its arguments
load(scene, ["block.mass=200 t"])                    a scene with changed settings, for all functions that take scenes
linearise(scene or system, inputs, outputs)         its matrices A, B, C, D, with names and units
from_mujoco("arm.xml")                              a model in MJCF or URDF as a system, and what of it has no equal
Environment(scene, ["drive"])                       a scene that a controller steps: reset, step, observe
sensitivities(scene)                                which uncertain input moves which figure
run(scene, "run.mcap"), Recording("run.mcap")        a recorded run; reading it
run_models("my_models:build", ...)                   DEVS models of your own
replicate("my_models:build", 30, ...)                a DEVS model with many seeds: means, confidence intervals
"""

TYPE_CHECKING = False  # as in `on_demand`
if TYPE_CHECKING:
    from heavylift.coordinator.run.linear import linearise
    from heavylift.coordinator.run.models import run_models
    from heavylift.coordinator.run.replications import replicate
    from heavylift.coordinator.run.result import Result
    from heavylift.coordinator.run.scene import run
    from heavylift.coordinator.run.simulate import simulate
    from heavylift.coordinator.run.units.environment import Environment
    from heavylift.coordinator.sweeps import sweep
    from heavylift.coordinator.sweeps.function_studies import tabulate
    from heavylift.coordinator.uncertainty.sensitivities import sensitivities
    from heavylift.kernel.version import __version__
    from heavylift.nodes.mujoco_models import from_mujoco
    from heavylift.nodes.scene import load
    from heavylift.recordings import Recording

__all__ = [
    "Environment", "Recording", "Result", "__version__", "from_mujoco", "linearise", "load", "replicate", "run",
    "run_models", "sensitivities", "simulate", "sweep", "tabulate",
]  # fmt: skip


def __getattr__(name: str) -> object:
    from heavylift.kernel.on_demand import on_demand  # not before: see `coordinator.cli`

    return on_demand(__name__)(name)
