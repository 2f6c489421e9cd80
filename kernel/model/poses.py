"""The first stages of an evaluation: what drives and winches follow, and where all bodies are and how they move.

Prescribed joints follow commanded masters only, so that places are known before anything is measured; servos and
winches may follow measured ones as well.  A reference is a profile plus f(s) = k1 s + kc cos s + ks sin s of masters.
"""

from operator import add
from types import SimpleNamespace

import numpy as np
from heavylift.kernel.algebra.elementary import atan2, cos, sin
from heavylift.kernel.algebra.spatial import cross
from heavylift.kernel.compiler.symbol import Array, Scalar, named, sqrt
from heavylift.kernel.forces.force_law import Poses
from heavylift.kernel.multibody.continuous_angles import on_turn

from .instant import Evaluation
from .program import Program


def command_masters(x: Evaluation) -> None:
    """Masters by their profiles."""
    for m in x.program.system.masters:
        value, rate, acceleration = x.own(m.name)
        s = named(f"s({m.name})", value)
        rates = named(f"ds({m.name})", rate), named(f"dds({m.name})", acceleration)
        x.masters.append((s, *rates, sin(s), cos(s)))


def prescribe_joints(x: Evaluation) -> None:
    """Coordinates that are given by drives."""
    for d in x.program.system.drives:
        if d.kind == "prescribed":
            x.references[d.name] = x.reference(d.name)
            if d.wave:
                x.references[d.name] = tuple(map(add, x.references[d.name], x.wave(d.name)))
            i, k = x.program.driven(d)
            x.q[i], x.v[k], _ = x.references[d.name]


def place_bodies(x: Evaluation) -> None:
    """Poses and twists of all bodies that laws act on."""
    for i, (tree, shared) in enumerate(x.program.instances):
        if shared.ends:
            out = shared.place(q=x.q[tree.q], v=x.v[tree.v], P=x.numbers("tree", str(i)))
            x.ends |= {tree.first + b: np.array(getattr(out, f"b{b}"), dtype=object) for b in shared.ends}


def measure_angles(x: Evaluation) -> None:
    """Attitudes that are measured or watched, over all their turns."""
    for i, label in enumerate(x.program.angles):
        kind, body, axis = label
        if kind == "body":
            sine, cosine, rate = attitude(x.ends[x.program.graph.number(body)], axis)
            x.turned[label] = on_turn(atan2(sine, cosine), x.counted[i])
            x.turning[label] = rate / (sine * sine + cosine * cosine)


def measure_masters(x: Evaluation) -> None:
    """Joint coordinates and attitudes that actuators follow."""
    for m in x.program.system.measured:
        if m.kind == "joint":
            i, k = x.program.graph.coordinate(m.name, m.of, m.coordinate)
            s, ds, sine, cosine = x.q[i], x.v[k], sin(x.q[i]), cos(x.q[i])
        else:
            s, ds = x.turned["body", m.of, m.axis], x.turning["body", m.of, m.axis]
            sine, cosine, _ = attitude(x.ends[x.program.graph.number(m.of)], m.axis)
            n = 1.0 / sqrt(sine * sine + cosine * cosine)
            sine, cosine = sine * n, cosine * n
        x.masters.append((named(f"s({m.name})", s), named(f"ds({m.name})", ds), 0.0, sine, cosine))


def follow(x: Evaluation) -> None:
    """What servos and speed drives follow."""
    for d in x.program.system.drives:
        if d.kind != "prescribed":
            x.references[d.name] = x.reference(d.name)


def attitude(body: Array, axis: int) -> tuple[Scalar, Scalar, Scalar]:
    """sin, cos (not normalised) of the tilt of body axis w towards +y (axis 0, about -x) or +x (axis 1, about +y), and
    sin' cos - sin cos'."""
    w = np.reshape(body[:9], (3, 3))[:, 2]
    dw = cross(body[15:18], w)
    i = 1 if axis == 0 else 0
    return w[i], w[2], dw[i] * w[2] - w[i] * dw[2]


def poses_of(program: Program, row: SimpleNamespace) -> Poses:
    """R_WB (3, 3) and p_WB (3,) of every body in a sample row."""
    frames = row.poses.reshape(-1, 12)

    def pose(body: str) -> tuple[np.ndarray, np.ndarray]:
        i = program.graph.number(body)
        return (np.eye(3), np.zeros(3)) if i < 0 else (frames[i, 3:].reshape(3, 3), frames[i, :3])

    return pose
