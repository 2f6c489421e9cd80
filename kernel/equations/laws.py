"""Printed equations of every force law of a scene: where it acts, the formula of its kind, its numbers.

A kind without a formula here is printed with the docstring of its description, so that no law is left out.
"""

from dataclasses import fields
from inspect import getdoc
from typing import Any

from heavylift.kernel.description.field_types import field_names
from heavylift.kernel.description.forces import (
    Bushing,
    Characteristic,
    Immersion,
    Load,
    MooringLine,
    Reeving,
    Spring,
    Torsion,
    TuggerLine,
    UserLaw,
    Wind,
)
from heavylift.kernel.description.mechanics import (
    WORLD,
    Brake,
    Drive,
    JointSpring,
    Point,
    RigidRope,
    Rope,
    Stop,
    Support,
    System,
)
from heavylift.kernel.multibody.graph import Graph

from .document import DocumentSection, Equation, Formula, cross, joined, law, plain, sym

Row = tuple[Point, str, str]  # where a law acts, its name with the number of its end, sign of its force there


class Acting:
    """The forces and force laws of a system, sorted by the bodies and joints on which they act."""

    def __init__(self, system: System) -> None:
        self.system = system
        self.points: list[Row] = []
        for r in system.straight_ropes:
            for n, line in enumerate(r.lines, 1):
                self.points += [(line.a, f"{r.name}.{n}", "+"), (line.b, f"{r.name}.{n}", "-")]
        self.points += [(s.point, s.name, "+") for s in system.supports]
        for c in system.contacts:
            self.points += [(Point(c.a.body), c.name, "+"), (Point(c.b.body), c.name, "-")]
        self.couples = []  # ends of forces that bring a moment of their own
        for f in system.forces:
            for n, point in enumerate(f.points, 1):
                name = f"{f.name}.{n}" if len(f.points) > 1 else f.name
                self.points.append((point, name, "+"))
                self.couples.append((point.body, name))

    def on(self, body: str, n: int, gravity: float) -> tuple[Formula, Formula]:
        """Return the printed sums of the forces (F) and of the moments (M) applied to body n."""
        weight = [("+", Formula(f"m{n} g", rf"m_{{{n}}}\,\mathbf{{g}}"))] if gravity else []
        here = [(name, sign) for point, name, sign in self.points if point.body == body]
        forces = weight + [(sign, law("f", name, bold=True)) for name, sign in here]
        moments = []
        for name, sign in here:
            arm = plain("(") + _place(name, sign) + " - " + sym("r", n) + ")"
            moments.append((sign, cross(arm, law("f", name, bold=True))))
        moments += [("+", law("m", name, bold=True)) for on, name in self.couples if on == body]
        return joined(forces), joined(moments)

    def along(self, joint: str) -> list[tuple[Any, str]]:
        """Return the force laws that act on a joint, each with its coordinate ("" if the joint has only one)."""
        s = self.system
        groups: list[Any] = [*s.springs, *s.stops, *s.brakes, *s.drives]
        own = [(x, x.coordinate) for x in groups if x.joint == joint]
        return own + [(f, f.along[1]) for f in s.forces if f.along and f.along[0] == joint]


def _place(name: str, sign: str) -> Formula:
    return law("a" if sign == "+" else "b", name, bold=True)


def loops_at(graph: Graph, body: str) -> list[tuple[str, str]]:
    """Return the loop joints at a body: the name of each joint, with the sign of its force on the body."""
    ends = [(j.name, sign, on) for j in graph.loops for on, sign in ((j.child, "+"), (j.parent, "-"))]
    return [(name, sign) for name, sign, on in ends if on == body]


def laws(system: System) -> list[DocumentSection]:
    """Return a printed section for each kind of force law: formulas and a table of numbers."""
    groups: dict[type, list[Any]] = {}
    for f in fields(system):
        if f.name not in ("bodies", "joints", "thresholds", "gravity"):
            for item in getattr(system, f.name):
                groups.setdefault(type(item), []).append(item)
    return [_section(kind, items) for kind, items in groups.items()]


def _section(kind: type, items: list[Any]) -> DocumentSection:
    message = " ".join((getdoc(kind) or "").split())
    head = ("name", *(f for f in field_names(kind) if f != "name"))
    rows = [(x.name, *(_shown(getattr(x, f)) for f in head[1:])) for x in items]
    return DocumentSection(f"law: {kind.__name__.lower()}", (message,), (head, *rows), equations=_formulas(kind))


def _shown(x: Any) -> str:
    """Return a number, a point on a body, a line, or a tuple of them as text."""
    if isinstance(x, bool):
        return "yes" if x else "no"
    if isinstance(x, float | int):
        return f"{x:.6g}"
    if isinstance(x, str):
        return x
    if isinstance(x, Point):
        return f"{x.body} {_shown(x.p)}" if x.body != WORLD or any(x.p) else WORLD
    if isinstance(x, tuple):
        inner = ", ".join(map(_shown, x))
        return inner if any(not isinstance(e, float | int) for e in x) else f"({inner})"
    if hasattr(x, "a") and hasattr(x, "share"):
        return f"{_shown(x.a)} to {_shown(x.b)}" + (f" by {x.share:g}" if x.share != 1.0 else "")
    names = field_names(x.__class__)
    return ", ".join(f"{n} {_shown(getattr(x, n))}" for n in names) or "-"


