"""The equation of every body, the paper's (1) to (4), with all that acts on it, and its row of the recursion, Fig. 6.

Force: m_i r"_i = F_i + Fc_i - the joint forces that row i of T^-T subtracts.  The moment balance about the centre of
mass has the same terms and the levers of those forces.
"""

from __future__ import annotations

from heavylift.kernel.description.mechanics import WORLD, System
from heavylift.kernel.multibody.graph import Graph, children_of

from .document import DocumentSection, Equation
from .laws import Acting, loops_at
from .notation import Formula, cross, dual_cross, joined, law, sym, transposed


def _force(graph: Graph, i: int, remark: str = "") -> Equation:
    n = i + 1
    terms = [("+", sym("F", n)), ("+", sym("F", n, "c"))]
    terms += [("-", sym("F", j + 1, "c")) for j in children_of(graph.T, i)]
    terms += [(sign, law("Fc", name, bold=True)) for name, sign in loops_at(graph, graph.links[i].body.name)]
    return Equation(_product(sym("m", n, bold=False), sym("r", n, dots=2)), joined(terms), remark)


def _product(a: Formula, b: Formula) -> Formula:
    return Formula(f"{a.text} {b.text}", rf"{a.latex}\,{b.latex}")


def _moment(graph: Graph, i: int) -> Equation:
    n = i + 1
    I, w = sym("I", n), sym("w", n)
    left = _product(I, sym("w", n, dots=1)) + " + " + cross(w, _product(I, w))

    def lever(j: int) -> Formula:
        arm = Formula("(", "(") + sym("p", j) + " - " + sym("r", n) + ")"
        return cross(arm, sym("F", j, "c"))

    terms = [("+", sym("M", n)), ("+", sym("M", n, "c")), ("+", lever(n))]
    for j in children_of(graph.T, i):
        terms += [("-", sym("M", j + 1, "c")), ("-", lever(j + 1))]
    for name, sign in loops_at(graph, graph.links[i].body.name):
        arm = Formula("(", "(") + law("p", name, bold=True) + " - " + sym("r", n) + ")"
        terms += [(sign, law("Mc", name, bold=True)), (sign, cross(arm, law("Fc", name, bold=True)))]
    return Equation(left, joined(terms))


def balances(system: System, graph: Graph) -> DocumentSection:
    """Force and moment balance of every body, with what its applied force and moment consist of."""
    acting = Acting(system)
    groups = []
    for i, link in enumerate(graph.links):
        forces, moments = acting.on(link.body.name, i + 1, system.gravity)
        equations = [_force(graph, i), _moment(graph, i)]
        equations.append(Equation(sym("F", i + 1), forces))
        equations.append(Equation(sym("M", i + 1), moments))
        if link.modes is not None:
            left = Formula(f'Me{i + 1} eta{i + 1}"', rf"\mathbf{{M}}^{{e}}_{{{i + 1}}}\,\ddot{{\eta}}_{{{i + 1}}}")
            equations.append(Equation(left, _elastic(i + 1)))
        groups.append((f"({i + 1}) {link.body.name}", equations))
    return DocumentSection(
        "equation of every body",
        (
            "r centre of mass, p origin of the body's joint, w angular velocity, all in world axes;",
            "F, M applied force and moment about r; Fci, Mci force and moment (about pi) of joint i on body i;",
            "which joint forces are subtracted is row i of T^-T",
            *_water(graph, "besides, the water takes A a + v x* (A v) of its added mass A: of"),
        ),
        equations=groups,
    )


def _water(graph: Graph, told: str) -> tuple[str, ...]:
    """A line about bodies with an added mass, if there are any."""
    names = [link.body.name for link in graph.links if link.body.added is not None]
    return (f"{told} {', '.join(names)}",) if names else ()


def _elastic(n: int) -> Formula:
    return joined(
        [
            ("-", Formula(f"Ke{n} eta{n}", rf"\mathbf{{K}}^{{e}}_{{{n}}}\,\eta_{{{n}}}")),
            ("-", Formula(f"De{n} eta{n}'", rf"\mathbf{{D}}^{{e}}_{{{n}}}\,\dot{{\eta}}_{{{n}}}")),
            ("-", Formula(f"Ce{n}^T a{n}", rf"{{\mathbf{{C}}^{{e}}_{{{n}}}}}^{{T}}\,\mathbf{{a}}_{{{n}}}")),
            ("+", Formula(f"Phi{n}^T f{n}", rf"\Phi_{{{n}}}^{{T}}\,\mathbf{{f}}_{{{n}}}")),
        ]
    )


def recursion(graph: Graph) -> DocumentSection:
    """Fig. 6 (a)-(e) of every body, parents before children, with the corrected sign of (d)."""
    groups = []
    for i, link in enumerate(graph.links):
        n, p = i + 1, link.parent + 1
        moves = link.v.stop > link.v.start
        v, a, S = sym("v", n), sym("a", n), sym("S", n)
        moved, gained = ([("+", _product(S, sym("q", n, dots=dots)))] if moves else [] for dots in (1, 2))
        changing = [("+", _product(sym("S", n, dots=1), sym("q", n, dots=1)))] if moves else []
        wrench = _product(sym("I", n), a) + " + " + dual_cross(v, _product(sym("I", n), v))
        children = [("+", sym("f", j + 1, "c")) for j, k in enumerate(graph.links) if k.parent == i]
        equations = [
            Equation(v, joined([("+", sym("v", p)), *moved] if p else moved), "(a)"),
            Equation(a, joined([("+", sym("a", p)), *gained, *changing]), "(b)"),
            Equation(sym("f", n, "B"), wrench, "(c)"),
            Equation(sym("f", n, "c"), joined([("+", sym("f", n, "B")), ("-", sym("f", n, "e")), *children]), "(d)"),
        ]
        if moves:
            equations.append(Equation(sym("tau", n), _product(transposed(S), sym("f", n, "c")), "(e)"))
        groups.append((f"({n}) {link.body.name} on {graph.links[link.parent].body.name if p else WORLD}", equations))
    return DocumentSection(
        "recursion",
        (
            "Fig. 6 of the paper with the sign of (d) corrected, six components, world axes about the tree's point;",
            "a0 = -g (the ground accelerates upwards), fe the applied wrench (M + r x F, F)",
            *_water(graph, "I holds the added mass of the water, on which g does not act: of"),
        ),
        equations=groups,
    )
