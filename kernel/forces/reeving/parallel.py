"""Edges of several bodies: one rope bends over them where nothing can turn them out of parallel.

Between the bodies there are joints that slide, or turn about the direction of the edges, which they then keep.
"""

from __future__ import annotations

import numpy as np
from heavylift.kernel.algebra.dense import cross, norm
from heavylift.kernel.compiler.symbol import Array
from heavylift.kernel.description.forces import Reeving
from heavylift.kernel.description.joint_table import JOINTS
from heavylift.kernel.description.mechanics import WORLD
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.force_law import Poses
from heavylift.kernel.multibody.graph import Graph, Link
from heavylift.kernel.multibody.motion import axes_of

ALONG = 1e-9  # sine between the direction of edges and an axis that turns a body of theirs


def check_parallel(f: Reeving, graph: Graph, poses: Poses) -> None:
    """Raises KernelError where edges of a rope are on bodies of which one can turn them out of parallel."""
    bodies = list(dict.fromkeys(s.at.body for s in f.edges))
    if len(bodies) < 2:
        return
    n = poses(bodies[0])[0] @ np.array(f.edges[0].axis)
    paths = [_path(graph, body) for body in bodies]
    shared = set.intersection(*map(set, paths))
    for body, path in zip(bodies, paths, strict=True):
        own = [i for i in path if i not in shared]
        bends = [graph.links[i] for i in (*own, *([max(shared)] if shared else [])) if graph.links[i].modes]
        loose = [link for link in map(graph.links.__getitem__, own) if _turns(link, poses, n)]
        if bends or loose:
            what = f"what bends of '{bends[0].body.name}'" if bends else f"the joint '{loose[0].joint.name}'"
            told = f"its edges are on several bodies, and {what} can turn the one on '{body}' out of parallel"
            raise KernelError(f"reeving '{f.name}': {told}; name edges of one body")


def _path(graph: Graph, body: str) -> list[int]:
    """The links from a body to the ground."""
    i = -1 if body == WORLD else graph.number(body)
    found = []
    while i >= 0:
        found.append(i)
        i = graph.links[i].parent
    return found


def _turns(link: Link, poses: Poses, n: Array) -> bool:
    """Whether a joint turns its child about anything but n."""
    joint = link.joint
    kind = JOINTS[joint.kind]
    if kind.quaternion is not None:
        return True
    frame = poses(joint.parent)[0] @ np.array(joint.R_PJ)
    axes = [(frame @ axes_of(joint)[m.axis]).tolist() for m in kind.motions if m.turns]
    return any(norm(cross(n.tolist(), a)) > ALONG for a in axes)
