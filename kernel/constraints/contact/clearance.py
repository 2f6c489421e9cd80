"""How soon pads and contacts that are left out of the equations could touch again: what is left of them in the code.

Per body with pads and per pair of shapes one clearance: the time before which nothing touches as long as nothing
accelerates by more than `HARDEST`.  Where a distance z closes at speed u, that is the root of u t + HARDEST t^2 / 2 =
z.  Bounds are conservative: a box around the points of a body above its highest pad, spheres around shapes, speeds at
the farthest point of a body.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from heavylift.kernel.compiler.function import Function
from heavylift.kernel.compiler.symbol import maximum, sqrt
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.forces.force_law import BODY

from .frames import Side
from .reach import apart

if TYPE_CHECKING:
    from .contact_points import Site

__all__ = ["NEVER_NEAR", "Clearances", "pads_numbers", "pads_of"]

HARDEST = 100.0  # [m/s^2] ten times gravity; what accelerates more is seen in the step that ends too close, and redone
NEVER_NEAR = 1e15  # [s]
PADS = 7  # numbers of the box around the pads of a body: centre(3), half edges(3), height of the highest pad


def pads_of(system: System) -> dict[str, tuple[str, ...]]:
    """Bodies that pads could push, each with the names of its supports."""
    out: dict[str, tuple[str, ...]] = {}
    for u in system.supports:
        out[u.point.body] = (*out.get(u.point.body, ()), u.name)
    return out


def pads_numbers(system: System, body: str) -> list[float]:
    """The box around the points of a body that pads could push, and the height of the highest pad."""
    own = [u for u in system.supports if u.point.body == body]
    low, high = ([edge(u.point.p[i] for u in own) for i in range(3)] for edge in (min, max))
    middle = [0.5 * (a + b) for a, b in zip(low, high, strict=True)]
    return [*middle, *(b - m for b, m in zip(high, middle, strict=True)), max(u.height for u in own)]


class Clearances:
    """The functions of a scene that say how soon something could touch; equal kinds share one."""

    def __init__(self, sites: list[Site]) -> None:
        self.pads = Function("above_pads", _above, {"p": PADS, "body": BODY})
        kinds: dict[str, Function] = {}
        self.of = {s.contact.name: kinds.setdefault(s.slot.name, _apart(s)) for s in sites}


def _above(p: Any, body: Any) -> dict[str, Any]:
    """No point of a body touches its pads before this time."""
    side = Side(body)
    x, h = side.place(p[:3]), p[3:6]
    speed = sqrt(side.w @ side.w * (h @ h)) - side.velocity(x)[2]
    return {"time": [_soonest(x[2] - p[6] - abs(side.R[2]) @ h, speed)]}


def _apart(s: Site) -> Function:
    """Two shapes do not touch before this time."""

    def body(p: Any, A: Any, B: Any) -> dict[str, Any]:
        return {"time": [_soonest(*apart(s.contact, p[: s.first], p[s.first :], A, B))]}

    return Function(s.slot.name.replace("slot", "apart"), body, {"p": s.watch.inputs["p"], "A": BODY, "B": BODY})


def _soonest(distance: Any, speed: Any) -> Any:
    z, u = maximum(distance, 0.0), maximum(speed, 0.0)
    return 2.0 * z / (u + sqrt(u * u + 2.0 * HARDEST * z) + 1e-300)
