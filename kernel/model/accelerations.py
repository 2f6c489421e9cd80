"""The last stages of an evaluation: constraint rows, accelerations, what is watched, the derivative of the state."""

from typing import Any

from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.description.mechanics import Threshold
from heavylift.kernel.forces.force_law import attachment

from .instant import Evaluation
from .quantities import lines, names, points, scalar


def hold_rows(x: Evaluation) -> None:
    """Multipliers that keep loops, taut rigid ropes and closed contacts together."""
    if len(x.program.constraints):
        x.rows = x.constraint_rows()
        x.rows.accelerate()
        x.loads = x.rows.loads


def accelerate(x: Evaluation) -> None:
    """The motion of every tree; a prescribed drive carries what the other laws of its joint do not."""
    for i, (_, shared) in enumerate(x.program.instances):
        tied = i in x.program.constraints.linked
        out = x.rows.motion(i) if x.rows and tied else shared.accelerate(**x.arguments(i))
        x.dq += list(out.dq)
        x.dv += list(out.dv)
        for d, force in zip(x.prescribed(i), out.reaction, strict=False):
            if d:
                x.work["drive", d.name] = force * x.references[d.name][1]


def pull_rigid_ropes(x: Evaluation) -> None:
    """Guards and work of rigid ropes; their heat is made at once (see `constraints.rigid_ropes`)."""
    if x.rows:
        tensions = x.rows.tensions
        for name, guard in x.rows.guards().items():
            x.watched["rigid", name] = [guard]
            x.work["rigid", name] = -tensions[name] * x.lengths_of[name][1]


def press_contacts(x: Evaluation) -> None:
    """Guards, heat and forces of contacts; what all rows do to the bodies."""
    contacts, rows = x.program.contacts, x.rows
    slots, pushes = (rows.slots, rows.multipliers[len(rows.rows) - len(contacts.held) :]) if rows else ([], [])
    guards, heat, x.pressing = contacts.loads(slots, pushes)
    for label, guard in zip(contacts.guards, contacts.watched(x.numbers, x.ends) + guards, strict=True):
        x.watched.setdefault(label, []).append(guard)
    labels = [("contact", s.contact.name) for s in contacts.sites]
    x.heat |= dict(zip(labels, heat, strict=True))
    x.stored |= dict.fromkeys(labels, 0.0)
    for body, wrench in rows.wrenches() if rows else ():
        x.push(body, wrench)


def watch_thresholds(x: Evaluation) -> None:
    """a x + b; Python sets a and b when a threshold is armed."""
    system = x.program.system
    for h in system.thresholds:
        p, at = x.numbers("threshold", h.name), points(h, system)
        bodies = [x.ends[x.program.graph.number(point.body)] for point in at]
        places = [attachment(body, p[2 + 3 * i : 5 + 3 * i])[1] for i, body in enumerate(bodies)]
        values = [_value(x, h, name) for name in names(h)]
        value = scalar(h, places, p[2 + 3 * len(at) :], values, lines(h, system))
        x.watched["threshold", h.name] = [p[0] * value + p[1]]


def _value(x: Evaluation, h: Threshold, name: str) -> Any:
    """What a scene knows by a name: a tension, a length, a coordinate, an angle, a speed of wind."""
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
    """Guards and accounts in the order of the program."""
    p = x.program
    waiting = {label: iter(values) for label, values in x.watched.items()}
    x.guards = [next(waiting[label]) for label in p.guards]
    heat, work = [x.heat.get(label, 0.0) for label in p.heats], [x.work[label] for label in p.works]
    x.dy = join(x.dq, x.dv, heat, work, [x.turning[label] for label in p.angles])
