"""Decision whether a scene is simulated as one system or as islands."""

from collections.abc import Collection, Mapping
from typing import Any

from heavylift.kernel.description.mechanics import System
from heavylift.kernel.model.checks import check_description
from heavylift.kernel.simulation.simulation import Simulation

from .components import islands_of, loose_ropes
from .islands import Islands


def simulate(
    system: System,
    tolerance: float,
    sample_ns: int,
    subscribed: frozenset[str],
    method: str,
    step: float | None,
    ties: Collection[str] = (),
    apart: bool = True,
    lifts: Mapping[str, Collection[str]] | None = None,
) -> Simulation | Islands:
    """Return the simulation of a scene: one system, or separate islands if `apart` and the scene has several.

    `ties`: ropes that are unhooked now but will be hooked later and therefore couple their bodies; `lifts`: bodies of
    each lift, by name, whose events get rows of their own; the other arguments are those of `Simulation`.
    """
    options: dict[str, Any] = {"method": method, "step": step}
    system = check_description(system)
    if apart and len(islands_of(system, loose_ropes(system, ties))) > 1:
        return Islands(system, tolerance, sample_ns, subscribed, ties, lifts, **options)
    return Simulation(system, tolerance, sample_ns, subscribed, **options)
