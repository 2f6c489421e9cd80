"""Evaluation of the equations of motion of a whole scene at one instant, as a list of stages: poses -> laws -> rows ->
accelerations.

The same code runs on floats, as reference, and is traced into machine code. Each stage is a function of the evaluation
that reads what earlier stages have written.

Middle stages apply forces to bodies and joints and compute the guards of laws; the last stages solve for constraint
rows and accelerations, and collect guards and the derivative of the state.

Every law gives its force, the guards of its state, its heat and stored energy and, if it is driven, its work; so the
energy balance of a scene stays closed.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from operator import add
from typing import Any, NamedTuple

import numpy as np
from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, named, scope, select
from heavylift.kernel.constraints.row_structure import RigidAt
from heavylift.kernel.description.mechanics import Rope, Threshold
from heavylift.kernel.forces.force_law import attachment, wrench
from heavylift.kernel.forces.ropes import ROPE_HEAD, ROPE_LINE, RopeAt, not_weighed, pulls_down
from heavylift.kernel.forces.table import SharedForce

from .instant import (
    Evaluation,
    command_masters,
    follow,
    measure_angles,
    measure_masters,
    place_bodies,
    prescribe_joints,
)
from .program import Program
from .quantities import lines, names, points, scalar


def hold_rows(x: Evaluation) -> None:
    """Compute the constraint forces of kinematic loops, taut rigid ropes and closed contacts."""
    if len(x.program.constraints):
        x.rows = x.constraint_rows()
        x.rows.accelerate()
        x.loads = x.rows.loads


def accelerate(x: Evaluation) -> None:
    """Compute the accelerations of all trees; prescribed drives carry the remaining joint forces."""
    for i, (_, shared) in enumerate(x.program.instances):
        tied = i in x.program.constraints.linked
        out = x.rows.motion(i) if x.rows and tied else shared.accelerate(**x.arguments(i))
        x.dq += list(out.dq)
        x.dv += list(out.dv)
        for d, force in zip(x.prescribed(i), out.reaction, strict=False):
            if d:
                x.work["drive", d.name] = force * x.references[d.name][1] + x.leading.get(d.name, 0.0)


def pull_rigid_ropes(x: Evaluation) -> None:
    """Compute guards and work of rigid ropes; only their impacts cause heat (see `constraints.row_structure`)."""
    if x.rows:
        tensions = x.rows.tensions
        for name, guard in x.rows.guards().items():
            x.watched["rigid", name] = [guard]
            x.work["rigid", name] = -tensions[name] * x.lengths_of[name][1]


def press_contacts(x: Evaluation) -> None:
    """Compute guards, heat and forces of contacts, and the wrenches of all constraint rows on bodies."""
    contacts, rows = x.program.contacts, x.rows
    slots, pushes = (rows.slots, rows.multipliers[len(rows.rows) - len(contacts.held) :]) if rows else ([], [])
    guards, heat, x.pressing = contacts.loads(slots, pushes)
    for label, guard in zip(contacts.guards, contacts.watched(x.numbers, x.ends) + guards, strict=True):
        x.watched.setdefault(label, []).append(guard)
    labels = [("contact", s.contact.name) for s in contacts.sites]
    x.heat |= dict(zip(labels, heat, strict=True))
    x.stored |= dict.fromkeys(labels, 0.0)
    for body, pull in rows.wrenches() if rows else ():
        x.push(body, pull)


def watch_thresholds(x: Evaluation) -> None:
    """Compute the guard a x + b of each threshold; a and b are parameters, set when the threshold is armed."""
    system = x.program.system
    for h in system.thresholds:
        p, at = x.numbers("threshold", h.name), points(h, system)
        bodies = [x.ends[x.program.graph.number(point.body)] for point in at]
        places = [attachment(body, p[2 + 3 * i : 5 + 3 * i])[1] for i, body in enumerate(bodies)]
        values = [_value(x, h, name) for name in names(h, system)]
        value = scalar(h, places, p[2 + 3 * len(at) :], values, lines(h, system))
        x.watched["threshold", h.name] = [p[0] * value + p[1]]


def _value(x: Evaluation, h: Threshold, name: str) -> Any:
    """Return a named value of a scene: tension, length, coordinate, angle or wind speed."""
    if h.quantity == "angle":
        return x.turned["body", name, h.axis]
    if h.quantity in ("joint", "speed"):
        i, k = x.program.graph.coordinate(h.name, name, h.coordinate)
        return x.q[i] if h.quantity == "joint" else x.v[k]
    if h.quantity in ("length", "wind"):
        return x.signals[name][0] if name in x.signals else x.lengths_of[name][0]
    known = {name: shown[0] for (kind, name), shown in x.shown.items() if kind in ("rope", "force") and shown}
    known |= x.rows.end_tensions if x.rows else {}
    return known[name]


def collect(x: Evaluation) -> None:
    """Collect all guards, and the derivative of the state with its energy accounts, in the order of the state."""
    p = x.program
    waiting = {label: iter(values) for label, values in x.watched.items()}
    x.guards = [next(waiting[label]) for label in p.guards]
    heat, work = [x.heat.get(label, 0.0) for label in p.heats], [x.work[label] for label in p.works]
    x.dy = join(x.dq, x.dv, heat, work, [x.turning[label] for label in p.angles])


def read_signals(x: Evaluation) -> None:
    """Compute value and rate of each force law's signal: commanded, from its time history, or constant."""
    for law in x.program.laws:
        if s := law.signal:
            if s.driven:
                x.signals[law.name] = list(x.reference(law.name)[:2])
            elif ("reference", law.name) in x.program.parameters.at:  # set where a rope is hooked
                x.signals[law.name] = [x.numbers("reference", law.name)[1], 0.0]
            else:
                start, value, slope = x.numbers("signal", law.name)
                x.signals[law.name] = [value + slope * (x.t - start), slope] if s.times else [value, 0.0]
            if s.wave or s.waves:
                wave, rate, _ = x.wave(law.name, s)
                x.signals[law.name] = [x.signals[law.name][0] + wave, x.signals[law.name][1] + rate]


