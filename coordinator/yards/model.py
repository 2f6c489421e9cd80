"""A yard file as a model to be run."""

from collections.abc import Sequence

from heavylift.nodes.devs import Coupled
from heavylift.nodes.yard.models import coupled
from heavylift.nodes.yard.network import Yard
from heavylift.nodes.yard.reading import load

from .lifting import in_place, lifter


def load_yard(file: str, settings: Sequence[str] = ()) -> Yard:
    """Read a yard file with settings, and its lifts; raises SceneError with all its faults."""
    return load(file, settings, lifter)


def yard(file: str, settings: Sequence[str] = (), seed: int = 0) -> Coupled:
    """The model of a yard file with settings laid over it; raises SceneError for an invalid one."""
    return coupled(load_yard(file, settings), seed, "", in_place)
