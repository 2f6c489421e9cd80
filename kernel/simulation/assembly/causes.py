"""Why loops cannot be kept: contradictory drives, masses too far apart, or a linkage at the end of its range."""

from __future__ import annotations

from collections.abc import Sequence

from heavylift.kernel.model.program import Program
from heavylift.kernel.multibody.trees import Tree

__all__ = ["cause", "torn"]

APART = 1e8  # ratio of masses in a loop beyond which its rows are lost in rounding
END = "the linkage has reached the end of its range, or a drive asks for what it cannot do"


def cause(program: Program, row: int, moving: Sequence[str]) -> str:
    """As part of a sentence; row: of what was lost; moving: names of prescribed drives in motion."""
    trees = _tied(program, row)
    bodies = [b for tree in trees for b in tree.bodies]
    dofs = {k for tree in trees for k in range(tree.v.start, tree.v.stop)}
    own = [d for d in program.system.drives if d.name in moving and program.driven(d)[1] in dofs]
    if len(own) > 1:
        names = " and ".join(f"'{d.name}'" for d in own)
        return f"drives {names} move what one loop ties together and contradict each other; stop one or make it a servo"
    masses = sorted((float(b.mass), b.name) for b in bodies if float(b.mass) > 0.0)
    if masses and masses[-1][0] > APART * masses[0][0]:
        (light, name), (heavy, other) = masses[0], masses[-1]
        return (
            f"body '{name}' with {light:.3g} kg is tied into a loop with '{other}' of {heavy:.3g} kg, too far apart "
            "for the loop to be kept; make it heavier, or leave it out"
        )
    return END


def torn(program: Program, rope: str, movable: bool, moving: Sequence[str]) -> str:
    """Why states of a rigid rope switch without end, as part of a sentence, or ""."""
    if not moving:
        return ""
    names = " and ".join(f"'{name}'" for name in moving)
    drives = f"drives {names} move" if len(moving) > 1 else f"drive {names} moves"
    held = "what it holds" if movable else "all that it could move"
    cure = f"stop the drive before, make it a servo, or give '{rope}' EA"
    return f"{drives} {held}, and a rigid rope does not stretch; {cure}"


def _tied(program: Program, row: int) -> list[Tree]:
    """Trees that the loops of a row's group tie together, driven ones too."""
    rows = next((rows for rows, _ in program.constraints.groups if row in rows), [row])
    ends = {body for r in rows for body in program.constraints.held[r]}
    return [tree for tree, _ in program.instances if ends & set(range(tree.first, tree.first + len(tree.bodies)))]