_ALONG = (
    "f",
    "share T (b - a)/|b - a|",
    r"\mathrm{share}\,T\,\frac{\mathbf{b} - \mathbf{a}}{|\mathbf{b} - \mathbf{a}|}",
    "on the body of a, -f on that of b",
)
# left, right as text and as LaTeX, when it holds; for one law of the kind
_FORMULAS: dict[type, tuple[tuple[str, str, str, str], ...]] = {
    Rope: (
        ("l", "sum share |b - a|", r"\textstyle\sum \mathrm{share}\,|\mathbf{b} - \mathbf{a}|",
         "over its lines a to b"),
        ("T", "EA (l - L0)/L0 + c (l' - L0')", r"EA\,\frac{l - L_0}{L_0} + c\,(\dot{l} - \dot{L}_0)",
         "while hooked and taut, else 0"),
        _ALONG,
    ),
    RigidRope: (("l", "L0", "L_0", "while taut: T is what keeps it; slack while l < L0"), _ALONG),
    Support: (
        ("N", "k (height - z) - d z'", r"k\,(\mathrm{height} - z) - d\,\dot{z}", "while closed, else 0"),
        ("f", "N ez - kt (x - x0) - dt x'",
         r"N\,\mathbf{e}_z - k_t (\mathbf{x} - \mathbf{x}_0) - d_t \dot{\mathbf{x}}",
         "sticking; slipping mu N against the velocity"),
    ),
    JointSpring: (("tau", "k (q_rest - q) - d q'", r"k\,(q_{\mathrm{rest}} - q) - d\,\dot{q}", ""),),
    Stop: (
        ("tau", "k (lower - q) - d q'", r"k\,(\mathrm{lower} - q) - d\,\dot{q}", "below lower"),
        ("tau", "-k (q - upper) - d q'", r"-k\,(q - \mathrm{upper}) - d\,\dot{q}", "above upper"),
    ),
    Brake: (
        ("tau", "-k (q - q0) - d q'", r"-k\,(q - q_0) - d\,\dot{q}", "sticking; slipping it has the size moment"),
    ),
    Drive: (
        ("q", "s(t)", "s(t)", "prescribed"),
        ("tau", "kp (s - q) + kv (s' - q')", r"k_p (s - q) + k_v (\dot{s} - \dot{q})", "servo"),
        ("tau", "kv (s' - q')", r"k_v (\dot{s} - \dot{q})", "speed"),
    ),
    Spring: (
        ("f", "(k (l - rest) + d l') (b - a)/l",
         r"\bigl(k\,(l - \mathrm{rest}) + d\,\dot{l}\bigr)\,\frac{\mathbf{b} - \mathbf{a}}{l}",
         "on the body of a, -f on that of b"),
    ),
    Load: (("f", "s(t) force", r"s(t)\,\mathrm{force}", ""), ("m", "s(t) moment", r"s(t)\,\mathrm{moment}", "")),
    Wind: (
        ("f", "1/2 density C (A |w - v| + sum side |n (w - v)|) (w - v)",
         r"\tfrac{1}{2}\,\rho\,C\,(A\,|\mathbf{w} - \mathbf{v}|"
         r" + \textstyle\sum \mathrm{side}\,|\mathbf{n}\cdot(\mathbf{w} - \mathbf{v})|)\,(\mathbf{w} - \mathbf{v})",
         "n: axis of the body"),
    ),
    Torsion: (
        ("m", "(k (rest - phi) - d phi') dphi'/dw",
         r"\bigl(k\,(\mathrm{rest} - \varphi) - d\,\dot{\varphi}\bigr)\,\partial\dot{\varphi}/\partial\omega",
         "on b, -m on a; phi: twist of b about the axis"),
    ),
    Bushing: (
        ("f", "-(dx'/dV)^T (K x + D x')",
         r"-(\partial\dot{\mathbf{x}}/\partial\mathbf{V})^T (K\,\mathbf{x} + D\,\dot{\mathbf{x}})",
         "six components on b, -f on a"),
    ),
    Characteristic: (("tau", "s(t) effort(x)", r"s(t)\,\mathrm{effort}(x)", "x: position or speed"),),
    Immersion: (("f", "effort(d) ez", r"\mathrm{effort}(d)\,\mathbf{e}_z", "d: depth of the lowest point"),),
    UserLaw: (("f", "function(t, state)", r"\mathrm{function}(t, \mathrm{state})", "force or effort"),),
    Reeving: (
        ("T", "EA (l/N - 1) + c s'", r"EA\,(l/N - 1) + c\,\dot{s}", "per part, while taut, else 0"),
        ("T", "T_before exp(mu wrap)/efficiency", r"T_{\mathrm{before}}\,e^{\mu\,\mathrm{wrap}}/\eta",
         "behind a sheave that slips along the rope"),
    ),
    TuggerLine: (
        ("T", "T0 (1 + s x/sqrt(1 + x^2))", r"T_0\,(1 + s\,x/\sqrt{1 + x^2})", "x = l'/v; along the line"),
    ),
    MooringLine: (
        ("f", "-H (b - a)/|b - a| - V ez",
         r"-H\,\frac{\mathbf{b} - \mathbf{a}}{|\mathbf{b} - \mathbf{a}|} - V\,\mathbf{e}_z",
         "at b, with the horizontal direction; H and V of the elastic catenary through both ends"),
    ),
}  # fmt: skip


def _formulas(kind: type) -> list[tuple[str, list[Equation]]]:
    rows = _FORMULAS.get(kind, ())
    return [("", [Equation(sym(a, bold=a in "fm"), Formula(b, c), d) for a, b, c, d in rows])] if rows else []
