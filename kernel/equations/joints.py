"""Every joint in print: the columns of S that it gives to its body, and the forces along its coordinates."""

from __future__ import annotations

from heavylift.kernel.description.joint_table import JOINTS, THIRD
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.multibody.graph import Graph, Link

from .document import DocumentSection, Equation
from .laws import Acting
from .notation import Formula, cross, joined, law, plain, sym, transposed

_AXES = "est"  # letters of axis, second, and axis x second


def joints(system: System, graph: Graph) -> DocumentSection:
    """Coordinates, columns of S and joint forces tau of all joints."""
    acting = Acting(system)
    groups = []
    for i, link in enumerate(graph.links):
        n, joint = i + 1, link.joint
        kind = JOINTS[joint.kind]
        equations = []
        if kind.n_v:
            names = ", ".join(kind.coordinates)
            equations.append(Equation(sym("q", n), Formula(f"({names})", rf"\text{{({names})}}")))
            equations.append(Equation(sym("S", n), _columns(link, n), ", ".join(kind.velocities)))
        for axis in sorted({m.axis for m in kind.motions} - {THIRD}):
            given = ", ".join(f"{x:.6g}" for x in (joint.axis, joint.second)[axis])
            frame = Formula(f"Rj{n}", rf"\mathbf{{R}}^{{j}}_{{{n}}}")
            equations.append(Equation(sym(_AXES[axis], n), frame + f" ({given})"))
        if kind.n_v:
            equations.append(_effort(acting, joint.name, n, kind.coordinates))
        groups.append((f"({n}) {joint.name}: {joint.kind}", equations))
    return DocumentSection(
        "joints",
        (
            "S velocity columns [angular; linear] in world axes, d from the tree's point to the child's origin;",
            "e, s, t = axis, second axis and their cross product, carried along by the joint's own motions before;",
            "Rj rotation of the joint's frame in the world, before the joint moves",
        ),
        equations=groups,
    )


def _columns(link: Link, n: int) -> Formula:
    """S of a joint, column by column."""
    kind = JOINTS[link.joint.kind]
    if kind.quaternion is not None:
        R = sym("R", n)
        turns = _column(R, n, True)
        return _side_by_side([_column(R, n, False), turns] if kind.quaternion else [turns])
    columns = []
    for c in range(kind.n_v):
        terms = []
        for m in kind.motions:
            if m.coordinate == c:
                factor = "h " if m.factor is None else f"{m.factor:g} " if m.factor not in (0.0, 1.0) else ""
                terms.append(("+", plain(factor) + _column(sym(_AXES[m.axis], n), n, m.turns)))
        columns.append(joined(terms))
    return _side_by_side(columns)


def _column(e: Formula, n: int, turns: bool) -> Formula:
    top, low = (e, cross(sym("d", n), e)) if turns else (plain("0"), e)
    return Formula(f"[{top.text}; {low.text}]", rf"\begin{{bmatrix}} {top.latex} \\ {low.latex} \end{{bmatrix}}")


def _side_by_side(columns: list[Formula]) -> Formula:
    return Formula(", ".join(c.text for c in columns), r",\; ".join(c.latex for c in columns))


def _effort(acting: Acting, joint: str, n: int, coordinates: dict[str, float]) -> Equation:
    """tau: the sum of the laws along each coordinate, or what a prescribed drive must bring."""
    given = [x for x, _ in acting.along(joint) if getattr(x, "kind", "") == "prescribed"]
    if given:
        remark = f"prescribed by {', '.join(x.name for x in given)}"
        return Equation(sym("tau", n), transposed(sym("S", n)) + " " + sym("f", n, "c"), remark)
    parts = []
    for c in coordinates:
        terms = [("+", law("tau", x.name)) for x, at in acting.along(joint) if at in ("", c)]
        parts.append(joined(terms))
    if all(p.text == "0" for p in parts):
        return Equation(sym("tau", n), plain("0"))
    return Equation(sym("tau", n), _tuple(parts))


def _tuple(parts: list[Formula]) -> Formula:
    if len(parts) == 1:
        return parts[0]
    return Formula("(" + ", ".join(p.text for p in parts) + ")", "(" + r",\, ".join(p.latex for p in parts) + ")")
