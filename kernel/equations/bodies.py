"""Printed equations of every body: (1) to (4) of Ku et al. (2012) with all applied forces, the recursion of Fig. 6
there, and the joints.

Force: m_i r"_i = F_i + Fc_i minus the joint forces that row i of T^-T subtracts. The moment balance about the centre of
mass has the same terms with the levers of those forces.

For every joint: its columns of S, and the forces along its coordinates.
"""

from heavylift.kernel.description.mechanics import JOINTS, THIRD, WORLD, System
from heavylift.kernel.multibody.graph import Graph, Link, children_of

from .document import DocumentSection, Equation, Formula, cross, dual_cross, joined, law, plain, sym, transposed
from .laws import Acting, loops_at


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
    """Return the printed balance of force and moment of every body, including its applied force and moment."""
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
            *_shared(graph),
        ),
        equations=groups,
    )


def _water(graph: Graph, message: str) -> tuple[str, ...]:
    """Return a sentence that names the bodies with added mass, if there are any."""
    names = [link.body.name for link in graph.links if link.body.added is not None]
    return (f"{message} {', '.join(names)}",) if names else ()


def _shared(graph: Graph) -> tuple[str, ...]:
    """Return a sentence for each pair of bodies that share water."""
    pairs = [(link.body.name, x.beside) for link in graph.links if (x := link.body.shared)]
    return tuple(
        f"{a} and {b} share water: on each also acts C a + v x* (C v) with a, v of the other" for a, b in pairs
    )


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
    """Return the printed recursive equations of motion of every body, parents before children.

    Ku et al. 2012, Fig. 6 (a)-(e), with the sign of (d) corrected.
    """
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


_AXES = "est"  # letters of axis, second, and axis x second


def joints(system: System, graph: Graph) -> DocumentSection:
    """Return the printed coordinates, velocity columns S and joint forces tau of all joints."""
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
    """Return S of a joint, column by column."""
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
    """Return the equation of tau: the sum of the laws along each coordinate, or the force of a prescribed drive."""
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
