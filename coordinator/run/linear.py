"""A scene or a system linearised: `heavylift.linearise`, whose matrices python-control or SciPy take as they are.

model = linearise("crane.yaml", ["crane.trolley"], ["joint/position/*"])
control.ss(*model)
"""

from collections.abc import Sequence
from pathlib import Path

from heavylift.coordinator.participants.mechanics_at import at_rest, paused
from heavylift.kernel.analysis.equilibrium import equilibrium
from heavylift.kernel.analysis.linear import LinearModel, linear_model
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.errors import KernelError
from heavylift.kernel.simulation.simulation import Simulation
from heavylift.nodes.devs import seconds
from heavylift.nodes.scene import LoadedScene, loaded
from heavylift.nodes.scene.text.units import DURATION

from .arguments import patterns, texts, time_s


def linearise(
    model: System | LoadedScene | str | Path,
    inputs: Sequence[str],
    outputs: Sequence[str] = ("joint/position/*",),
    at: float | str | None = None,
) -> LinearModel:
    """Return the linear model of a scene or system: matrices A, B, C, D, names and units of states, inputs and outputs.

    `inputs`: drives, winches, masters, and signals of forces; for a drive that prescribes its joint the input is the
    acceleration, for other drives the speed. `outputs`: columns of signals as `simulate` names them, or patterns. `at`:
    linearise at the equilibrium (default), at rest after a stage, or in motion at a time [s]. Raises HeavyliftError.
    """
    names = texts(inputs)
    if names is None:
        raise KernelError(f"inputs={inputs!r}: give names of drives, winches or signals")
    when = None if at is None or isinstance(at, str) else at and time_s("at", at, DURATION)
    if not isinstance(model, System):
        scene = loaded(model)
        there = paused(scene, when) if when is not None else at_rest(scene, None, str(at or ""))[1]
    else:
        if isinstance(at, str):
            raise KernelError(f"at={at!r}: a system has no stages; give a time [s], or omit `at` to linearise at rest")
        there = Simulation(model)
        there.start()
        if when is None:
            equilibrium(there)
        elif when:
            there.interrupt(seconds(when))
            there.settle()
    return linear_model(there, names, patterns(outputs))
