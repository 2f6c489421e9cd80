"""Intended contacts of a scene: the pairs under `may touch`, for all stages or one, and landings that actions order.

A name in a pair is that of a body, of a machine with all of its parts, of a rope or sling, or of a rigging entry;
`ground` or `floor` is the ground below everything.
"""

from collections.abc import Iterator, Sequence

from heavylift.kernel.description.units import WORLD
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.actions import Touch
from heavylift.nodes.plan.shapes import Shapes
from heavylift.nodes.scene.construction.scene_builder import SceneBuilder
from heavylift.nodes.scene.keys.actions import ActionLine
from heavylift.nodes.scene.language.phrases import GroundTest
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path, SourceText


def touches(source: SourceText, path: Path, pairs: Sequence[tuple[str, str]]) -> Iterator[Touch]:
    """Yield the pairs of objects listed under `may touch` in a scene or in one of its actions."""
    for i, (a, b) in enumerate(pairs):
        yield Touch(names=(_ground(a), _ground(b)), where=source.where((*path, "may touch", i)))


def landings(builder: SceneBuilder, path: Path, action: ActionLine) -> Iterator[Touch]:
    """Yield the contacts that an action intends by landing a block on objects other than its supports."""
    blocks, waits = [*builder.scene.all_blocks], [action.when, *(phrase.until for phrase in action.orders.values())]
    for test in (test for wait in waits for test in wait or ()):
        if isinstance(test, GroundTest) and test.on and (block := test.of or "".join(blocks[:1])):
            yield Touch(names=(block, _ground(test.on)), stays=True, where=builder.source.where(path))


def check_touches(source: SourceText, built: plan.Plan) -> None:
    """Add an error for each name under `may touch` that does not exist."""
    pairs = [*built.may_touch, *(touch for action in built.actions for touch in action.may_touch if not touch.stays)]
    shapes = Shapes(built)
    called = [shapes.called(x) for some in (shapes.solids, shapes.strands.values()) for x in some] if pairs else []
    known = {WORLD, "ground"}.union(*called)
    for where, name in [(x.where, name) for x in pairs for name in x.names if name not in known]:
        message = f"there is no '{name}' that could touch anything"
        source.fault(source.path_of(where), message, closest(name, sorted(known - {WORLD})))


def _ground(name: str) -> str:
    return WORLD if name in ("ground", "floor") else name
