"""Former spellings that are still valid in scenes and recordings, with the constants needed here."""

from collections.abc import Iterator
from typing import Any, Literal

BEAMS = "loaders"
"""Key of the lifting frames under `rig:`; also the recorded fact that lists machines hung on hooks, by hook rope."""

BEAM = "loader"
"""Kind of a lifting frame in the names that users type, and prefix of the names of new frames."""

BEAM_TYPE = f"block-{BEAM}"
"""Type of a lifting frame for which the scene names no type."""

BeamLoad = Literal["loader load"]
BEAM_LOAD: BeamLoad = "loader load"
"""Quantity of the limit for the total load of a frame's slings."""

CALLED = {"gantry": "", "upper-slide": "upper trolley", "lower-slide": "lower trolley"}
"""Names that planners use for the moved part, by joint; the machine's name precedes them."""

FAMILY = "goliath"
BASE = f"{FAMILY}-900"


GIRDERS = "girders"
"""Former section for flexible girders; its entries, and the keys OPTIONAL of prescribed drives and of ropes, are now
under `elastic`."""

OPTIONAL = {"drives": ("stiffness", "damping"), "ropes": ("mass per length", "mass_per_length")}


def old_parts(parts: dict[str, Any]) -> Iterator[tuple[tuple[str, ...], tuple[str, ...]]]:
    """Yield the former and the present path of each machine part that scenes now list under `elastic`."""
    sections = {key: x for key in (GIRDERS, *OPTIONAL) if isinstance(x := parts.get(key), dict)}
    for name in sections.pop(GIRDERS, {}):
        yield (GIRDERS, name), ("elastic", name)
    for section, entries in sections.items():
        for name, given in entries.items():
            if isinstance(given, dict) and (section == "ropes" or given.get("type") == "prescribed"):
                yield from (((section, name, key), ("elastic", name, key)) for key in OPTIONAL[section] if key in given)


def old_type(data: dict[str, Any]) -> bool:
    """Convert a crane type of the former family `goliath` in place; return whether the data were of this family.

    The type then extends the smallest type of that family.
    """
    if data.get("family") != FAMILY:
        return False
    del data["family"]
    data["extends"] = BASE
    data.pop("drives", None)
    return True


def driven(actuator: str) -> str:
    """Return what an actuator moves, as reports name it, such as the upper trolley of a crane; else the actuator."""
    crane, called = called_of(actuator)
    return f"the {called} of {crane}" if called else crane


def called_of(actuator: str) -> tuple[str, str]:
    """Return the machine and the part that an actuator moves, as reports name them; otherwise the actuator and ""."""
    name = actuator.removesuffix(".drive")
    crane, _, axis = name.rpartition(".")
    return (crane, CALLED[axis]) if name != actuator and axis in CALLED else (actuator, "")
