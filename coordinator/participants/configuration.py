"""The kernel's part of a plan, wherever it runs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from heavylift.kernel.description.mechanics import System
from heavylift.nodes.models import NodeModel, hooked_later, subscriptions
from heavylift.nodes.plan.plan import Plan

from .parts import KernelConfig

__all__ = ["kernel_config"]


def kernel_config(plan: Plan, models: Mapping[str, NodeModel], systems: Iterable[System]) -> KernelConfig:
    """Of a plan, its models and the mechanics that they declare."""
    return KernelConfig(
        list(systems),
        plan.gravity,
        plan.tolerance,
        round(1e9 / plan.samples_hz),
        {element: list(hearing) for element, hearing in subscriptions(plan, models).items()},
        plan.method,
        plan.step,
        hooked_later(plan),
        plan.fidelity.islands == "apart",
        plan.tensions_only,
    )
