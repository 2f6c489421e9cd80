"""The equations of motion of a scene as text: graph, path matrix, the balance of every body, the recursion.

The balance of body i is the paper's eqs (1)-(4): m_i r"_i = F_i + F_c,i - the joint forces that row i of T^-T
subtracts.  The recursion below it is printed from the traced text itself, before any elimination, every quantity
named.  Planar arms print two lines a body in the paper; here the moment equation stands beside each force equation.
"""

from __future__ import annotations

import numpy as np

from .describe import WORLD, System
from .function import symbols
from .graph import Graph, children_of
from .rate import Program
from .symbol import Graph as Trace
from .symbol import Sym, is_sym

__all__ = ["balance", "equations"]

_INFIX = {
    "add": (" + ", 1),
    "sub": (" - ", 1),
    "mul": ("*", 2),
    "div": ("/", 2),
    "gt": (" > ", 0),
    "ge": (" >= ", 0),
}


def equations(system: System) -> str:
    """Everything that is known of the motion of a system, as text; raises KernelError for an impossible one."""
    program = Program(system)
    parts = [
        _graph(program.graph),
        _path_matrix(program.graph),
        _balances(program.graph),
        _recursion(program),
    ]
    return "\n\n".join(parts)


def balance(graph: Graph, i: int) -> str:
    """The force balance of body i (0-based), e.g. m1 r1" = F1 + Fc1 - Fc2 - Fc3."""
    minus = "".join(f" - Fc{j + 1}" for j in children_of(graph.T, i))
    return f'm{i + 1} r{i + 1}" = F{i + 1} + Fc{i + 1}{minus}'


def _graph(graph: Graph) -> str:
    rows = [("", "body", "joint", "kind", "on")]
    for i, k in enumerate(graph.links):
        parent = WORLD if k.parent < 0 else graph.links[k.parent].body.name
        rows.append((str(i + 1), k.body.name, k.joint.name, k.joint.kind, parent))
    for j in graph.loops:
        rows.append(("-", j.child, j.name, j.kind, f"{j.parent} (closes a loop)"))
    widths = [max(len(r[c]) for r in rows) for c in range(5)]
    lines = ["  ".join(x.ljust(w) for x, w in zip(r, widths, strict=True)).rstrip() for r in rows]
    return "GRAPH\n" + "\n".join(lines)


def _path_matrix(graph: Graph) -> str:
    lines = ["PATH MATRIX  T[k, i] = 1: joint i lies on the path from the ground to body k"]
    return "\n".join([*lines, *("  " + " ".join(str(x) for x in row) for row in graph.T)])


def _balances(graph: Graph) -> str:
    lines = [
        "BALANCE OF EACH BODY  r = place of its centre of mass, F = applied force, Fci = force of joint i on body i",
        "(the moment balance has the same terms: I w' + w x I w = M + Mc - ..., about the centre of mass)",
    ]
    n = len(graph.links)
    width = max(len(balance(graph, i)) for i in range(n))
    return "\n".join([*lines, *(f"  {balance(graph, i):<{width}}   ({graph.links[i].body.name})" for i in range(n))])


def _recursion(program: Program) -> str:
    head = [
        "RECURSION  world axes; V twist, A acceleration without joint accelerations, f wrench that a joint must carry,",
        "H joint-space inertia, T tension; q, v state, P parameters; .rx .ry .rz angular, .x .y .z linear components",
        "H v' = tau - S^T f (sums along the paths of T), solved by H = L^T D L",
    ]
    with Trace(opaque=True) as trace:
        y, P = symbols("y", program.ny), symbols("P", len(program.parameters.initial))
        program.evaluate(symbols("t", 1)[0], y, P)
    names = _input_names(program)
    seen: dict[str, str] = {}
    for label, value in trace.equations:
        seen.setdefault(label, text(value, names))
    return "\n".join([*head, *(f"  {a} = {b}" for a, b in seen.items() if b != "0")])


def _input_names(program: Program) -> dict[tuple[str, int], str]:
    """What stands for y[i] and P[i] in print."""
    from .samples import coordinate_names

    q, v = coordinate_names(program.graph)
    names = {("y", i): f"q({n})" for i, n in enumerate(q)}
    names |= {("y", program.nq + i): f"v({n})" for i, n in enumerate(v)}
    names[("t", 0)] = "t"
    for (kind, name), at in program.parameters.at.items():
        label = f"{kind}({name})" if name else kind
        if kind == "tree":
            first = program.instances[int(name)][0]
            label = f"P({first.bodies[0].name})"
        places = range(len(program.parameters.initial))[at]
        for j, i in enumerate(places):
            names["P", i] = label if len(places) == 1 else f"{label}.{j}"
    return names


def text(x: object, names: dict[tuple[str, int], str], level: int = 0) -> str:
    """Infix text of a traced value."""
    if not isinstance(x, Sym):
        return f"{float(np.float64(x)):.6g}"  # type: ignore[arg-type]
    if x.op == "in":
        block, i = x.args
        return names.get((block, i), block if i < 0 else f"{block}[{i}]")
    if x.op == "neg":
        return "-" + text(x.args[0], names, 3)
    if x.op in _INFIX:
        sign, power = _INFIX[x.op]
        a, b = x.args
        if x.op == "mul" and not is_sym(b):
            a, b = b, a  # constants first
        s = f"{text(a, names, power)}{sign}{text(b, names, power + (x.op in ('sub', 'div')))}"
        return f"({s})" if power < level else s
    return f"{x.op}({', '.join(text(a, names) for a in x.args)})"
