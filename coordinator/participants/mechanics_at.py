"""The mechanics of a scene at one instant of its run, found by running the models in this process without a recording.

It is used by analyses of a pose rather than of a run, such as statics and modes. The caller owns the returned
simulation.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
from heavylift.kernel.analysis.equilibrium import Equilibrium, equilibrium
from heavylift.kernel.analysis.path import EquilibriumPath
from heavylift.kernel.errors import SceneError
from heavylift.kernel.methods.choice import choose, control_of
from heavylift.kernel.model.program import Program
from heavylift.kernel.simulation.simulation import Simulation
from heavylift.nodes.devs import Event, Tag, seconds
from heavylift.nodes.models import COMMANDER, build, system
from heavylift.nodes.models.parts.messages import Finished, Stage
from heavylift.nodes.statics.static_run import StaticRun

from .kernel_node import KernelNode
from .parts import KernelConfig
from .rows import RowSink
from .session import Session, configured

if TYPE_CHECKING:
    from heavylift.nodes.scene import LoadedScene

LAST = Tag(100 * 3600 * 10**9)  # simulated time after which a stage that has not ended never does


class _Ended(Exception):
    """Ends a run when the awaited stage is over."""


class _Stages:
    """Listens to the commander and raises _Ended when the stage `wanted` is over."""

    def __init__(self, wanted: str) -> None:
        self.wanted, self.seen, self.t = wanted, list[str](), 0

    def __call__(self, event: Event) -> None:
        if event.source != COMMANDER:
            return
        begins = event.value.name if isinstance(event.value, Stage) else ""
        if (begins or isinstance(event.value, Finished)) and self.wanted in self.seen:
            self.t = event.t
            raise _Ended
        if begins:
            self.seen.append(begins)


def at_rest(scene: LoadedScene, at: float | None, after: str) -> tuple[Equilibrium, Simulation]:
    """Return an equilibrium of a scene, after a stage or found from the pose of a run at time `at` [s], and its
    simulation."""
    if at is None:
        path = resting(scene, after)
        return path.rest(), path.command
    simulation = paused(scene, at, after)
    return equilibrium(simulation), simulation


def check_steps(scene: LoadedScene) -> None:
    """Raise HeavyliftError if the integration method or the fixed step of a scene cannot be used for its mechanics.

    The stability of a fixed step is checked by starting the simulation with the same compiled code as the run.
    """
    plan = scene.plan
    if plan.step is not None:
        paused(scene)
    else:
        program = Program(system(plan))
        control_of(choose(plan.method, program), None, program)


def resting(scene: LoadedScene, after: str = "") -> EquilibriumPath:
    """Return the equilibrium path of a scene up to the end of stage `after`; only its first point if `after` is ""."""
    rehearsal = StaticRun(scene.plan, after)
    if not after:
        rehearsal.path.start()
        return rehearsal.path
    rehearsal.walk()
    if after not in rehearsal.stages or not (rehearsal.over or rehearsal.ended):
        message = rehearsal.why or "it is not over when the scene ends"
        if after not in [action.stage for action in scene.plan.actions]:
            message = "there is no such stage"
        names = [action.stage for action in scene.plan.actions if action.stage]
        raise SceneError(f"--after '{after}': {message}; stages are {', '.join(names) or 'none'}")
    return rehearsal.path


def paused(scene: LoadedScene | str | Path, at: float | None = None, after: str = "") -> Simulation:
    """Run a scene up to time `at` [s] or to the end of stage `after`, by default only to its start, and return its
    simulation.

    Raises SceneError if there is no such stage, or the error that ended the run earlier.
    """
    from heavylift.nodes.scene import loaded  # validators, which processes of nodes do without

    plan = loaded(scene).plan
    if at is not None and not 0.0 <= at < LAST.t * 1e-9:
        raise SceneError(f"--at {at:g} s: the time must lie between 0 and {LAST.t * 1e-9:g} s")
    if at is None and not after:
        simulation = _InOnePiece(configured(plan, build(plan))).whole
        simulation.start()
        return simulation
    stages = _Stages(after)
    end = Tag(seconds(at) + 1) if at is not None else LAST if plan.end is None else Tag(seconds(plan.end))
    session = Session(plan, _InOnePiece, stages, end)
    simulation = session.kernel.whole
    try:
        session.advance()
    except _Ended:
        simulation.interrupt(stages.t)
    else:
        if at is None:
            message = f"it is not over within {end.t * 1e-9:g} s" if after in stages.seen else "there is no such stage"
            raise SceneError(f"--after '{after}': {message}; stages are {', '.join(stages.seen) or 'none'}")
        simulation.interrupt(seconds(at))
    simulation.settle()
    return simulation


class _InOnePiece(KernelNode):
    """A kernel without islands, whose samples are discarded."""

    def __init__(self, config: KernelConfig) -> None:
        super().__init__(msgspec.structs.replace(config, apart=False), RowSink())
        assert isinstance(self.simulation, Simulation)
        self.whole = self.simulation
