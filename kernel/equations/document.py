"""Parts of the printed document: sections of sentences, tables and equations, as plain text or as LaTeX.

Each formula is defined once, in both notations. The symbols are the paper's: v, a, f six components of velocity,
acceleration and force; S, I, T as there; bodies and joints carry the numbers of the graph, laws their names.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

from heavylift.kernel.multibody.graph import Graph

_DOTS = {0: ("", "{}"), 1: ("'", r"\dot{{{}}}"), 2: ('"', r"\ddot{{{}}}")}
_GREEK = {"tau": r"\tau", "omega": r"\omega", "w": r"\omega", "lambda": r"\lambda", "mu": r"\mu"}
_SPECIAL = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}


class Formula(NamedTuple):
    """A formula in two notations: plain text and LaTeX."""

    text: str
    latex: str

    def __add__(self, other: object) -> "Formula":
        o = other if isinstance(other, Formula) else plain(str(other))
        return Formula(self.text + o.text, self.latex + o.latex)


def plain(s: str) -> Formula:
    """Return a formula whose plain text is also its LaTeX."""
    return Formula(s, s)


def sym(base: str, index: object = "", mark: str = "", dots: int = 0, bold: bool = True) -> Formula:
    """Return a symbol with index and superscript as a formula: sym("F", 3, "c") is Fc3."""
    letter = _GREEK.get(base, base)
    core = _DOTS[dots][1].format(rf"\mathbf{{{letter}}}" if bold and base not in _GREEK else letter)
    above = rf"^{{{mark}}}" if mark else ""
    below = rf"_{{{index}}}" if index != "" else ""
    return Formula(f"{base}{mark}{index}{_DOTS[dots][0]}", core + above + below)


def law(base: str, name: str, bold: bool = False, dots: int = 0) -> Formula:
    """Return the symbol of a quantity of a named force law or point as a formula, such as T(H1)."""
    letter = _GREEK.get(base, base)
    core = _DOTS[dots][1].format(rf"\mathbf{{{letter}}}" if bold else letter)
    return Formula(f"{base}({name}){_DOTS[dots][0]}", rf"{core}_{{\text{{{escaped(name)}}}}}")


def cross(a: Formula, b: Formula) -> Formula:
    return a + Formula(" x ", r" \times ") + b


def dual_cross(a: Formula, b: Formula) -> Formula:
    """Return the spatial cross product v x* f of two formulas."""
    return a + Formula(" x* ", r" \times^{*} ") + b


def transposed(a: Formula) -> Formula:
    return Formula(f"{a.text}^T", f"{{{a.latex}}}^{{T}}")


def joined(terms: list[tuple[str, Formula]]) -> Formula:
    """Return the sum of signed terms as a formula; 0 if there are no terms."""
    out: Formula | None = None
    for sign, term in terms:
        lead = ("-" if sign == "-" else "") if out is None else f" {sign} "
        out = (out or plain("")) + lead + term
    return out or plain("0")


def escaped(s: str) -> str:
    """Return a text with the special characters of LaTeX escaped."""
    return "".join(_SPECIAL.get(c, rf"\{c}" if c in "#$%&_{}" else c) for c in s)


PREAMBLE = r"""\documentclass[10pt]{article}
\usepackage[T1]{fontenc}
\usepackage[utf8]{inputenc}
\usepackage[a3paper,landscape,margin=18mm]{geometry}
\usepackage{amsmath}
\usepackage{longtable}
\allowdisplaybreaks
\setcounter{MaxMatrixCols}{400}
\setlength{\parindent}{0pt}
\begin{document}
"""
PER_BLOCK = 40  # equations in one align environment, which TeX reads as a whole


@dataclass(frozen=True)
class Equation:
    """A printed equation left = right with a remark; `parts`: terms of a long sum, between which a line may break."""

    left: Formula
    right: Formula
    remark: str = ""
    parts: tuple[Formula, ...] = ()


@dataclass(frozen=True)
class DocumentSection:
    """A section of the printed equations: title, sentences, table rows (header first), matrix, titled equations."""

    title: str
    sentences: tuple[str, ...] = ()
    table: tuple[tuple[str, ...], ...] = ()
    matrix: tuple[tuple[str, ...], ...] = ()
    equations: list[tuple[str, list[Equation]]] = field(default_factory=list)


def as_text(sections: list[DocumentSection]) -> str:
    """Return the sections of the printed equations as plain text, one below the other."""
    return "\n\n".join("\n".join(_text(s)) for s in sections)


def _text(s: DocumentSection) -> list[str]:
    lines = ["  ".join([s.title.upper(), *s.sentences[:1]]), *s.sentences[1:]]
    if s.table:
        widths = [max(len(r[c]) for r in s.table) for c in range(len(s.table[0]))]
        lines += ["  ".join(x.ljust(w) for x, w in zip(r, widths, strict=True)).rstrip() for r in s.table]
    lines += ["  " + " ".join(row) for row in s.matrix]
    for heading, equations in s.equations:
        lines += [f"  {heading}"] * bool(heading)
        width = max((len(e.left.text) + len(e.right.text) for e in equations if e.remark), default=0)
        for e in equations:
            line = f"{e.left.text} = {e.right.text}"
            lines.append(f"  {'  ' * bool(heading)}" + (f"{line:<{width + 3}}   {e.remark}" if e.remark else line))
    return lines


def as_latex(sections: list[DocumentSection], title: str) -> str:
    """Return the sections of the printed equations as a LaTeX document that needs amsmath only."""
    body = [PREAMBLE + rf"\section*{{{escaped(title)}}}"]
    for s in sections:
        body.append(rf"\subsection*{{{escaped(s.title)}}}")
        body += [" ".join(escaped(x) for x in s.sentences)] if s.sentences else []
        body += _latex_table(s.table) if s.table else []
        if s.matrix:
            rows = " \\\\\n".join(" & ".join(r) for r in s.matrix)
            matrix = "\\begin{bmatrix}\n" + rows + "\n\\end{bmatrix}"
            body.append("\\begin{equation*}\n\\mathbf{T} = " + matrix + "\n\\end{equation*}")
        for heading, equations in s.equations:
            body += [rf"\paragraph{{{escaped(heading)}}}"] if heading else []
            for i in range(0, len(equations), PER_BLOCK):
                lines = " \\\\\n".join(map(_latex, equations[i : i + PER_BLOCK]))
                body.append("\\begin{align*}\n" + lines + "\n\\end{align*}")
    return "\n\n".join(body) + "\n\n\\end{document}\n"


def _latex(e: Equation) -> str:
    remark = rf" && \text{{{escaped(e.remark)}}}" if e.remark else ""
    if not e.parts:
        return f"{e.left.latex} &= {e.right.latex}{remark}"
    first, *rest = e.parts
    return f"{e.left.latex} &= {first.latex}" + "".join(rf" \\ &\quad {p.latex}" for p in rest) + remark


def _latex_table(rows: tuple[tuple[str, ...], ...]) -> list[str]:
    lines = [" & ".join(map(escaped, r)) + r" \\" for r in rows]
    columns = "l" * len(rows[0])
    return ["\n".join([rf"\begin{{longtable}}{{{columns}}}", lines[0], r"\hline", *lines[1:], r"\end{longtable}"])]


# left and right, each as text and as LaTeX, and a remark
_Row = tuple[str, str, str, str, str]
_ROWS: dict[str, tuple[_Row, ...]] = {
    "recursive": (
        ("Ic_k", r"\mathbf{I}^{c}_k", "sum of T_ik I_i over i", r"\textstyle\sum_i T_{ik}\,\mathbf{I}_i", ""),
        ("H_kl", "H_{kl}", "S_l^T Ic_k S_k", r"\mathbf{S}_l^T\,\mathbf{I}^{c}_k\,\mathbf{S}_k", "l on the path of k"),
        ('H q"', r"\mathbf{H}\,\ddot{\mathbf{q}}", "tau - S^T f", r"\tau - \mathbf{S}^T\,\mathbf{f}",
         'fc with q" = 0'),
        ("H", r"\mathbf{H}", "L^T D L", r"\mathbf{L}^T\,\mathbf{D}\,\mathbf{L}", "without fill-in along the paths"),
    ),
    "articulated": (
        ("IA_i", r"\mathbf{I}^{A}_i", "I_i + sum over children (IA - U D^-1 U^T)",
         r"\mathbf{I}_i + \textstyle\sum_{\mathrm{children}}"
         r" (\mathbf{I}^{A} - \mathbf{U}\,\mathbf{D}^{-1}\,\mathbf{U}^T)",
         ""),
        ("U", r"\mathbf{U}", "IA S", r"\mathbf{I}^{A}\,\mathbf{S}", ""),
        ("D", r"\mathbf{D}", "S^T U", r"\mathbf{S}^T\,\mathbf{U}", ""),
        ('q"', r"\ddot{\mathbf{q}}", "D^-1 (tau - S^T pA - U^T a)",
         r"\mathbf{D}^{-1}\,(\tau - \mathbf{S}^T\,\mathbf{p}^{A} - \mathbf{U}^T\,\mathbf{a})", ""),
    ),
    "embedding": (
        ("V", r"\mathbf{V}", "R q'", r"\mathbf{R}\,\dot{\mathbf{q}}", ""),
        ("R", r"\mathbf{R}", "T^T S", r"\mathbf{T}^T\,\mathbf{S}", "row i: the columns of the joints on its path"),
        ('R^T M R q"', r"\mathbf{R}^T\,\mathbf{M}\,\mathbf{R}\,\ddot{\mathbf{q}}", "tau - R^T f",
         r"\tau - \mathbf{R}^T\,\mathbf{f}", 'f = fB - fe with q" = 0'),
    ),
    "augmented": (
        ("[M J^T; J 0] [x; -lambda]",
         r"\begin{bmatrix} \mathbf{M} & \mathbf{J}^T \\ \mathbf{J} & \mathbf{0} \end{bmatrix}"
         r" \begin{bmatrix} \mathbf{x} \\ -\lambda \end{bmatrix}",
         "[S tau - f; 0]", r"\begin{bmatrix} \mathbf{S}\,\tau - \mathbf{f} \\ \mathbf{0} \end{bmatrix}",
         'x = a - a(q" = 0), f = fB - fe with q" = 0'),
        ("J x", r"\mathbf{J}\,\mathbf{x}", "B_i^T (x_i - x_parent)",
         r"\mathbf{B}_i^T\,(\mathbf{x}_i - \mathbf{x}_{\mathrm{parent}})", "rows of joint i, B_i orthogonal to S_i"),
    ),
}  # fmt: skip


_LOOPS: tuple[_Row, ...] = (
    ('H q"', r"\mathbf{H}\,\ddot{\mathbf{q}}", "tau - S^T f + G^T lambda",
     r"\tau - \mathbf{S}^T\,\mathbf{f} + \mathbf{G}^T\,\lambda", "with the rows G of the loops"),
    ("G H^-1 G^T lambda", r"\mathbf{G}\,\mathbf{H}^{-1}\,\mathbf{G}^T\,\lambda", "-b - G H^-1 (tau - S^T f)",
     r"-\mathbf{b} - \mathbf{G}\,\mathbf{H}^{-1}\,(\tau - \mathbf{S}^T\,\mathbf{f})",
     'b their accelerations with q" = 0; redundant rows share by least squares'),
)  # fmt: skip


def formulation_section(graph: Graph, formulation: str) -> DocumentSection:
    """Return the section that prints the linear system which the formulation solves for the accelerations."""
    n, n_v = len(graph.links), graph.nv
    sentence = {
        "recursive": f"{n_v} accelerations from {n} composite inertias, which are sums along the paths of T",
        "articulated": "one pass inwards and one outwards; no matrix is larger than six by six",
        "embedding": f"constraint forces vanish by projection: {6 * n} velocities of bodies become {n_v} of joints",
        "augmented": f"{6 * n} accelerations of bodies in absolute coordinates and {6 * n - n_v} multipliers",
    }[formulation]
    rows = _ROWS[formulation] + (_LOOPS if graph.loops else ())
    equations = [Equation(Formula(a, b), Formula(c, d), e) for a, b, c, d, e in rows]
    return DocumentSection(f"formulation: {formulation}", (sentence,), equations=[("", equations)])
