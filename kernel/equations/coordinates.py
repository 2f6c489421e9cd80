"""Printed equations of a scene in coordinates: the traced equations before any elimination, every quantity named.

They are printed from the same traced code that becomes machine code, so print and motion cannot differ.
"""

import re
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from heavylift.kernel.compiler.function import symbols
from heavylift.kernel.compiler.symbol import ExpressionGraph as Trace, Scalar, Sym, is_sym
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.model.evaluation import evaluate
from heavylift.kernel.model.program import Program
from heavylift.kernel.multibody.graph import coordinate_names
from heavylift.kernel.multibody.trees import Tree, with_numbers

from .document import DocumentSection, Equation, Formula, escaped

_INFIX = {"add": ("+", 1), "sub": ("-", 1), "mul": ("*", 2), "div": ("/", 2), "gt": (">", 0), "ge": (">=", 0)}
_SHORT = {"mass": "m", "com": "c", "inertia": "I", "p_PJ": "p", "R_PJ": "Rj", "axes": "e", "pitch": "h"}
_XYZ = "xyz"
_SUPPORT = "a.x a.y a.z height k d mu kt dt closed stick x0.x x0.y dir.x dir.y"
_NUMBERS: dict[str, tuple[str, ...]] = {  # of the laws, as `parameters` lays them out
    "rope": ("EA", "c", "hooked", "taut"),
    "support": tuple(_SUPPORT.split()),
    "spring": ("k", "d", "rest"),
    "stop": ("lower", "upper", "k", "d", "low", "up"),
    "brake": ("moment", "k", "d", "engaged", "stick", "q0", "dir"),
    "drive": ("kp", "kv"),
    "reference": ("start", "s0", "v0", "a1", "t1", "cruise", "a2", "t2"),
}
_ROPE_LINE = "a#.x a#.y a#.z b#.x b#.y b#.z share#"  # of one line
_LABEL = re.compile(r"^(\w+)\((.*)\)(?:\.(\w+))?$")
_GREEK = {"omega": r"\omega", "tau": r"\tau", "gravity": "g"}
_LATEX = {"add": " + ", "sub": " - ", "mul": r"\,", "gt": " > ", "ge": r" \ge "}


class _Named(Program):
    """A program whose trees share no functions, so that each is printed with its own names."""

    def sharing(self, tree: Tree) -> str:
        return f"{tree.kind} {' '.join(b.name for b in tree.bodies)}"


def coordinates(system: System, formulation: str) -> DocumentSection:
    """Return the printed equations of all named quantities, in the order in which they are computed."""
    program = _Named(system, formulation)
    with Trace(opaque=True) as trace:
        y, P = symbols("y", program.ny), symbols("P", len(program.parameters.initial))
        evaluate(program, symbols("t", 1)[0], y, P)
    names = _input_names(program)
    seen: dict[str, Equation] = {}
    for label, value in trace.equations:
        if label not in seen and (isinstance(value, Sym) or value != 0.0):
            seen[label] = _equation(label, value, names)
    return DocumentSection(
        "in coordinates",
        (
            "printed from the traced text before any elimination; .rx .ry .rz angular, .x .y .z linear components,",
            "R rotation of a body, r its origin from the tree's point, V twist, A acceleration without q\",",
            'f wrench that a body needs beyond what is applied, without q"; H joint-space inertia;',
            "a, b ends of a law on its bodies; ra, pa, va lever from the tree's point, place, velocity of an end;",
            "s reference (of a winch the unstretched length), l length, T tension, N normal force, f force;",
            "m, c, I, p, Rj, e, h mass, centre, inertia, place and frame of the joint, axes, pitch",
        ),
        equations=[("", list(seen.values()))],
    )


def _input_names(program: Program) -> dict[tuple[str, int], str]:
    """Return the printed names of y[i] and P[i]."""
    q, v = coordinate_names(program.graph)
    names = {("y", i): f"q({n})" for i, n in enumerate(q)}
    names |= {("y", program.nq + i): f"v({n})" for i, n in enumerate(v)}
    names[("t", 0)] = "t"
    n_P = len(program.parameters.initial)
    for (kind, name), at in program.parameters.at.items():
        places = range(*at.indices(n_P))
        if kind == "tree":
            tree = program.instances[int(name)][0]
            labels = _tree_names(with_numbers(tree, [f"#{i}" for i in range(len(tree.numbers))]))
        else:
            labels = _law_names(kind, name, len(places))
        names |= {("P", i): label for i, label in zip(places, labels, strict=True)}
    return names


