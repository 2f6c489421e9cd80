"""Facts about a scene that its recording holds from the start; the energy balance of a run.

Kinetic + potential + stored - work + heat must stay at its initial value. Works and heats of all elements are
integrated from their own powers by the kernel, so a law whose power is not counted shows up here as an error.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import msgspec
import numpy as np
from heavylift.coordinator.transport.placement import Placement
from heavylift.nodes.limits.named import rated
from heavylift.nodes.models.levels.listing import left_out
from heavylift.nodes.plan.plan import Plan
from heavylift.recordings import SampleLayout
from heavylift.recordings.format.spellings import BEAMS

if TYPE_CHECKING:
    from heavylift.nodes.scene import LoadedScene


def facts_of(scene: "LoadedScene", nodes: Sequence[str], placement: Placement) -> dict[str, object]:
    """Return the metadata of a scene for its recording, such as settings, model level, nodes and supports."""
    plan, asked = scene.plan, scene.facts.ask
    return {
        "scene": plan.name,
        "seed": plan.seed,
        **({"project": scene.facts.project} if scene.facts.project else {}),
        **({"asked": ", ".join(asked), "accuracy": f"{100 * scene.facts.accuracy:.6g} %"} if asked else {}),
        "modelled": f"left out: {', '.join(out)}" if (out := left_out(plan)) else "as it is written",
        "errors": scene.errors,
        "tolerance": f"{plan.tolerance:.6g}",
        "method": plan.method,
        **({"step": f"{plan.step:.6g} s"} if plan.step else {}),
        "samples_hz": plan.samples_hz,
        "fidelity": {key: getattr(plan.fidelity, key) for key in plan.fidelity.__struct_fields__ if key != "where"},
        **({"answer": msgspec.to_builtins(scene.answer) | {"told": str(scene.answer)}} if scene.answer else {}),
        "nodes": nodes,
        "placement": {process: list(nodes) for process, nodes in placement.processes.items()},
        "rated": rated(plan),
        "tandem": scene.facts.tandem,
        "supports": supports(plan),
        BEAMS: hanging(plan),
    }


def supports(plan: Plan) -> list[dict[str, object]]:
    """Return for each support: name, supported body, point in its frame, height of the pad [m], and the body below."""
    found = [support for machine in plan.machines for support in machine.system.supports]
    return [{"name": s.name, "body": s.point.body, "p": s.point.p, "height": s.height, "on": s.on} for s in found]


def hanging(plan: Plan) -> dict[str, str]:
    """Return the machines that are suspended from the hook of another machine, each with the rope of that hook."""
    owners = {body.name: machine.name for machine in plan.machines for body in machine.system.bodies}
    hooks = [(machine.name, hook) for machine in plan.machines for hook in machine.hooks]
    on = {owners[hook.eye.body]: hook.rope for name, hook in hooks if owners.get(hook.eye.body, name) != name}
    return {machine.name: on[machine.name] for machine in plan.machines if machine.name in on}


class EnergyAudit:
    """Energy balance of a run: largest imbalance [J] and the sum of work, heat and kinetic energy [J] as its scale."""

    def __init__(self, layout: SampleLayout) -> None:
        self._energy, self._accounts = layout.find("energy"), layout.find("account")
        names = self._accounts.names if self._accounts else []
        self._works = [i for i, n in enumerate(names) if n.endswith(".work")]
        self._start: float | None = None
        self._last_works: np.ndarray | None = None
        self._heat = 0.0
        self._moved = 0.0
        self._slow, self._fast = np.inf, -np.inf  # least and largest kinetic energy
        self.imbalance = 0.0

    def add(self, rows: np.ndarray) -> None:
        """Add samples (n, columns) in order of time."""
        if self._energy is None:
            return
        kinetic, potential, stored, work, heat = rows[:, self._energy.start : self._energy.stop].T
        total = kinetic + potential + stored - work + heat
        if self._start is None:
            self._start = float(total[0])
        self.imbalance = max(self.imbalance, float(np.abs(total - self._start).max()))
        self._heat = abs(float(heat[-1]))  # less than nothing only where the steps are wrong
        self._slow, self._fast = min(self._slow, float(kinetic.min())), max(self._fast, float(kinetic.max()))
        if self._accounts is not None and self._works:
            works = rows[:, [self._accounts.start + i for i in self._works]]
            before = works[:1] if self._last_works is None else self._last_works[None]
            steps = np.abs(np.diff(np.vstack([before, works]), axis=0)).sum(axis=1)
            self._moved = float(np.cumsum([self._moved, *steps])[-1])  # in order, whatever the batches
            self._last_works = works[-1]

    @property
    def turned_over(self) -> float:
        return self._moved + self._heat + max(0.0, self._fast - self._slow)

    @property
    def error(self) -> float:
        """Relative energy error: the largest imbalance divided by the sum of work, heat and kinetic energy."""
        return self.imbalance / self.turned_over if self.turned_over else 0.0
