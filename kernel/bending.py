"""Beams at the limits of their theory: the first that a body passes is noted, the second ends the run or the statics.

The limits themselves stand in `flexible.small_deflections`; their guards are located as events are.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from .errors import KernelError
from .flexible.description import REFUSED, WARNED
from .notes import Note
from .switching import StateEvent

if TYPE_CHECKING:
    from .graph import Link
    from .stepper import Stepper

__all__ = ["check_bending", "pass_limit"]

LAST = (REFUSED / WARNED) ** 2  # the second limit, as part of the first one, squared


def pass_limit(run: Stepper, name: str, t_ns: int) -> StateEvent:
    """A flexible body has come to the limit that holds now; its value is the part of the length that it bends by.

    Raises KernelError at the second one.
    """
    link = run.program.graph.links[run.program.graph.number(name)]
    limit = run.P[run.program.parameters.at["bending", name]]
    if limit[0] >= LAST:
        raise KernelError(_told(run, link, t_ns, refused=True))
    limit[0] = LAST
    return StateEvent(name, "bent", _use(run, link)[0] * WARNED)


def bent(run: Stepper, name: str, t_ns: int) -> Note:
    """What is to be said of a body at the first limit."""
    return Note(t_ns, _told(run, run.program.graph.links[run.program.graph.number(name)], t_ns, refused=False))


def check_bending(run: Stepper) -> None:
    """Of the present pose, for statics: raises KernelError where a body is beyond the second limit, notes the first."""
    t_ns = run.epoch + round(run["t"] * 1e9)
    for link in run.program.graph.links:
        if link.modes and link.n_modes:
            use, limit = _use(run, link)[0] ** 2, run.P[run.program.parameters.at["bending", link.body.name]]
            if use > LAST:
                raise KernelError(_told(run, link, t_ns, refused=True))
            if use > limit[0]:
                limit[0] = LAST
                run.notes.append(bent(run, link.body.name, t_ns))


def _use(run: Stepper, link: Link) -> tuple[float, bool]:
    assert link.modes is not None, "of a flexible body"
    return link.modes.smallness.largest(run.state[link.q_modes])


def _told(run: Stepper, link: Link, t_ns: int, refused: bool) -> str:
    from .flexible.small_deflections import told  # needs linear algebra, which rigid scenes do not

    use, turns = _use(run, link)
    return told(link.body.name, link.joint.name, t_ns * 1e-9, turns, use, refused)
