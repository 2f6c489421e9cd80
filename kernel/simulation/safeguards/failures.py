"""Errors that end a run, each as one sentence with cause and time.

`t` is the time since the start of the run [s] throughout. Errors of lost loops are in `assembly.assembly`, those of
unstable fixed steps in `methods.stability`.

Bodies without resistance to motion: a missing mass or inertia that matters is named at the start. Structural zeros are
found when the equations are traced. A joint-space inertia can also be singular by its numbers, such as that of a point
mass at the centre of a ball joint; its factors on floats, in the initial pose, show this. Trees in which every body has
mass and full inertia need no check.
"""

from types import SimpleNamespace

import numpy as np
from heavylift.kernel.algebra.dense import eigenvalues
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.reeving import ReevingLaw
from heavylift.kernel.model.instant import poses_of
from heavylift.kernel.model.program import Program
from heavylift.kernel.multibody.dynamics import composites, joint_space_inertia, ltdl
from heavylift.kernel.multibody.kinematics import kinematics
from heavylift.kernel.multibody.trees import Tree

OTHER = {"radau5": "choose a larger tolerance"}  # what is left to a method that is itself the remedy
SHORTEST_ROPE = 1e-6  # [m] below which EA/L0 makes any step too small


def check_lengths(program: Program, t: float, lengths: np.ndarray) -> None:
    """Raise KernelError for a rope whose whole length is wound up; lengths: unstretched (n_ropes,) [m]."""
    for i in np.flatnonzero(wound_up(lengths)) if len(lengths) else ():
        name = program.system.ropes[i].name
        raise KernelError(f"rope '{name}' at {t:.3f} s: it is completely wound up; stop its winch earlier")


def wound_up(lengths: np.ndarray) -> np.ndarray:
    """Return for each rope whether its whole length is wound up; lengths: unstretched [m]."""
    found: np.ndarray = lengths < SHORTEST_ROPE
    return found


def check_sliders(program: Program, t: float, q: np.ndarray) -> None:
    """Raise KernelError for a slider beyond the ends of its beam; q: (nq,) coordinates."""
    for k, length in program.sliders:
        if not 0.0 <= q[k.q.start] <= length:
            raise KernelError(
                f"slider '{k.joint.name}' at {t:.3f} s: it has left its beam, which reaches from 0 to "
                f"{length:g} m; stop it earlier"
            )


def off_beams(program: Program, q: np.ndarray) -> np.ndarray:
    """Return whether any slider is beyond the ends of its beam, for coordinates (n, nq)."""
    off = np.zeros(len(q), dtype=bool)
    for k, length in program.sliders:
        x = q[:, k.q.start]
        off |= ~((x >= 0.0) & (x <= length))
    return off


def unsolved(method: str, t: float) -> KernelError:
    """Return the error for an implicit method that does not converge."""
    return KernelError(
        f"step near {t:.6f} s: method '{method}' finds no solution of its equations; choose a smaller step or tolerance"
    )


def undefined(program: Program, t: float, row: SimpleNamespace, v: np.ndarray) -> KernelError | None:
    """Return the error for coinciding rope ends or an infinite velocity in v (nv,); None if there is neither."""
    check_lengths(program, t, row.length)
    for rope, span in zip(program.system.ropes, row.length + row.elongation, strict=True):
        if span < SHORTEST_ROPE:
            where = f"rope '{rope.name}' at {t:.3f} s"
            return KernelError(f"{where}: its ends meet, so that it has no direction; keep them apart")
    pose = poses_of(program, row)
    for x in program.laws:
        if isinstance(x.law, ReevingLaw) and (message := x.law.off_its_sheaves(x.force, pose, program.shown(x, row))):
            return KernelError(f"reeving '{x.name}' at {t:.3f} s: {message}")
    for link in program.graph.links:
        if not np.isfinite(v[link.v.start : link.v_modes.stop]).all():
            return KernelError(
                f"body '{link.body.name}' at {t:.6f} s: its motion is not finite; check its mass and forces"
            )
    return None


def too_slow(method: str, t: float, step: float, mode: str) -> KernelError:
    """Return the error for too many steps per simulated second, with the fastest mode as cause."""
    cure = OTHER.get(method, "choose method radau5 or a larger tolerance")
    return KernelError(
        f"run at {t:.6f} s: a million steps of method '{method}' were not enough for one second, they are "
        f"{step:.2g} s long; {mode + '; ' if mode else ''}soften that law, or {cure}"
    )


def too_small(program: Program, t: float, accelerations: np.ndarray, mode: str, method: str) -> KernelError:
    """Return the error for a step below the shortest length, naming the fastest mode and the most accelerated body."""
    rates = np.abs(accelerations)
    if not np.isfinite(rates).all():
        k = int(np.flatnonzero(~np.isfinite(rates))[0])
        link = next(x for x in program.graph.links if x.v.start <= k < x.v_modes.stop)
        return KernelError(f"body '{link.body.name}' at {t:.6f} s: its motion is not finite; check its mass and forces")
    worst = int(np.argmax(rates))
    link = next(k for k in program.graph.links if k.v.start <= worst < k.v_modes.stop)
    return KernelError(
        f"body '{link.body.name}' at {t:.6f} s: the step became too small (below 1e-12 s); "
        + (
            f"{mode}, or a law near it jumps; soften it, or {OTHER.get(method, 'choose method radau5')}"
            if mode
            else "a law near it jumps; soften it"
        )
    )


ROUND_OFF = 1e-14  # of a pivot, relative to the products whose sum it is
MOST = 256
_resist: dict[tuple[object, ...], None] = {}  # kinds, numbers and poses of trees that do, the oldest first
FULL = 1e-12  # least principal moment of a full inertia, relative to the largest


def check_resistance(program: Program, y: np.ndarray) -> None:
    """Raise KernelError, naming body and joint, for a joint along which nothing has inertia; y: initial state."""
    for tree, _ in program.instances:
        q = y[tree.q]
        key = tree.kind, *tree.numbers, *q.tolist()
        if key not in _resist and not all(map(_full, tree.bodies)):
            _check(program, tree, q)
        _resist[key] = None
    for old in list(_resist)[: max(0, len(_resist) - MOST)]:
        _resist.pop(old, None)


def _full(body: object) -> bool:
    moments = eigenvalues(body.inertia.tolist())  # type: ignore[attr-defined]
    return body.mass > 0.0 and moments[0] > FULL * moments[2]  # type: ignore[attr-defined]


def _check(program: Program, tree: Tree, q: np.ndarray) -> None:
    still = [0.0] * len(tree.prescribed_dofs)
    K = kinematics(tree, q, np.zeros(tree.v.stop - tree.v.start), 0.0, still)
    I, _ = composites(tree, K, [np.zeros(6)] * len(tree.bodies))
    H = joint_space_inertia(tree, K, I)
    with np.errstate(all="ignore"):
        factors = ltdl(tree, {k: np.float64(h) for k, h in H.items()})
    columns = [s for S in K.S for s in S]
    for k in reversed(tree.free_dofs):  # in the order of elimination
        i, s = tree.body_of_dof[k], np.abs(columns[k])
        if not 1.0 / factors.D_inverse[k] > ROUND_OFF * (s @ np.abs(I[i]) @ s):
            name, joint = tree.bodies[i].name, program.graph.links[tree.first + i].joint
            raise KernelError(
                f"body '{name}': it can move without inertia in joint '{joint.name}'; give "
                "it, or the bodies that it carries, mass or inertia"
            )
