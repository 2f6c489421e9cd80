"""What processes would cost a scene: forces held between them, and its nodes in processes of their own."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from heavylift.kernel.errors import SceneError
from heavylift.nodes.fidelity.case import case_of

from .distributed import distributed
from .held import EXCHANGES, held, hook_pairs

if TYPE_CHECKING:
    from heavylift.nodes.scene import LoadedScene

    from .measuring import Measured

__all__ = ["communicating", "hanging"]


def hanging(scene: LoadedScene) -> None:
    """SceneError for a scene without hook ropes, whose ends no two processes could share."""
    if scene.followed is None or case_of(scene.plan, scene.followed) is None:
        raise SceneError(f"--coupling: nothing hangs on a hook rope in {scene.path.name}; leave the option out")


def communicating(scene: LoadedScene, measured: Measured) -> Measured:
    """The measured scene with the communication side measured as well."""
    hanging(scene)
    assert scene.followed is not None
    case = case_of(scene.plan, scene.followed)
    assert case is not None
    lasts = measured.true.simulated_s
    found = [held(pair, h, lasts) for pair in hook_pairs(scene.plan, case) for h in EXCHANGES]
    return replace(measured, held=found, distributed=distributed(scene))
