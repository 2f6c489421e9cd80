"""The system of equations that a formulation makes of the bodies and joints, in a few lines."""

from heavylift.kernel.multibody.graph import Graph

from .document import DocumentSection, Equation, Formula

# left and right, each as text and as LaTeX, and a remark
_Row = tuple[str, str, str, str, str]
_ROWS: dict[str, tuple[_Row, ...]] = {
    "recursive": (
        ("Ic_k", r"\mathbf{I}^{c}_k", "sum of T_ik I_i over i", r"\textstyle\sum_i T_{ik}\,\mathbf{I}_i", ""),
        ("H_kl", "H_{kl}", "S_l^T Ic_k S_k", r"\mathbf{S}_l^T\,\mathbf{I}^{c}_k\,\mathbf{S}_k", "l on the path of k"),
        ('H q"', r"\mathbf{H}\,\ddot{\mathbf{q}}", "tau - S^T f", r"\tau - \mathbf{S}^T\,\mathbf{f}", 'fc with q" = 0'),
        ("H", r"\mathbf{H}", "L^T D L", r"\mathbf{L}^T\,\mathbf{D}\,\mathbf{L}", "without fill-in along the paths"),
    ),
    "articulated": (
        (
            "IA_i",
            r"\mathbf{I}^{A}_i",
            "I_i + sum over children (IA - U D^-1 U^T)",
            r"\mathbf{I}_i + \textstyle\sum_{\mathrm{children}}"
            r" (\mathbf{I}^{A} - \mathbf{U}\,\mathbf{D}^{-1}\,\mathbf{U}^T)",
            "",
        ),
        ("U", r"\mathbf{U}", "IA S", r"\mathbf{I}^{A}\,\mathbf{S}", ""),
        ("D", r"\mathbf{D}", "S^T U", r"\mathbf{S}^T\,\mathbf{U}", ""),
        (
            'q"',
            r"\ddot{\mathbf{q}}",
            "D^-1 (tau - S^T pA - U^T a)",
            r"\mathbf{D}^{-1}\,(\tau - \mathbf{S}^T\,\mathbf{p}^{A} - \mathbf{U}^T\,\mathbf{a})",
            "",
        ),
    ),
    "embedding": (
        ("V", r"\mathbf{V}", "R q'", r"\mathbf{R}\,\dot{\mathbf{q}}", ""),
        ("R", r"\mathbf{R}", "T^T S", r"\mathbf{T}^T\,\mathbf{S}", "row i: the columns of the joints on its path"),
        (
            'R^T M R q"',
            r"\mathbf{R}^T\,\mathbf{M}\,\mathbf{R}\,\ddot{\mathbf{q}}",
            "tau - R^T f",
            r"\tau - \mathbf{R}^T\,\mathbf{f}",
            'f = fB - fe with q" = 0',
        ),
    ),
    "augmented": (
        (
            "[M J^T; J 0] [x; -lambda]",
            r"\begin{bmatrix} \mathbf{M} & \mathbf{J}^T \\ \mathbf{J} & \mathbf{0} \end{bmatrix}"
            r" \begin{bmatrix} \mathbf{x} \\ -\lambda \end{bmatrix}",
            "[S tau - f; 0]",
            r"\begin{bmatrix} \mathbf{S}\,\tau - \mathbf{f} \\ \mathbf{0} \end{bmatrix}",
            'x = a - a(q" = 0), f = fB - fe with q" = 0',
        ),
        (
            "J x",
            r"\mathbf{J}\,\mathbf{x}",
            "B_i^T (x_i - x_parent)",
            r"\mathbf{B}_i^T\,(\mathbf{x}_i - \mathbf{x}_{\mathrm{parent}})",
            "rows of joint i, B_i orthogonal to S_i",
        ),
    ),
}


_LOOPS: tuple[_Row, ...] = (
    (
        'H q"',
        r"\mathbf{H}\,\ddot{\mathbf{q}}",
        "tau - S^T f + G^T lambda",
        r"\tau - \mathbf{S}^T\,\mathbf{f} + \mathbf{G}^T\,\lambda",
        "with the rows G of the loops",
    ),
    (
        "G H^-1 G^T lambda",
        r"\mathbf{G}\,\mathbf{H}^{-1}\,\mathbf{G}^T\,\lambda",
        "-b - G H^-1 (tau - S^T f)",
        r"-\mathbf{b} - \mathbf{G}\,\mathbf{H}^{-1}\,(\tau - \mathbf{S}^T\,\mathbf{f})",
        'b their accelerations with q" = 0; redundant rows share by least squares',
    ),
)


def formulation_section(graph: Graph, formulation: str) -> DocumentSection:
    """What is solved for the accelerations."""
    n, n_v = len(graph.links), graph.nv
    message = {
        "recursive": f"{n_v} accelerations from {n} composite inertias, which are sums along the paths of T",
        "articulated": "one pass inwards and one outwards; no matrix is larger than six by six",
        "embedding": f"constraint forces vanish by projection: {6 * n} velocities of bodies become {n_v} of joints",
        "augmented": f"{6 * n} accelerations of bodies in absolute coordinates and {6 * n - n_v} multipliers",
    }[formulation]
    rows = _ROWS[formulation] + (_LOOPS if graph.loops else ())
    equations = [Equation(Formula(a, b), Formula(c, d), e) for a, b, c, d, e in rows]
    return DocumentSection(f"formulation: {formulation}", (message,), equations=[("", equations)])
