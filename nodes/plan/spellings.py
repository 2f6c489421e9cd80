"""Words of scenes and rows that stay as they have always been spelled, by what they are called here."""

from __future__ import annotations

from typing import Literal

RAILS = "goliath"
"""Family of machine types whose cranes travel on rails with two trolleys, and beginning of the names of the bundled."""

BEAMS = "loaders"
"""Key of the lifting beams under `rig:`."""

BEAM = "loader"
"""Kind by which a recorded model of a lifting beam is asked for, and beginning of the names of new ones."""

BEAM_TYPE = f"block-{BEAM}"
"""Type of a lifting beam that names none."""

BeamLoad = Literal["loader load"]
BEAM_LOAD: BeamLoad = "loader load"
"""Quantity of the limit of what the slings of a beam pull."""
