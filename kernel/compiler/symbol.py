"""Symbolic scalars: a Python function that runs on them records its operations as a graph without duplicates.

The algorithms are written once. On floats they compute; on these symbols the same code is recorded (hash-consing: an
expression exists once; zeros and ones fold away, so sparse 6x6 matrices cost nothing). Rules for traced code: no
`if`/`while` on a value (use `select`), loops over structure only, sqrt from here, sin, cos, atan2 and power from
`elementary`, `d = 1/x` once instead of many divisions. Violations raise TypeError and say what to write instead.
"""

import math
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from numbers import Real
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    import numpy as np

Value = Any  # in traced text: a float or a symbol, or an array of them
_NUMBERS = (float, int, Real)  # among the latter NumPy's, which this file starts without


class _Recording(threading.local):
    """The graphs that a thread is recording, innermost last."""

    def __init__(self) -> None:
        self.graphs: list[ExpressionGraph] = []


RECORDING = _Recording()


def _is_array(x: Any) -> bool:
    return getattr(x, "ndim", 0) > 0


class ExpressionGraph:
    """Graph of the operations recorded while a function is traced; `opaque`: symbols replace named quantities."""

    def __init__(self, opaque: bool = False) -> None:
        self.table: dict[Any, Sym] = {}
        self.nodes: list[Sym] = []
        self.opaque = opaque
        self.equations: list[tuple[str, Any]] = []
        self.scope = ""  # the law whose text is being recorded

    def __enter__(self) -> "ExpressionGraph":
        RECORDING.graphs.append(self)
        return self

    def __exit__(self, *_: object) -> None:
        RECORDING.graphs.pop()


class Sym:
    """A traced value: operation and arguments. `width`: 0 for a scalar, n for a vector of n elements."""

    __slots__ = ("args", "id", "op", "width")
    op: str
    args: tuple[Any, ...]
    id: int
    width: int

    def __neg__(self) -> Any:
        return neg(self)

    def __add__(self, o: Any) -> Any:
        return NotImplemented if _is_array(o) else add(self, o)

    def __sub__(self, o: Any) -> Any:
        return NotImplemented if _is_array(o) else add(self, neg(o))

    def __mul__(self, o: Any) -> Any:
        return NotImplemented if _is_array(o) else mul(self, o)

    def __truediv__(self, o: Any) -> Any:
        return NotImplemented if _is_array(o) else div(self, o)

    __radd__, __rmul__ = __add__, __mul__

    def __rsub__(self, o: Any) -> Any:
        return add(neg(self), o)

    def __rtruediv__(self, o: Any) -> Any:
        return div(o, self)

    def __pow__(self, o: float) -> Any:
        if not (isinstance(o, int | float) and o in range(1, 9)):
            raise TypeError(
                "traced code allows ** 1 to ** 8 only; else call power() of heavylift.kernel.forces.mathematics"
            )
        return self if o == 1 else mul(self, self ** (o - 1))

    def __abs__(self) -> Any:
        return node("abs", self)

    def __matmul__(self, o: "Sym") -> "Sym":
        return node("dot", self, o)

    def __gt__(self, o: Any) -> Any:
        return node("gt", self, o)

    def __lt__(self, o: Any) -> Any:
        return node("gt", o, self)

    def __ge__(self, o: Any) -> Any:
        return node("ge", self, o)

    def __le__(self, o: Any) -> Any:
        return node("ge", o, self)

    def __and__(self, o: Any) -> Any:
        return node("and", self, o)

    def __or__(self, o: Any) -> Any:
        return node("or", self, o)

    def __eq__(self, o: object) -> bool:
        if isinstance(o, Sym):
            return self is o  # the node table needs identity
        raise TypeError("== with a run-time value would silently be False in traced code: use select with > or >=")

    __hash__ = object.__hash__

    def __bool__(self) -> bool:
        raise TypeError("traced code cannot branch on a value known only at run time: use select(condition, a, b)")

    def __float__(self) -> float:
        raise TypeError(
            "traced code cannot convert to float; call sin(), sqrt() and others of heavylift.kernel.forces.mathematics"
        )


Scalar: TypeAlias = "float | Sym"  # a number, or what a traced text will have for it
Array: TypeAlias = "np.ndarray[Any, np.dtype[Any]]"  # of such
Scalars: TypeAlias = "np.ndarray[Any, np.dtype[Any]] | Sequence[float | Sym]"  # one behind the other


_PLAIN = {float, int, bool, Sym}  # scalars, seen at a glance


def is_sym(x: Any) -> bool:
    return type(x) is Sym


def node(op: str, *args: Any, width: int | None = None) -> Sym:
    """Return the node of an operation in the graph being traced; it is created if it does not exist yet."""
    graph = RECORDING.graphs[-1]
    if (found := graph.table.get((op, args))) is not None:  # equal numbers of different types are one key
        return found
    number = int if op in ("in", "ret", "slice") else float
    plain: list[Any] = []
    widest = 0
    for x in args:
        if type(x) is Sym:
            if x.width > widest:
                widest = x.width
        elif type(x) is not number and isinstance(x, _NUMBERS):
            x = number(x)  # type: ignore[arg-type]
        plain.append(x)
    n = Sym()
    n.op, n.args, n.id = op, tuple(plain), len(graph.nodes)
    graph.table[op, n.args] = n
    n.width = width if width is not None else 0 if op == "dot" else widest
    graph.nodes.append(n)
    return n


