"""Names of rigging entries: their ropes, and the lugs of blocks to which they are hooked."""

from __future__ import annotations

from typing import NamedTuple

from heavylift.kernel.description import mechanics as k
from heavylift.nodes.limits.slings import Terms, at_rest
from heavylift.nodes.scene.keys.parts.rigging import Frame, SlingKeys, SlingType
from heavylift.nodes.scene.keys.schema import Scene


class Sling(NamedTuple):
    """A rope of a rigging entry: number of its sling, lower attachment, whether hooked at the start. A sling that is
    hooked elsewhere later becomes another rope, such as `legs.sling-1.B-N1`."""

    number: int
    holds: str
    hooked: bool = True


def slings_of(scene: Scene, name: str) -> dict[str, Sling]:
    """Return the ropes of a rigging entry, by name; none for a frame."""
    given = scene.rigging[name]
    if isinstance(given, Frame):
        return {}
    names = [f"{name}.sling-{i + 1}" for i in range(len(given.to) if isinstance(given, SlingKeys) else 1)]
    found = {sling: Sling(i, given.to[i]) for i, sling in enumerate(names)}
    for action in scene.actions if isinstance(given, SlingKeys) else ():
        for target, phrase in action.orders.items():
            asked = names if target == name else [target] if target in names else []
            for sling, lug in zip(asked, phrase.lugs, strict=False):
                if lug != found[sling].holds:
                    found[f"{sling}.{lug.replace('.', '-')}"] = Sling(found[sling].number, lug, hooked=False)
    return found


def key_of(lug: str, at: k.Point) -> str:
    """Return the key of a lug in the plan: `N1` with one block, `B.N1` with several."""
    return lug if at.body == "block" or "." in lug else f"{at.body}.{lug}"


def lugs_of(scene: Scene) -> dict[str, k.Point]:
    """Return the lugs of all blocks by name: `N1` if unique, and `B.N1`."""
    blocks = scene.all_blocks
    named = [lug for block in blocks.values() for lug in block.lugs]
    found = {lug: k.Point(name, p) for name, x in blocks.items() for lug, p in x.lugs.items() if named.count(lug) == 1}
    return found | {f"{name}.{lug}": k.Point(name, p) for name, x in scene.blocks.items() for lug, p in x.lugs.items()}


def terms(given: SlingType, item: str = "") -> Terms:
    """Return the known properties of a sling, with or without a gear item."""
    chosen, single = "breaking" in given.model_fields_set, given.legs == "single"
    return Terms(
        given.breaking, given.WLL, item, given.termination, given.diameter, given.pin, given.wear, chosen, single
    )


def rated(given: SlingType, gravity: float) -> float:
    """Return the rated load of a sling, at 100 % utilisation [N]."""
    own = "factor" in given.model_fields_set
    return given.breaking / (given.factor if own else at_rest(terms(given), gravity).factor)