def weigh_rigid_ropes(x: Evaluation) -> None:
    """Apply the weight of rigid ropes at their ends, less the weight of rope mass added to the end bodies."""
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


def lead_ropes(x: Evaluation) -> None:
    """Apply to one end of each rope with mass the inertia force caused by drives that move the other end."""
    number = x.program.graph.number
    accelerations: dict[str, Array] = {}
    for d in dict.fromkeys(d for end in x.program.led for d in end.drives):
        R = np.reshape(x.ends[number(x.program.moved_by[d])][:9], (3, 3))
        accelerations[d] = named(f"a({d})", R @ x.numbers("along", d) * x.references[d][2])
    for n, end in enumerate(x.program.led):
        elastic = isinstance(end.rope, Rope)
        p = x.numbers("rope" if elastic else "rigid", end.rope.name)
        point = p[(ROPE_HEAD if elastic else RigidAt.LINES) + ROPE_LINE * end.line + 3 * end.end :][:3]
        arm, _, v = attachment(x.ends[number(end.body)], point)
        mass = select(p[RopeAt.HOOKED if elastic else RigidAt.HOOKED] > 0.0, -x.numbers("led", str(n))[0], 0.0)
        x.push(number(end.body), wrench(arm, mass * reduce(add, (accelerations[d] for d in end.drives))))
        for d in end.drives:
            x.leading[d] = x.leading.get(d, 0.0) + mass * (accelerations[d] @ v)