def neg(x: Any) -> Any:
    return -x if not is_sym(x) else x.args[0] if x.op == "neg" else node("neg", x)


def add(a: Any, b: Any) -> Any:
    if not is_sym(a):
        a, b = b, a
    if not is_sym(b):
        return a if b == 0 else node("add", a, b)
    a_negative, b_negative = a.op == "neg", b.op == "neg"
    if a_negative and b_negative:
        return neg(add(a.args[0], b.args[0]))
    if a_negative:
        a, b, b_negative = b, a, True
    if b_negative:
        return 0.0 if a is b.args[0] else node("sub", a, b.args[0])
    return node("add", a, b) if a.id < b.id else node("add", b, a)


def mul(a: Any, b: Any) -> Any:
    if not is_sym(a):
        a, b = b, a
    if not is_sym(b):
        if b == 0:
            return 0.0
        if b == 1:
            return a
        if b < 0:
            return neg(mul(a, -b))
    if a.op == "neg":
        return neg(mul(a.args[0], b))
    if is_sym(b) and b.op == "neg":
        return neg(mul(a, b.args[0]))
    return node("mul", b, a) if is_sym(b) and b.id <= a.id else node("mul", a, b)


def div(a: Any, b: Any) -> Any:
    if not is_sym(b):
        return mul(a, 1.0 / b)
    if not is_sym(a) and a == 0:
        return 0.0
    if is_sym(a) and a.op == "neg":
        return neg(div(a.args[0], b))
    return node("div", a, b)


def sqrt(x: Any) -> Any:
    if is_sym(x):
        return node("sqrt", x)
    if not _is_array(x):
        return math.sqrt(x)
    import numpy as np

    return np.sqrt(x)


def exponent(x: Any) -> Any:
    """Return the binary exponent k of x = m 2^k with 1 <= m < 2, for positive normal x."""
    return node("exponent", x) if is_sym(x) else math.frexp(x)[1] - 1.0


def power_of_two(n: Any) -> Any:
    """Return 2^n for an integer n from -1022 to 1023."""
    return node("power_of_two", n) if is_sym(n) else math.ldexp(1.0, int(n))


def printing(x: Any) -> bool:
    """Return whether x is traced for printed equations, where elementary functions keep their names."""
    return is_sym(x) and RECORDING.graphs[-1].opaque


def _elementwise(f: Callable[..., Any], whole: Callable[..., Any]) -> Callable[..., Any]:
    """Extend the scalar function f to arrays: arrays of symbols element by element, arrays of numbers by `whole`, with
    the same bits."""

    def apply(*args: Any) -> Any:
        if _PLAIN.issuperset(map(type, args)) or not any(map(_is_array, args)):
            return f(*args)
        import numpy as np

        if all(type(x) in _PLAIN or (_is_array(x) and x.dtype != object) for x in args):
            return whole(np, *args)
        spread = np.broadcast_arrays(*args)
        if all(x.dtype != object for x in spread):
            return whole(np, *spread)
        flat = [f(*x) for x in zip(*(x.ravel().tolist() for x in spread), strict=True)]
        return np.array(flat).reshape(spread[0].shape)

    return apply


def _select(condition: Any, a: Any, b: Any) -> Any:
    """Return a if condition else b; both are computed."""
    if not is_sym(condition):
        return a if condition else b
    return a if a is b else node("select", condition, a, b)


select = _elementwise(_select, lambda np, condition, a, b: np.where(condition, a, b))
less = _elementwise(lambda a, b: a < b, lambda np, a, b: a < b)
maximum = _elementwise(lambda a, b: _select(a > b, a, b), lambda np, a, b: np.where(a > b, a, b))
minimum = _elementwise(lambda a, b: _select(b > a, a, b), lambda np, a, b: np.where(b > a, a, b))


def any_of(conditions: Iterable[Any]) -> Any:
    c: Any = False
    for x in conditions:
        c = x if c is False else c | x
    return c


@contextmanager
def scope(name: str) -> Iterator[None]:
    """Context in which named quantities belong to the force law `name` in printed equations."""
    graph = RECORDING.graphs[-1] if RECORDING.graphs else None
    if graph is not None:
        graph.scope = name
    yield
    if graph is not None:
        graph.scope = ""


def named(label: str, x: Any) -> Any:
    """Give a traced quantity x the name `label` in printed equations; return x, or symbols with this name instead."""
    graphs = RECORDING.graphs
    if not graphs or not graphs[-1].opaque:
        return x
    if graphs[-1].scope:
        label = f"{label}({graphs[-1].scope})"
    import numpy as np

    flat = np.ravel(np.asarray(x, dtype=object)).tolist()
    suffix = {1: [""], 3: [".x", ".y", ".z"], 6: [".rx", ".ry", ".rz", ".x", ".y", ".z"]}
    suffix[9] = [f".{a}{b}" for a in "xyz" for b in "xyz"]
    labels = [label + s for s in suffix.get(len(flat), [f".{i}" for i in range(len(flat))])]
    graphs[-1].equations += list(zip(labels, flat, strict=True))
    fresh = [node("in", t, -1) if is_sym(e) else e for t, e in zip(labels, flat, strict=True)]
    return np.array(fresh, dtype=object).reshape(np.shape(x)) if np.shape(x) else fresh[0]
