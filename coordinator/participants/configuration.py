"""The kernel's part of a plan, wherever it runs."""

from __future__ import annotations

from collections.abc import Iterable

from heavylift.kernel.description.mechanics import System
from heavylift.nodes.models import hooked_later, subscriptions
from heavylift.nodes.plan.plan import Plan

from .parts import KernelConfig

__all__ = ["kernel_config"]


def kernel_config(plan: Plan, systems: Iterable[System]) -> KernelConfig:
    """Of a plan and the mechanics that its models declare."""
    return KernelConfig(
        list(systems),
        plan.gravity,
        plan.tolerance,
        round(1e9 / plan.samples_hz),
        {element: list(models) for element, models in subscriptions(plan).items()},
        plan.method,
        plan.step,
        hooked_later(plan),
        plan.fidelity.islands == "apart",
        plan.tensions_only,
    )