def apply_laws(x: Evaluation) -> None:
    """Evaluate every force law of the scene with its own parameters."""
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
    """Apply the forces by which servo and speed drives follow their references; prescribed joints need no force."""
    for d in x.program.system.drives:
        if d.kind != "prescribed":
            (i, k), (kp, kv), (ref, dref, _) = x.program.driven(d), x.numbers("drive", d.name), x.references[d.name]
            force = kv * (dref - x.v[k])
            if d.kind == "servo":
                force = kp * (ref - x.q[i]) + force
            force = named(f"tau({d.name})", force)
            x.tau[k] = x.tau[k] + force
            x.work["drive", d.name] = force * x.v[k] + x.leading.get(d.name, 0.0)


def bend(x: Evaluation) -> None:
    """Apply the elastic and damping forces of flexible bodies, mode by mode."""
    for link in x.program.graph.links:
        if link.modes and link.n_modes:
            name = link.body.name
            stiffness, damping = np.reshape(x.numbers("modes", name), (2, link.n_modes))
            q, v = np.array(x.q[link.q_modes]), np.array(x.v[link.v_modes])
            x.tau[link.v_modes] = list(-stiffness * q - damping * v)
            x.watched["bending", name] = [link.modes.smallness.guard(x.numbers("bending", name), q)]
            x.heat["bending", name] = damping @ (v * v)
            x.stored["bending", name] = 0.5 * (stiffness @ (q * q))


__all__ = ["FORCES", "POSES", "Evaluation", "EvaluationStage", "evaluate"]


class EvaluationStage(NamedTuple):
    """A stage of the evaluation of the equations: its function, and the fields of `Evaluation` it reads and writes."""

    run: Callable[[Evaluation], None]
    reads: str
    writes: str


POSES = (
    EvaluationStage(command_masters, "", "masters"),
    EvaluationStage(prescribe_joints, "masters", "references q v"),
    EvaluationStage(place_bodies, "q v", "ends"),
    EvaluationStage(measure_angles, "ends counted", "turned turning"),
    EvaluationStage(measure_masters, "q v ends turned turning", "masters"),
    EvaluationStage(follow, "masters", "references"),
)
FORCES = (
    EvaluationStage(read_signals, "masters", "signals"),
    EvaluationStage(weigh_rigid_ropes, "ends", "wrenches stored"),
    EvaluationStage(lead_ropes, "ends references", "wrenches leading"),
    EvaluationStage(apply_laws, "q v counted ends signals",
          "wrenches tau shown heat work stored watched turned turning"),
    EvaluationStage(drive, "q v references leading", "tau work"),
    EvaluationStage(bend, "q v", "tau heat stored watched"),
    EvaluationStage(hold_rows, "q v ends masters references wrenches tau", "rows loads lengths_of"),
    EvaluationStage(accelerate, "q v references tau rows leading", "dq dv work"),
    EvaluationStage(pull_rigid_ropes, "rows lengths_of", "watched work"),
    EvaluationStage(press_contacts, "ends rows", "wrenches heat stored pressing watched"),
    EvaluationStage(watch_thresholds, "q v ends turned shown signals rows lengths_of", "watched"),
    EvaluationStage(collect, "dq dv heat work turning watched", "dy guards"),
)  # fmt: skip


def evaluate(
    program: Program, t: Scalar, y: Array, P: Array, inside: Scalar | None = None, forces: bool = True
) -> Evaluation:
    """Evaluate the equations of a scene at time t [s], state y and parameters P.

    `inside`: a time within the present step. If `forces` is false, only poses and velocities of the bodies are
    computed.
    """
    q, v = program.nq, program.nq + program.nv
    behind = v + len(program.accounts)
    x = Evaluation(program, t, t if inside is None else inside, P, list(y[:q]), list(y[q:v]), list(y[v:behind]))
    x.counted, x.tau = list(y[behind:]), [0.0] * program.nv
    x.wrenches = [np.zeros(6) for _ in program.graph.links]
    for stage in POSES + FORCES if forces else POSES:
        stage.run(x)
    return x
