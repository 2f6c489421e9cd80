"""What the entries of a rigging are called: their ropes, and the lugs of blocks that they hold."""

from __future__ import annotations

from typing import NamedTuple

from heavylift.kernel.description import mechanics as k
from heavylift.nodes.limits.slings import Terms, at_rest
from heavylift.nodes.scene.keys.parts.rigging import Frame, SlingKeys, SlingType
from heavylift.nodes.scene.keys.schema import Scene


class Sling(NamedTuple):
    """A rope of an entry: number of its sling, what it holds, whether it does at the start.

    A sling that is hooked elsewhere later is another rope, `legs.sling-1.B-N1`, which hangs there only then.
    """

    number: int
    holds: str
    hooked: bool = True


def slings_of(scene: Scene, name: str) -> dict[str, Sling]:
    """The ropes of an entry, by name; none of a frame."""
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
    """How a plan calls a lug, by a word for it and its place: of one block `N1`, of several `B.N1`."""
    return lug if at.body == "block" or "." in lug else f"{at.body}.{lug}"


def lugs_of(scene: Scene) -> dict[str, k.Point]:
    """The lugs of all blocks by the words for them: `N1` where one block has it, and `B.N1`."""
    blocks = scene.all_blocks
    named = [lug for block in blocks.values() for lug in block.lugs]
    found = {lug: k.Point(name, p) for name, x in blocks.items() for lug, p in x.lugs.items() if named.count(lug) == 1}
    return found | {f"{name}.{lug}": k.Point(name, p) for name, x in scene.blocks.items() for lug, p in x.lugs.items()}


def terms(given: SlingType, item: str = "") -> Terms:
    """What is known of a sling, an item of gear or none."""
    chosen, single = "breaking" in given.model_fields_set, given.legs == "single"
    return Terms(
        given.breaking, given.WLL, item, given.termination, given.diameter, given.pin, given.wear, chosen, single
    )


def rated(given: SlingType, gravity: float) -> float:
    """What counts as 100 % of the use of a sling [N]."""
    own = "factor" in given.model_fields_set
    return given.breaking / (given.factor if own else at_rest(terms(given), gravity).factor)
