"""Formulas that are written once and read twice: as plain text and as LaTeX.

The symbols are the paper's: v, a, f six components of velocity, acceleration and force; S, I, T as there; bodies and
joints carry the numbers of the graph, laws their names.
"""

from __future__ import annotations

from typing import NamedTuple

_DOTS = {0: ("", "{}"), 1: ("'", r"\dot{{{}}}"), 2: ('"', r"\ddot{{{}}}")}
_GREEK = {"tau": r"\tau", "omega": r"\omega", "w": r"\omega", "lambda": r"\lambda", "mu": r"\mu"}
_SPECIAL = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}


class Formula(NamedTuple):
    """The same formula in both notations."""

    text: str
    latex: str

    def __add__(self, other: object) -> Formula:
        o = other if isinstance(other, Formula) else plain(str(other))
        return Formula(self.text + o.text, self.latex + o.latex)


def plain(s: str) -> Formula:
    """Signs and numbers that look alike in both."""
    return Formula(s, s)


def sym(base: str, index: object = "", mark: str = "", dots: int = 0, bold: bool = True) -> Formula:
    """A quantity: sym("F", 3, "c") is Fc3, F with c above and 3 below."""
    letter = _GREEK.get(base, base)
    core = _DOTS[dots][1].format(rf"\mathbf{{{letter}}}" if bold and base not in _GREEK else letter)
    above = rf"^{{{mark}}}" if mark else ""
    below = rf"_{{{index}}}" if index != "" else ""
    return Formula(f"{base}{mark}{index}{_DOTS[dots][0]}", core + above + below)


def law(base: str, name: str, bold: bool = False, dots: int = 0) -> Formula:
    """A quantity of a law or of a point of it: T(H1)."""
    letter = _GREEK.get(base, base)
    core = _DOTS[dots][1].format(rf"\mathbf{{{letter}}}" if bold else letter)
    return Formula(f"{base}({name}){_DOTS[dots][0]}", rf"{core}_{{\text{{{escaped(name)}}}}}")


def cross(a: Formula, b: Formula) -> Formula:
    return a + Formula(" x ", r" \times ") + b


def dual_cross(a: Formula, b: Formula) -> Formula:
    """v x* f of spatial vectors."""
    return a + Formula(" x* ", r" \times^{*} ") + b


def transposed(a: Formula) -> Formula:
    return Formula(f"{a.text}^T", f"{{{a.latex}}}^{{T}}")


def joined(terms: list[tuple[str, Formula]]) -> Formula:
    """A sum of signed terms; 0 if there is none."""
    out: Formula | None = None
    for sign, term in terms:
        lead = ("-" if sign == "-" else "") if out is None else f" {sign} "
        out = (out or plain("")) + lead + term
    return out or plain("0")


def escaped(s: str) -> str:
    """Text in LaTeX."""
    return "".join(_SPECIAL.get(c, rf"\{c}" if c in "#$%&_{}" else c) for c in s)
