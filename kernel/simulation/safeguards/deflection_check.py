"""Checks of flexible bodies against the limits of their theory: passing the first limit adds a note, the second ends
the run.

The limits of deflections are defined in `flexible.small_deflections`; their guards are located as events are.
Compression is compared with the buckling load (`flexible.buckling`) at every sample.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from heavylift.kernel.description.findings import Note
from heavylift.kernel.description.flexible import REFUSED, WARNED
from heavylift.kernel.description.forces import Load, Stream, Wind
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.switching import StateChange
from heavylift.kernel.multibody.flexible.small_deflections import NEVER, sentence
from heavylift.kernel.simulation.native.native_state import NativeState

if TYPE_CHECKING:
    from heavylift.kernel.model.program import Program
    from heavylift.kernel.multibody.graph import Link

SLENDER = 0.5  # of the buckling load, from which a body that knows of its compression is noted
UNKNOWN = 0.05  # the same for one that does not: its deflections are so much too small
LASTING = 0.1  # [s] that compression lasts in a row of samples before it counts: shocks bend nothing so soon

LAST = (REFUSED / WARNED) ** 2  # the second limit, as part of the first one, squared


def pass_limit(native: NativeState, name: str, t_ns: int) -> StateChange:
    """Replace the deflection limit that a flexible body has reached by the next; return an event with the deflection.

    Raises KernelError at the second limit.
    """
    link = native.program.graph.links[native.program.graph.number(name)]
    limit = native.P[native.program.parameters.at["bending", name]]
    if limit[0] >= LAST:
        raise KernelError(_message(native, link, t_ns, refused=True))
    limit[0] = LAST
    return StateChange(name, "bent", _use(native, link)[0] * WARNED)


def bent(native: NativeState, name: str, t_ns: int) -> Note:
    """Return the note about a flexible body that has reached its first deflection limit."""
    return Note(
        t_ns, _message(native, native.program.graph.links[native.program.graph.number(name)], t_ns, refused=False)
    )


def check_bending(native: NativeState) -> None:
    """Check deflections of flexible bodies in statics: KernelError beyond the second limit, a note beyond the first."""
    t_ns = native.epoch + round(native["t"] * 1e9)
    if native.program.axial:
        check_compression(native, np.array(native.method.row_layout.pack(native.row())), t_ns, lasting=0.0)
    for link in native.program.graph.links:
        if link.modes and link.n_modes:
            use, limit = _use(native, link)[0] ** 2, native.P[native.program.parameters.at["bending", link.body.name]]
            if use > LAST:
                raise KernelError(_message(native, link, t_ns, refused=True))
            if use > limit[0]:
                limit[0] = LAST
                native.notes.append(bent(native, link.body.name, t_ns))


def compressed(native: NativeState, rows: np.ndarray) -> np.ndarray:
    """Return for each of n sample rows (n, columns) whether axial loads come near buckling."""
    close = np.zeros(len(rows), dtype=bool)
    for link, _, loads in _loaded(native, rows):
        assert link.modes is not None, "of a flexible body"
        close |= ~link.modes.hardly_compressed(loads[:, :-2], loads[:, -2], loads[:, -1])
    return close


def _loaded(native: NativeState, rows: np.ndarray) -> Iterator[tuple[Link, list[Link], np.ndarray]]:
    """Yield each flexible body, the bodies on it, and an array (n, bodies on it + 2, 3): forces of these bodies [N],
    acceleration [m/s2] and angular velocity [rad/s] of the frame."""
    whole = rows[:, native.method.row_layout.at["axial"]].reshape(len(rows), -1, 3)
    return ((link, on, whole[:, at]) for link, on, at in native.program.compressible)


def relieve(native: NativeState) -> None:
    """Reset the stored times at which flexible bodies came near buckling."""
    for link, *_ in native.program.compressible:
        native.P[native.program.parameters.at["bending", link.body.name]][2:4] = NEVER


def check_compression(native: NativeState, row: np.ndarray, t_ns: int, lasting: float = LASTING) -> None:
    """Raise KernelError if a body is compressed beyond its buckling load at a sample row.

    Adds a note if it stays near it for `lasting` [s].
    """
    program, q = native.program, row[native.method.row_layout.at["q"]]
    for link, on, (loads,) in _loaded(native, row[None]):
        assert link.modes is not None, "of a flexible body"
        if link.modes.hardly_compressed(loads[None, :-2], loads[None, -2], loads[None, -1]):
            native.P[program.parameters.at["bending", link.body.name]][2:4] = NEVER
            continue
        places = np.array([k.joint.p_PJ if k.joint.kind != "slider" else (q[k.q.start], 0.0, 0.0) for k in on])
        column = link.modes.column
        part = column.part(loads[:-2], places.reshape(-1, 3), loads[-2], loads[-1])
        limit, t = native.P[program.parameters.at["bending", link.body.name]], t_ns * 1e-9
        near = part >= (SLENDER if column.softens else UNKNOWN)
        limit[2:4] = [
            (was if was >= 0.0 else t) if x else NEVER for x, was in ((near, limit[2]), (part >= 1.0, limit[3]))
        ]
        if not near or t - limit[2] < lasting:
            continue
        where = f"body '{link.body.name}' on joint '{link.joint.name}' at {t:.3f} s: it is compressed to"
        where, held = f"{where} {100.0 * part:.3g} % of", _held(program, program.graph.number(link.body.name))
        if part >= 1.0 and not held and t - limit[3] >= lasting:
            raise KernelError(
                f"{where} its buckling load, so its computed deflection is meaningless; "
                "reduce the load, make it stiffer, or brace it"
            )
        if not limit[1] and (not column.softens or part >= 1.0 or not held):
            limit[1] = 1.0
            native.notes.append(Note(t_ns, f"{where} {_compressed(part, column.softens, held)}"))


def _compressed(part: float, softens: bool, held: bool) -> str:
    if softens and held:
        return "the load at which it would buckle if only its frame held it; make sure that its other supports hold it"
    if softens:
        return "its buckling load; make it stiffer or reduce the load"
    more = f"about {100.0 * part / (1.0 - part):.2g} % too small" if part < 1.0 else "too small"
    return (
        f"its buckling load{' if only its frame holds it' if held else ''}, an effect that its matrices do not "
        f"include: its lateral deflections are {more}; describe it as a beam"
    )


def _held(program: Program, i: int) -> bool:
    """Return whether an element other than joints, loads and wind acts on a body or on the bodies that it carries."""
    links, carried = program.graph.links, {i}
    for j in range(i + 1, len(links)):
        if links[j].parent in carried:
            carried.add(j)
    s, number = program.system, program.graph.number
    ends = {number(p.body) for r in s.straight_ropes for line in r.lines for p in (line.a, line.b)}
    ends |= {number(p.body) for u in s.supports for p in u.points} | set(program.constraints.bodies)
    ends |= {end for x in program.laws if not isinstance(x.force, Load | Wind | Stream) for end in x.ends}
    return bool(carried & ends)


def _use(native: NativeState, link: Link) -> tuple[float, bool]:
    assert link.modes is not None, "of a flexible body"
    return link.modes.smallness.largest(native.state[link.q_modes])


def _message(native: NativeState, link: Link, t_ns: int, refused: bool) -> str:
    use, turns = _use(native, link)
    return sentence(link.body.name, link.joint.name, t_ns * 1e-9, turns, use, refused)
