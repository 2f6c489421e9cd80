"""The two-crane scene with its loaders pinned to the block as loops, 36 rows of rank 30, against the same scene as a
tree of 24 degrees of freedom."""

from dataclasses import replace

import numpy as np
from goliath import scene
from heavylift.kernel.describe import WORLD, Joint, System
from small_scenes import SECOND, column, started

AGREES = 1e-8  # of a tension
BLOCK, SPIN, DRIFT = np.array([0.0, 0.0, 20.0]), (0.010, -0.015, 0.020), (0.4, 0.3, 0.0)


def is_loader(name: str, part: str) -> bool:
    return name.startswith(part) and name.removeprefix(part).isdigit()


def pinned(tree: System) -> System:
    """Loaders that float as trees of their own, each held at the block's lugs by two balls on its hinge's axis."""
    joints = []
    place = {j.child: np.array(j.p_PJ) for j in tree.joints}
    for j in tree.joints:
        if is_loader(j.child, "low"):
            x, y, z = j.p_PJ
            for side, dx in (("left", -0.5), ("right", 0.5)):
                pin = Joint(f"{j.child}-{side}", "spherical", "block", j.child, (x + dx, y, z), p_CJ=(dx, 0.0, 0.0))
                joints.append(pin)
        elif is_loader(j.child, "up"):
            at = place[j.parent] + [0.0, 0.0, 1.0]
            v = np.array(DRIFT) + np.cross(SPIN, at)
            start = (*(BLOCK + at), 0.0, 0.0, 0.0, 1.0)
            joints.append(Joint(f"{j.child}-floats", "free", WORLD, j.child, q0=start, v0=(*v, *SPIN)))
            joints.append(Joint(j.name, j.kind, j.child, j.parent, axis=j.axis, p_CJ=(0.0, 0.0, 1.0)))
        else:
            joints.append(j)
    return replace(tree, joints=tuple(joints))


def test_thirty_six_redundant_rows_carry_what_the_tree_carries():
    whole = scene()
    tree = replace(
        whole, springs=tuple(x for x in whole.springs if not is_loader(x.joint.removesuffix("-joint"), "low"))
    )
    tensions = []
    for system in (tree, pinned(tree)):
        s = started(system, tolerance=1e-10, sample_ns=SECOND // 10)
        s.run(SECOND)
        tensions.append(column(s, "rope/tension")[1][:10])
    assert len(s.program.constraints) == 36
    assert np.isfinite(tensions[1]).all()
    assert np.abs(tensions[1] / tensions[0] - 1.0).max() < AGREES
