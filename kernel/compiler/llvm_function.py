"""Translation of one traced function to straight-line LLVM IR, for one call or for several side by side."""

from typing import Any

from .function import Function, placed
from .simd_batches import WIDEST, SimdBatch, arranged, constant, gathered, reference, spread, spread_value, vector_type
from .symbol import Sym, is_sym
from .vector_loops import Wide, is_long

RARE = 300  # instructions of a function that takes little of a run, beyond which it is not optimised

_LOADED = ("in", "slice", "ret")
_ARITHMETIC = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}


def blocks_of(f: Function) -> list[str]:
    """Return the names of the memory blocks of a function in the order of its pointer arguments."""
    return list(dict.fromkeys([*f.inputs, *f.outputs]))


def named_code(f: Function, lanes: int, shared: frozenset[str] = frozenset()) -> str:
    """Return the name of the code for `lanes` SIMD calls of a function; `shared`: their common input blocks."""
    return ".".join([f"{f.name}.x{lanes}", *sorted(shared)]) if lanes else f.name


def _width(x: Any) -> int:
    return max(1, x.width) if is_sym(x) else 1


def _cut(width: int) -> list[tuple[str, int, int]]:
    """Return suffix, offset and lanes of each piece of a wide value."""
    return [(f"_{i}", i * WIDEST, min(WIDEST, width - i * WIDEST)) for i in range(-(-width // WIDEST))]


class StraightLineCode:
    """Straight-line LLVM IR of one traced function, or of `lanes` calls of it in SIMD lanes.

    With `lanes`, each scalar is a vector, and in the blocks the lanes of a number lie next to each other. `fused`:
    products may be added without being rounded, so that the bits depend on the processor. `shared`: input blocks that
    are the same in all lanes.
    """

    def __init__(self, f: Function, lanes: int = 0, fused: bool = False, shared: frozenset[str] = frozenset()) -> None:
        self.f, self.lanes, self.shared = f, lanes, shared
        self.flags = " contract" if fused else ""
        self.head: list[str] = []
        self.body: list[str] = []
        self.vectors = 0
        # functions that this one calls, with how many lanes, and what they share
        self.called: list[tuple[Function, int, frozenset[str]]] = []
        self.lane: dict[Sym, tuple[SimdBatch, int]] = {}  # of calls that are made side by side
        self.loaded: set[Sym] = set()
        self.spreads: dict[tuple[Sym, int], str] = {}

    def text(self) -> str:
        f = self.f
        order = f.nodes if self.lanes else arranged(f.nodes)
        self.wide = Wide(self, f, order)
        for n in order:
            if isinstance(n, SimdBatch):
                self.wide.flush()
                self.batch(n)
            elif not self.wide.later(n):
                self.node(n)
        self.wide.flush()
        self.read_before_written()
        for name, values in f.outputs.items():
            base = f"%{name}"
            if name in f.rows:  # a row of a table
                size = sum(map(_width, values))
                self.body += [
                    f"%row_{name} = fptosi double {self.value(f.rows[name])} to i64",
                    f"%first_{name} = mul i64 %row_{name}, {size}",
                    f"%base_{name} = getelementptr double, ptr %{name}, i64 %first_{name}",
                ]
                base = f"%base_{name}"
            self.store(placed("" if name in f.rows else name, values), base, f"o_{name}")
        parameters = ", ".join(f"ptr noalias %{k}" for k in blocks_of(f))
        attributes = "noinline nounwind" + (" optnone" if f.rare and len(self.body) > RARE else "")
        lines = [
            f"define void @{named_code(f, self.lanes, self.shared)}({parameters}) {attributes} {{",
            *self.head,
            *self.body,
            "ret void",
            "}",
        ]
        return "\n".join(lines)

    def read_before_written(self) -> None:
        """Load all numbers that outputs copy from memory blocks, before an output can overwrite them."""
        for row in self.f.rows.values():
            self.value(row)
        for name, values in self.f.outputs.items():
            for x, kept in placed("" if name in self.f.rows else name, values):
                if is_long(x) and not kept:
                    self.wide.save(x)
                elif not kept:
                    self.value(x)

    def value(self, x: Any, lanes: int = 0) -> str:
        """Return the IR name of a traced value; a number stored in a memory block is loaded on first use."""
        if is_sym(x) and x.op in _LOADED and x not in self.loaded and not is_long(x):
            self.loaded.add(x)
            self.fetch(x)
        return reference(x, lanes)

    def pieces(self, x: Any) -> list[tuple[str, int, int]]:
        """Return the registers of a value x as (name suffix, first index, number of SIMD lanes; 0: a scalar)."""
        return _cut(x.width) if is_sym(x) and x.width else [("", 0, self.lanes)]

    def load(self, n: Sym, base: str, index: int) -> None:
        for piece, offset, lanes in self.pieces(n):
            self.body += [
                f"%g{n.id}{piece} = getelementptr double, ptr {base}, i64 {index * max(1, self.lanes) + offset}",
                f"%t{n.id}{piece} = load {vector_type(lanes)}, ptr %g{n.id}{piece}, align 8",
            ]

    def store(self, values: list[tuple[Any, bool]], base: str, tag: str) -> None:
        """Emit the stores of consecutive values to a memory block, except values that the block holds already."""
        i = 0
        for x, kept in values:
            if is_long(x) and not kept:
                self.wide.copy(x, base, i)
            for piece, offset, lanes in [] if kept or is_long(x) else self.pieces(x):
                value = self.value(x, lanes)
                self.body += [
                    f"%{tag}_{i + offset} = getelementptr double, ptr {base}, i64 {i + offset}",
                    f"store {vector_type(lanes)} {value}{piece}, ptr %{tag}_{i + offset}, align 8",
                ]
            i += _width(x) * max(1, self.lanes)

    def operand(self, x: Any, piece: str, lanes: int) -> str:
        """Return the IR name of the register that holds a part of an operand; scalars are broadcast to all lanes."""
        if not lanes or self.lanes or (is_sym(x) and x.width):
            return self.value(x, self.lanes) + (piece if is_sym(x) and x.width else "")
        if not is_sym(x):
            return constant(x, lanes)
        if (x, lanes) not in self.spreads:
            self.spreads[x, lanes] = spread(self, x, lanes)
        return self.spreads[x, lanes]

    def new(self) -> str:
        """Return an unused IR name for an intermediate vector."""
        self.vectors += 1
        return f"%s{self.vectors}"

    def pointer(self, values: tuple[Any, ...], tag: str) -> str:
        """Return the address of values in consecutive memory; they are copied to the stack if necessary."""
        v: Any = values[0] if values else None
        if is_sym(v) and v.op == "block":
            return f"ptr %{v.args[0]}"
        if is_long(v) and len(values) == 1:
            base, first = self.wide.address(v)
            self.body.append(f"%{tag} = getelementptr double, ptr {base}, i64 {first}")
            return f"ptr %{tag}"
        if (
            is_sym(v)
            and v.op in ("in", "ret", "slice")
            and v.args[0] not in self.lane
            and v.args[0] not in self.shared
            and all(
                is_sym(x) and x.op == v.op and x.args[:-1] == v.args[:-1] and x.args[-1] == v.args[-1] + i
                for i, x in enumerate(values)
            )
        ):
            base = f"%r{v.args[0].id}_{v.args[1]}" if v.op == "ret" else f"%{v.args[0]}"
            self.body.append(f"%{tag} = getelementptr double, ptr {base}, i64 {v.args[-1] * max(1, self.lanes)}")
        else:
            size = max(1, sum(map(_width, values))) * max(1, self.lanes)
            self.head.append(f"%{tag} = alloca [{size} x double], align 64")
            self.store([(x, False) for x in values], f"%{tag}", tag)
        return f"ptr %{tag}"

    def fetch(self, n: Sym) -> None:
        """Emit the load of a number from a block or from the result of a call."""
        a = n.args
        if n.op == "in" and a[0] in self.shared:
            self.body += [
                f"%g{n.id} = getelementptr double, ptr %{a[0]}, i64 {a[1]}",
                f"%u{n.id} = load double, ptr %g{n.id}, align 8",
            ]
            spread_value(self.body, f"%t{n.id}", f"%u{n.id}", self.lanes)
        elif n.op in ("in", "slice"):
            self.load(n, f"%{a[0]}", a[1])
        elif a[0] in self.lane:
            batch, lane = self.lane[a[0]]
            self.load(n, f"%r{batch.name}_{a[1]}", a[2] * batch.width + lane)
        else:
            self.load(n, f"%r{a[0].id}_{a[1]}", a[2])

    def node(self, n: Sym) -> None:
        if n.op in _LOADED or n.op == "block":
            return  # loaded where it is needed, or a pointer that is handed on
        if n.op == "call":
            self.wide.flush()
            self.call(n)
        elif n.op == "dot":
            self.wide.flush()
            self.dot(n)
        else:
            for piece, _, lanes in self.pieces(n):
                self.body.append(f"%t{n.id}{piece} = {self.operation(n, piece, lanes)}")

    def operation(self, n: Sym, piece: str, lanes: int) -> str:
        a, d = n.args, vector_type(lanes)
        x = [self.operand(y, piece, lanes) if not (n.op == "select" and i == 0) else "" for i, y in enumerate(a)]
        if n.op == "select":
            flag = vector_type(lanes if a[0].width or self.lanes else 0, "i1")
            return f"select {flag} {self.value(a[0])}{piece if a[0].width else ''}, {d} {x[1]}, {d} {x[2]}"
        if n.op in ("gt", "ge"):
            return f"fcmp o{n.op} {d} {x[0]}, {x[1]}"
        if n.op in ("and", "or"):
            return f"{n.op} {vector_type(lanes, 'i1')} {x[0]}, {x[1]}"
        if n.op == "neg":
            return f"fneg{self.flags} {d} {x[0]}"
        if n.op in ("exponent", "power_of_two"):
            return self.binary_exponent(n, x[0], lanes)
        if n.op in ("sqrt", "abs"):
            suffix = f"v{lanes}" if lanes else ""
            return f"call {d} @llvm.{'fabs' if n.op == 'abs' else n.op}.{suffix}f64({d} {x[0]})"
        return f"{_ARITHMETIC[n.op]}{self.flags} {d} {x[0]}, {x[1]}"

    def binary_exponent(self, n: Sym, x: str, lanes: int) -> str:
        """Emit code that returns the binary exponent of a double, or a double with a given binary exponent.

        Bits 52 to 62, biased by 1023.
        """
        b, d, i = f"%b{n.id}", vector_type(lanes), vector_type(lanes, "i64")
        bias, shift = (f"<{', '.join([f'i64 {k}'] * lanes)}>" if lanes else str(k) for k in (1023, 52))
        if n.op == "exponent":
            self.body += [f"{b} = bitcast {d} {x} to {i}", f"{b}s = lshr {i} {b}, {shift}"]
            self.body.append(f"{b}k = sub {i} {b}s, {bias}")
            return f"sitofp {i} {b}k to {d}"
        self.body += [f"{b} = fptosi {d} {x} to {i}", f"{b}k = add {i} {b}, {bias}", f"{b}s = shl {i} {b}k, {shift}"]
        return f"bitcast {i} {b}s to {d}"

    def call(self, n: Sym) -> None:
        f, *arguments = n.args
        at = {k: self.pointer(v, f"a{n.id}_{k}") for k, v in zip(f.inputs, arguments, strict=True)}
        self.make_call(f, self.lanes, at, str(n.id))

    def make_call(
        self, f: Function, lanes: int, at: dict[str, str], name: str, shared: frozenset[str] = frozenset()
    ) -> None:
        """Emit a call and reserve stack memory for its results; `at`: pointers to its inputs, by block."""
        for k, v in f.outputs.items():
            size = max(1, sum(map(_width, v))) * max(1, lanes)
            self.head.append(f"%r{name}_{k} = alloca [{size} x double], align 64")
            at[k] = f"ptr %r{name}_{k}"
        self.body.append(f"call void @{named_code(f, lanes, shared)}({', '.join(at[k] for k in blocks_of(f))})")
        self.called.append((f, lanes, shared))

    def batch(self, b: SimdBatch) -> None:
        """Emit one vector call for a batch of scalar calls."""
        at: dict[str, str] = {}
        for i, k in enumerate(b.function.inputs, 1):
            tag = f"a{b.name}_{k}"
            if k in b.shared:
                at[k] = self.pointer(b.calls[0].args[i], tag)
                continue
            rows = list(zip(*(call.args[i] for call in b.lanes), strict=True))
            self.head.append(f"%{tag} = alloca [{max(1, len(rows)) * b.width} x double], align 64")
            for j, values in enumerate(rows):
                v = gathered(self, values)
                self.body += [
                    f"%{tag}_{j} = getelementptr double, ptr %{tag}, i64 {j * b.width}",
                    f"store {vector_type(b.width)} {v}, ptr %{tag}_{j}, align 8",
                ]
            at[k] = f"ptr %{tag}"
        self.make_call(b.function, b.width, at, b.name, b.shared)
        self.lane.update({call: (b, lane) for lane, call in enumerate(b.calls)})

    def dot(self, n: Sym) -> None:
        if is_long(n.args[0]):
            self.wide.dot(n)
            return
        total, t = constant(0.0), f"%t{n.id}"
        pieces = _cut(n.args[0].width)
        last = len(pieces) - 1
        for i, (piece, _, lanes) in enumerate(pieces):
            v, result = vector_type(lanes), t if i == last else f"{t}s{i}"
            a, b = (self.operand(x, piece, lanes) for x in n.args)
            self.body += [
                f"{t}m{i} = fmul {v} {a}, {b}",
                f"{t}r{i} = call double @llvm.vector.reduce.fadd.v{lanes}f64(double {constant(0.0)}, {v} {t}m{i})",
                f"{result} = fadd double {total}, {t}r{i}",
            ]
            total = result
