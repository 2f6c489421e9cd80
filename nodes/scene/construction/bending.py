"""The keys `beam` and `modes` of a block: what makes it flexible, in the plan.

As a beam it bends from end to end along its x, and its frame is the mean of it; modes of a table stand at its lugs and
pads.  The displacements of all lugs within it are sampled, and of a beam those of its ends and its middle.
"""

from __future__ import annotations

from collections.abc import Iterator

from heavylift.kernel.description.flexible import Beam, Flexible, Gauge, Modal
from heavylift.kernel.description.flexible_checks import check_flexible
from heavylift.kernel.description.points import Vector
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.checks import check_inertia
from heavylift.nodes.models.parts.bending import block_body
from heavylift.nodes.plan import plan
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.keys.parts.flexible import Hull
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path

from .yard import Yard

__all__ = ["flexible_of"]

SAME = 1e-9  # relative, of masses that are equal


def flexible_of(
    yard: Yard, block: schema.Block, body: plan.Inertia, pads: list[plan.Pad], base: Path
) -> Flexible | None:
    """What bends of a block with its mass properties and pads, if anything does; what is wrong is a fault."""
    if block.beam is None and not block.modes:
        return None
    key: Path = (*base, "beam" if block.beam else "modes")
    if block.beam and block.modes:
        yard.source.fault((*base, "modes"), "a flexible block has either a 'beam' or 'modes'", on_key=True)
        return None
    made = _beam(yard, block, block.beam, body, key) if block.beam else _modes(yard, block, pads, base)
    if made is None:
        return None
    try:
        check_flexible(str(base[-1]), made)
        check_inertia(block_body(str(base[-1]), body, made))
    except KernelError as error:
        told = "; give the beam a 'mass', that of what bends with it, or the block its 'inertia'" if made.beam else ""
        yard.source.fault(key, f"{error}{told}", on_key=True)
    return made


def _beam(yard: Yard, block: schema.Block, hull: Hull, body: plan.Inertia, key: Path) -> Flexible | None:
    length, bends = block.size[0], hull.mass or block.mass
    if bends > block.mass * (1.0 + SAME):
        told = f"the block has {block.mass / 1e3:g} t, of which no {bends / 1e3:g} t can bend"
        yard.source.fault((*key, "mass"), told)
        return None
    if any(block.com) and bends > block.mass * (1.0 - SAME):
        told = "the mass of a uniform beam is not aside, as 'com' says: give the beam a 'mass', less than the block's"
        yard.source.fault(key, told, on_key=True)
        return None
    polar = body.moments[0] / length * (bends / block.mass)
    beam = Beam(length, bends / length, *hull.stiffness, polar, hull.elements, start=-length / 2)
    along = {"end-1": -length / 2, "middle": 0.0, "end-2": length / 2}
    for lug, p in block.lugs.items():
        if abs(p[0]) > length / 2:
            told = f"the lug stands {p[0]:g} m along a beam that ends at {length / 2:g} m"
            yard.source.fault((*key[:-1], "lugs", lug), told)
    gauges = (*_gauges(block.lugs), *(Gauge(name, (x, 0.0, 0.0)) for name, x in along.items()))
    return Flexible(hull.modes, beam, frame="free", damping=hull.damping, loads=tuple(hull.loads), gauges=gauges)


def _modes(yard: Yard, block: schema.Block, pads: list[plan.Pad], base: Path) -> Flexible | None:
    places = {**block.lugs, **{pad.support.name.partition(".")[2]: pad.support.point.p for pad in pads}}
    named = dict.fromkeys(word for mode in block.modes.values() for word in mode.shape)
    for name, mode in block.modes.items():
        for word in (word for word in mode.shape if word not in places):
            path = (*base, "modes", name, "shape", word)
            yard.source.fault(path, f"the block has no lug or stool '{word}'", closest(word, places), on_key=True)
    if any(word not in places for word in named):
        return None
    modes = block.modes.values()
    still = (0.0, 0.0, 0.0)
    modal = Modal(
        tuple(places[word] for word in named),
        tuple(tuple(mode.shape.get(word, still) for word in named) for mode in modes),
        tuple(mode.frequency for mode in modes),
        tuple(mode.mass for mode in modes),
        tuple(mode.damping for mode in modes),
    )
    return Flexible(len(block.modes), modal=modal, gauges=tuple(_gauges({word: places[word] for word in named})))


def _gauges(places: dict[str, Vector]) -> Iterator[Gauge]:
    return (Gauge(name, p) for name, p in places.items())