def _law_names(kind: str, name: str, n: int) -> list[str]:
    """Return the printed names of a law's n numbers."""
    known = _NUMBERS.get(kind, ())
    if kind == "rope":
        lines = [_ROPE_LINE.replace("#", str(i + 1)).split() for i in range((n - 4) // 7)]
        known = (*_NUMBERS["rope"], *(x for line in lines for x in line), *["W"] * ((n - 4) % 7))
    if len(known) != n:
        label = f"{kind}({name})" if name else kind
        return [label] if n == 1 else [f"{label}.{j}" for j in range(n)]
    parts = [x.partition(".") for x in known]
    return [f"{base}({name}){dot}{component}" for base, dot, component in parts]


def _tree_names(tree: Tree) -> list[str]:
    """Return the printed names of a tree's numbers; its parameters are "#i"."""
    found: dict[int, str] = {}

    def walk(x: Any, label: str, body: str) -> None:
        if is_dataclass(x):
            for f in fields(x):
                walk(getattr(x, f.name), _SHORT.get(f.name, f.name), body)
            return
        shape = np.shape(x)
        for i, e in enumerate(np.ravel(np.asarray(x, dtype=object)).tolist()):
            if isinstance(e, str) and e.startswith("#"):
                found[int(e[1:])] = f"{label}({body})" + _component(shape, i)

    for b in tree.bodies:
        walk(b, "", b.name)
    return [found[i] for i in range(len(found))]


def _component(shape: tuple[int, ...], i: int) -> str:
    if not shape:
        return ""
    index = np.unravel_index(i, shape)
    if shape[0] == 1:
        index = index[1:]
    small = all(n <= 3 for n in shape)
    return "." + ("".join(_XYZ[int(j)] for j in index) if small else "_".join(str(int(j) + 1) for j in index))


def _equation(label: str, value: Scalar, names: dict[tuple[str, int], str]) -> Equation:
    terms = _terms(value)
    parts = []
    for n, (sign, term) in enumerate(terms):
        lead = f"{sign} " if n else "-" if sign == "-" else ""
        level = 2 if sign == "-" else 1
        parts.append(Formula(lead + _text(term, names, level), lead + _latex(term, names, level)))
    right = Formula(" ".join(p.text for p in parts), " ".join(p.latex for p in parts))
    return Equation(Formula(label, _symbol(label)), right, parts=tuple(_lines(parts)))


def _terms(x: Scalar, sign: str = "+") -> list[tuple[str, Scalar]]:
    """Return the signed terms of a sum in order, so that long sums can be broken into lines."""
    if isinstance(x, Sym) and x.op in ("add", "sub"):
        other = sign if x.op == "add" else ("-" if sign == "+" else "+")
        return _terms(x.args[0], sign) + _terms(x.args[1], other)
    if isinstance(x, Sym) and x.op == "neg":
        return _terms(x.args[0], "-" if sign == "+" else "+")
    return [(sign, x)]


def _lines(parts: list[Formula], width: int = 75) -> list[Formula]:
    """Join parts to lines of at most `width` characters; return [] if one line is enough."""
    lines: list[Formula] = []
    for p in parts:
        if lines and len(lines[-1].text) + len(p.text) < width:
            lines[-1] = Formula(f"{lines[-1].text} {p.text}", f"{lines[-1].latex} {p.latex}")
        else:
            lines.append(p)
    return lines if len(lines) > 1 else []


def _number(x: Scalar) -> str:
    return f"{float(np.float64(x)):.6g}"


def _name(x: Sym, names: dict[tuple[str, int], str]) -> str:
    block, i = x.args
    return names.get((block, i), block if i < 0 else f"{block}[{i}]")


def _text(x: Scalar, names: dict[tuple[str, int], str], level: int = 0) -> str:
    """Return a traced value as infix text; `level`: binding strength of the operator around it."""
    if not isinstance(x, Sym):
        return _number(x)
    if x.op == "in":
        return _name(x, names)
    if x.op == "neg":
        return "-" + _text(x.args[0], names, 3)
    if x.op not in _INFIX:
        op, args = _function(x)
        return f"{op}({', '.join(_text(a, names) for a in args)})"
    (sign, power), (a, b) = _INFIX[_operation(x)], _operands(x)
    between = sign if power == 2 else f" {sign} "
    s = f"{_text(a, names, power)}{between}{_text(b, names, power + (sign in '-/'))}"
    return f"({s})" if power < level else s


def _function(x: Sym) -> tuple[str, tuple[Scalar, ...]]:
    """Return operation and operands; a selection that gives the maximum or minimum is named "max" or "min"."""
    if x.op == "select" and is_sym(c := x.args[0]) and c.op == "gt":
        if _same(c.args, x.args[1:]):
            return "max", x.args[1:]
        if _same(c.args, x.args[:0:-1]):
            return "min", x.args[1:]
    return x.op, x.args


def _same(a: tuple[Scalar, ...], b: tuple[Scalar, ...]) -> bool:
    return all(x is y if isinstance(x, Sym) or is_sym(y) else x == y for x, y in zip(a, b, strict=True))


def _inverse(x: Scalar) -> bool:
    return isinstance(x, Sym) and x.op == "div" and not is_sym(x.args[0]) and x.args[0] == 1.0


def _operation(x: Sym) -> str:
    """Return the operation; a product with a reciprocal is "div"."""
    return "div" if x.op == "mul" and any(map(_inverse, x.args)) else str(x.op)


def _operands(x: Sym) -> tuple[Scalar, Scalar]:
    """Return the operands in printing order: constants first, divisors last."""
    a, b = x.args
    if x.op != "mul":
        return a, b
    if _inverse(a) and not _inverse(b):
        a, b = b, a
    if _inverse(b):
        return a, b.args[1]
    return (b, a) if not is_sym(b) else (a, b)


def _latex(x: Scalar, names: dict[tuple[str, int], str], level: int = 0) -> str:
    """Return a traced value in LaTeX; arguments as of `_text`."""
    if not isinstance(x, Sym):
        mantissa, _, exponent = _number(x).partition("e")
        return mantissa + (rf" \cdot 10^{{{int(exponent)}}}" if exponent else "")
    if x.op == "in":
        return _symbol(_name(x, names))
    if x.op == "neg":
        return "-" + _latex(x.args[0], names, 3)
    if _operation(x) == "div":
        over, under = (_latex(e, names) for e in _operands(x))
        return rf"\frac{{{over}}}{{{under}}}"
    if x.op == "sqrt":
        return rf"\sqrt{{{_latex(x.args[0], names)}}}"
    op, args = _function(x)
    if op == "select":
        c, a, b = (_latex(e, names) for e in args)
        return rf"\begin{{cases}} {a} & {c} \\ {b} & \text{{else}} \end{{cases}}"
    if x.op not in _INFIX:
        inner = ", ".join(_latex(a, names) for a in args)
        return rf"\operatorname{{{escaped(op)}}}({inner})"
    power = _INFIX[x.op][1]
    left, right = _operands(x)
    s = f"{_latex(left, names, power)}{_LATEX[x.op]}{_latex(right, names, power + (x.op == 'sub'))}"
    return f"({s})" if power < level else s


def _symbol(label: str) -> str:
    """Return a label such as V(link-1).rx as a LaTeX symbol with indices."""
    found = _LABEL.match(label)
    if not found:
        return _GREEK.get(label, label if label.isalnum() else rf"\text{{{escaped(label)}}}")
    base, name, component = found.groups()
    above = rf"^{{{escaped(component)}}}" if component else ""
    letter = _GREEK.get(base, base if len(base) == 1 else rf"\mathrm{{{escaped(base)}}}")
    return rf"{letter}_{{\text{{{escaped(name)}}}}}{above}"
