"""The middle stages of an evaluation: what pushes bodies and joints, and when laws change their state.

Every law gives its force, the guards of its state, what it turns into heat, what it stores and, where it is driven, its
work; so the energy accounts of a scene stay closed.
"""

import numpy as np
from heavylift.kernel.compiler.symbol import Scalar, Scalars, named, scope
from heavylift.kernel.constraints.rigid_ropes import RigidAt
from heavylift.kernel.forces.force_law import attachment
from heavylift.kernel.forces.ropes import not_weighed, pulls_down
from heavylift.kernel.forces.table import SharedForce

from .instant import Evaluation


def read_signals(x: Evaluation) -> None:
    """Value and rate of each law's signal: commanded, from its history's active piece, or constant."""
    for law in x.program.laws:
        if s := law.signal:
            if s.driven:
                x.signals[law.name] = list(x.reference(law.name)[:2])
            elif ("reference", law.name) in x.program.parameters.at:  # set where a rope is hooked
                x.signals[law.name] = [x.numbers("reference", law.name)[1], 0.0]
            else:
                start, value, slope = x.numbers("signal", law.name)
                x.signals[law.name] = [value + slope * (x.t - start), slope] if s.times else [value, 0.0]
            if s.wave:
                wave, rate, _ = x.wave(law.name)
                x.signals[law.name] = [x.signals[law.name][0] + wave, x.signals[law.name][1] + rate]


def weigh_rigid_ropes(x: Evaluation) -> None:
    """What rigid ropes weigh and their ends do not."""
    for r in x.program.system.rigid_ropes:
        height: Scalar = 0.0
        if r.mass:
            weight, p = x.numbers("weight", r.name)[0], x.numbers("rigid", r.name)
            for n, line in enumerate(r.lines):
                q = p[RigidAt.LINES + 7 * n :]
                for end, p_BX in ((line.a, q[:3]), (line.b, q[3:6])):
                    body = x.program.graph.number(end.body)
                    arm, place, _ = attachment(x.ends[body], p_BX)
                    x.push(body, pulls_down(q[6] * weight, arm))
                    height = height + not_weighed(q[6] * weight) * place[2]
        x.stored["rigid", r.name] = height


def apply_laws(x: Evaluation) -> None:
    """Every entry of the force table, called with its own numbers."""
    for law in x.program.laws:
        _apply(x, law)


def _apply(x: Evaluation, law: SharedForce) -> None:
    label, name = (law.law.kind, law.name), law.name
    blocks: dict[str, Scalars] = {"p": x.numbers(*label), **{f"e{i}": x.ends[b] for i, b in enumerate(law.ends)}}
    if law.signal:
        blocks["s"] = x.signals[name]
    if law.along:
        i, k = law.along
        blocks["x"] = [x.q[i], x.v[k]]
    if law.law.timed:
        blocks["t"] = [x.numbers("clock", "")[0] + x.t]
    angles = [("force", name, i) for i in range(law.angles)]
    if angles:
        first = x.program.angles.index(angles[0])
        blocks["c"] = x.counted[first : first + len(angles)]
    with scope(name):
        out = law.function(**blocks)
    x.turned |= dict(zip(angles, out.turned, strict=True))
    x.turning |= dict(zip(angles, out.turning, strict=True))
    for i, body in enumerate(law.ends):
        x.push(body, named(f"F({name},{i + 1})", getattr(out, f"w{i}")))
    if law.along:
        x.tau[k] = x.tau[k] + named(f"tau({name})", out.effort[0])
    x.shown[label] = list(out.shown)
    x.heat[label], x.work[label], x.stored[label] = out.heat[0], out.work[0], out.stored[0]
    x.watched |= {(guard, name): [value] for guard, value in zip(law.guards, out.guards, strict=True)}


def drive(x: Evaluation) -> None:
    """Servos and speed drives towards their references; a prescribed joint needs no force."""
    for d in x.program.system.drives:
        if d.kind != "prescribed":
            (i, k), (kp, kv), (ref, dref, _) = x.program.driven(d), x.numbers("drive", d.name), x.references[d.name]
            force = kv * (dref - x.v[k])
            if d.kind == "servo":
                force = kp * (ref - x.q[i]) + force
            force = named(f"tau({d.name})", force)
            x.tau[k] = x.tau[k] + force
            x.work["drive", d.name] = force * x.v[k]


def bend(x: Evaluation) -> None:
    """Elasticity and damping of flexible bodies, mode by mode."""
    for link in x.program.graph.links:
        if link.modes and link.n_modes:
            name = link.body.name
            stiffness, damping = np.reshape(x.numbers("modes", name), (2, link.n_modes))
            q, v = np.array(x.q[link.q_modes]), np.array(x.v[link.v_modes])
            x.tau[link.v_modes] = list(-stiffness * q - damping * v)
            x.watched["bending", name] = [link.modes.smallness.guard(x.numbers("bending", name), q)]
            x.heat["bending", name] = damping @ (v * v)
            x.stored["bending", name] = 0.5 * (stiffness @ (q * q))
