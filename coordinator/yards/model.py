"""A yard file as a DEVS model."""

from collections.abc import Sequence

from heavylift.nodes.devs import Coupled
from heavylift.nodes.yard.models import coupled
from heavylift.nodes.yard.network import Yard
from heavylift.nodes.yard.reading import load

from .lifting import in_place, lifter


def load_yard(file: str, settings: Sequence[str] = ()) -> Yard:
    """Read a yard file with settings, and the scenes of its lifts; raises SceneError with all faults of the file."""
    return load(file, settings, lifter)


def yard(file: str, settings: Sequence[str] = (), seed: int = 0) -> Coupled:
    """Return the DEVS model of a yard file with settings applied; raises SceneError for an invalid file."""
    return coupled(load_yard(file, settings), seed, "", in_place)
