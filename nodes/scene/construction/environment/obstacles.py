"""Floor and obstacles of a scene as one machine: fixed boxes, and contacts of blocks with them.

If there is a floor or an obstacle, blocks also have contacts with each other.
"""

from collections.abc import Iterator
from itertools import combinations, product

from heavylift.kernel.constraints.contact.pairs import check_contact, gap
from heavylift.kernel.description.contacts import Ball, Box, Contact, Plane
from heavylift.kernel.description.mechanics import WORLD, Body, Joint, System, Vector, merge
from heavylift.kernel.errors import KernelError
from heavylift.kernel.simulation.impacts.unilateral import INSIDE
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.mechanism import OBSTACLES
from heavylift.nodes.scene.construction.scene_builder import SceneBuilder
from heavylift.nodes.scene.keys.base import turned
from heavylift.nodes.scene.keys.environment import Obstacle
from heavylift.nodes.scene.keys.parts import kinematics
from heavylift.nodes.scene.keys.parts.contacts import touches
from heavylift.nodes.scene.text.faults import closest

SIGNS = (-0.5, 0.5)
TOUCH = 1e-9  # [m]


def obstacles_machine(builder: SceneBuilder, around: System) -> plan.Mechanism:
    """Return all obstacles of a scene as one machine; errors are added to the scene."""
    scene, source = builder.scene, builder.source
    blocks = scene.all_blocks
    sizes = {name: block.size for name, block in blocks.items()}
    if not blocks:
        source.fault((OBSTACLES if scene.obstacles else "floor",), "there is no block that could meet it", on_key=True)
    if bends := next((name for name, block in blocks.items() if block.flexible), ""):
        message = f"'{bends}' bends, and only rigid blocks meet floor and obstacles: remove one of the two"
        source.fault((OBSTACLES if scene.obstacles else "floor",), message, on_key=True)
    taken = {*scene.machines, *scene.vessels, *scene.rigging, *blocks}
    for name, given in scene.obstacles.items():
        if name in taken:
            source.fault((OBSTACLES, name), f"the name '{name}' is given twice: a machine has it, too", on_key=True)
        if given.on != WORLD and given.on not in scene.vessels:
            message = f"there is no vessel '{given.on}'"
            source.fault((OBSTACLES, name, "on"), message, closest(given.on, [WORLD, *scene.vessels]))
    joints = (
        Joint(f"{name}.foot", "fixed", x.on, name, p_PJ=x.at, R_PJ=turned(*x.rotation))
        for name, x in scene.obstacles.items()
    )
    contacts = tuple(_contacts(builder, sizes))
    for contact in contacts:
        try:
            check_contact(contact)
        except KernelError as error:
            source.fault((OBSTACLES,), str(error), on_key=True)
    made = System(
        tuple(Body(name, 0.0) for name in scene.obstacles), tuple(joints), contacts=contacts, gravity=scene.gravity
    )
    shapes = tuple(
        plan.Shape(body=n, centre=(0.0, 0.0, 0.0), size=x.box, overlap=x.overlap, stiffness=x.stiffness)
        for n, x in scene.obstacles.items()
    )
    where = source.where((OBSTACLES,) if scene.obstacles else ("floor",))
    at = {} if source.faults else kinematics.poses(merge([around, made], scene.gravity))
    deepest: dict[tuple[str, str], float] = {}
    for contact in contacts if at else ():
        block, other = contact.a.body, contact.b.body
        deepest[block, other] = min(deepest.get((block, other), -INSIDE), gap(contact, at[block], at[other]))
    for (block, other), depth in deepest.items():
        if depth < -INSIDE:
            _overlaps(builder, block, other, -depth)
    closed = tuple(contact.name for contact in contacts if at and touches(contact, at, TOUCH))
    return plan.Mechanism(name=OBSTACLES, system=made, closed=closed, shapes=shapes, where=where)


def _overlaps(builder: SceneBuilder, block: str, other: str, depth: float) -> None:
    """Add an error if a block starts inside another object by the given depth [m]."""
    path: tuple[str, ...] = (OBSTACLES if other in builder.scene.obstacles else "blocks", other)
    path, of = (("floor",), "the floor") if other == WORLD else (path, f"'{other}'")
    builder.source.fault(path, f"'{block}' begins {depth:.3g} m inside of {of}: move them apart", on_key=True)


def _contacts(builder: SceneBuilder, sizes: dict[str, Vector]) -> Iterator[Contact]:
    """Yield the contacts of each block with obstacles, with the floor, and with the blocks after it."""
    floor = builder.scene.floor
    for block, size in sizes.items():
        for name, given in builder.scene.obstacles.items():
            yield from _with_obstacle(block, size, name, given)
        if floor:
            ground = Plane(WORLD, (0.0, 0.0, floor.height))
            yield Contact(f"{block}-floor", Box(block, size), ground, floor.friction, floor.restitution)
    for (one, size), (other, wide) in combinations(sizes.items(), 2):
        yield Contact(f"{one}-{other}", Box(one, size), Box(other, wide))


def _with_obstacle(block: str, size: Vector, name: str, x: Obstacle) -> Iterator[Contact]:
    """Yield the contacts of a block's box, or of its corners, with an obstacle."""
    other = Box(name, x.box)
    if x.meets == "boxes":
        yield Contact(f"{block}-{name}", Box(block, size), other, x.friction, x.restitution)
        return
    heights = SIGNS[: 1 if x.meets == "lower corners" else 2]
    for i, (c, b, a) in enumerate(product(heights, SIGNS, SIGNS), 1):
        corner = Ball(block, (a * size[0], b * size[1], c * size[2]))
        yield Contact(f"{block}-{name}-{i}", corner, other, x.friction, x.restitution)
