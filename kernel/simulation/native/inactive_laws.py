"""Laws that a scene does not require at the moment, and the code in which they do not occur.

A rope that nobody has hooked pulls at nothing; a pad or contact far from what it could touch pushes nothing.  Their
terms are exactly zero, and a sum without a zero is the same sum, so leaving them out changes no step.  What is left of
pads and contacts is one clearance each (see `clearance`), which brings them back in time.  When that pays is the
affair of `variant_policy`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from heavylift.kernel.compiler.emit import module
from heavylift.kernel.compiler.function import Function
from heavylift.kernel.compiler.machine_code import Library
from heavylift.kernel.constraints.contact.clearance import pads_of
from heavylift.kernel.constraints.contact.contact_points import SlotAt
from heavylift.kernel.constraints.rigid_ropes import RigidAt
from heavylift.kernel.forces.force_law import BODY
from heavylift.kernel.forces.ropes import RopeAt
from heavylift.kernel.forces.supports import SupportAt

from .native_functions import Stepping
from .oracle import Oracle

if TYPE_CHECKING:
    from types import SimpleNamespace

    from heavylift.kernel.methods.peers import Code
    from heavylift.kernel.model.program import Program

__all__ = ["AWAY", "alone", "dispensable", "leaner", "leaner_code"]


AWAY = 0.2  # [s] until which nothing at rest could touch what is left out: two steps of the usual longest length


def dispensable(program: Program, P: np.ndarray, row: Callable[[], SimpleNamespace], away: float) -> frozenset[str]:
    """Names of ropes that are not hooked, and of pads and contacts that nothing at rest could touch within `away` [s];
    row: gives the present sample row."""
    s, at = program.system, program.parameters.at
    out = {r.name for r in s.ropes if not (r.mass or P[at["rope", r.name]][RopeAt.HOOKED])}  # a weight stays
    out |= {r.name for r in s.rigid_ropes if not (r.mass or P[at["rigid", r.name]][RigidAt.HOOKED])}
    pads = {body: u for body, u in pads_of(s).items() if not any(P[at["support", x]][SupportAt.CLOSED] for x in u)}
    sites = [x for x in program.contacts.sites if not any(P[at["slot", k]][SlotAt.ON] for k in x.slots)]
    if not (pads or sites):
        return frozenset(out)
    frames, c = row().poses.reshape(-1, 12), program.clearances

    def end(i: int) -> np.ndarray:
        """A body as laws see it, at rest."""
        x = np.zeros(BODY)
        x[:9], x[12:15] = (np.eye(3).ravel(), 0.0) if i < 0 else (frames[i, 3:], frames[i, :3])
        return x

    for body, names in pads.items():
        if c.pads(p=P[at["pads", body]], body=end(program.graph.number(body))).time[0] > away:
            out |= {*names}
    for x in sites:
        a, b = (end(i) for i in x.bodies)
        if c.of[x.contact.name](p=P[at["shapes", x.contact.name]], A=a, B=b).time[0] > away:
            out.add(x.contact.name)
    return frozenset(out)


def leaner(method: Stepping, absent: frozenset[str]) -> Stepping:
    """The native functions with equations in which these laws do not occur; blocks and rows are the same."""
    return Stepping(method.program, method.method, method.control, method.program.without(absent))


def alone(method: Stepping) -> int:
    """Nodes of the code of the equations that no other set of laws shares, loads and results included."""
    shared, seen = {*method.program.shared}, set[Function]()

    def visit(f: Function) -> int:
        if f in shared or f in seen:
            return 0
        seen.add(f)
        return len(f.nodes) + sum(visit(n.args[0]) for n in f.nodes if n.op == "call")

    return sum(visit(f) for f in (method.f_rate, method.f_project) if f)


def leaner_code(method: Stepping, base: Code, structure: str, fused: bool, opt: int, cache: bool) -> Code:
    """Machine code of `leaner`: new is what evaluates the equations, all else is that of `base`."""
    if not isinstance(base, Library):
        return Oracle(method)
    shared = {*method.program.shared}

    def ir() -> str:
        functions = [f for f in (method.f_rate, method.f_project) if f]
        return module(*functions, fused=fused, found=lambda f, name: f in shared and base.has(name))

    return Library(f"equations of {structure}", ir, opt, cache, base=base)
