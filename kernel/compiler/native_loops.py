"""A writer of LLVM IR text for loops that must not be unrolled, such as those over 54 x 54 matrices.

Values are names of IR registers (strings).  Counters live on the stack; the compiler's first pass lifts them into
registers.  Arithmetic is strict IEEE and runs over WIDEST doubles at once wherever memory is contiguous.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from .simd_batches import WIDEST

VECTOR = f"<{WIDEST} x double>"
_INDICES = f"<{WIDEST} x i64>"
_COUNT = f"<{', '.join(f'i64 {i}' for i in range(WIDEST))}>"


def padded(n: int) -> int:
    """Return n rounded up to a whole number of vector lanes."""
    return -(-n // WIDEST) * WIDEST


class LoopEmitter:
    """Writer of the LLVM IR of one function whose arguments are pointers to blocks of doubles."""

    def __init__(self, name: str, pointers: list[str]) -> None:
        self.name = name
        self._signature = f"define void @{name}({', '.join(f'ptr %{p}' for p in pointers)}) noinline nounwind"
        self._head: list[str] = []
        self._body: list[str] = []
        self._n = 0

    def text(self) -> str:
        return "\n".join([f"{self._signature} {{", *self._head, *self._body, "ret void", "}"])

    def let(self, operation: str) -> str:
        """Emit an LLVM IR operation, and return the name of the register that holds its result."""
        self._n += 1
        self._body.append(f"%v{self._n} = {operation}")
        return f"%v{self._n}"

    def reserve(self, kind: str) -> str:
        """Reserve stack memory of an IR type; return its pointer."""
        self._n += 1
        self._head.append(f"%v{self._n} = alloca {kind}, align 64")
        return f"%v{self._n}"

    def integer(self, operation: str, a: int | str, b: int | str) -> str:
        return self.let(f"{operation} i64 {a}, {b}")

    def at(self, pointer: str, *index: int | str) -> str:
        """Emit the address of one double in a block, at the sum of the given indices; return its register."""
        for i in index:
            pointer = self.let(f"getelementptr double, ptr {pointer}, i64 {i}")
        return pointer

    def load(self, address: str, kind: str = "double") -> str:
        return self.let(f"load {kind}, ptr {address}, align 8")

    def store(self, value: str, address: str, kind: str = "double") -> None:
        self._body.append(f"store {kind} {value}, ptr {address}, align 8")

    def call(self, name: str, pointers: Sequence[str]) -> None:
        """Emit a call of another function whose arguments are pointers."""
        self._body.append(f"call void @{name}({', '.join(f'ptr {p}' for p in pointers)})")

    def spread(self, x: str) -> str:
        """Emit the broadcast of a scalar to all lanes; return the vector's register."""
        one = self.let(f"insertelement {VECTOR} poison, double {x}, i64 0")
        return self.let(f"shufflevector {VECTOR} {one}, {VECTOR} poison, <{WIDEST} x i32> zeroinitializer")

    def lanes(self, comparison: str, i: str, k: int | str) -> str:
        """Emit code that compares lane indices i, i + 1, ... with k, such as by "sgt"; return the mask of lanes."""
        both = []
        for x in (i, k):
            one = self.let(f"insertelement {_INDICES} poison, i64 {x}, i64 0")
            both.append(
                self.let(f"shufflevector {_INDICES} {one}, {_INDICES} poison, <{WIDEST} x i32> zeroinitializer")
            )
        place = self.let(f"add {_INDICES} {both[0]}, {_COUNT}")
        return self.let(f"icmp {comparison} {_INDICES} {place}, {both[1]}")

    def keep(self, mask: str, a: str, b: str = "zeroinitializer") -> str:
        return self.let(f"select <{WIDEST} x i1> {mask}, {VECTOR} {a}, {VECTOR} {b}")

    @contextmanager
    def loop(self, start: int | str, stop: int | str, step: int = 1) -> Iterator[str]:
        """Emit the loop `for i in range(start, stop, step)` around code emitted in the context; yield i's register."""
        counter, name = self.reserve("i64"), f"l{self._n}"
        i, stays = f"%{name}i", "slt" if step > 0 else "sgt"
        self._body += [
            f"store i64 {start}, ptr {counter}",
            f"br label %{name}head",
            f"{name}head:",
            f"{i} = load i64, ptr {counter}",
            f"%{name}go = icmp {stays} i64 {i}, {stop}",
            f"br i1 %{name}go, label %{name}body, label %{name}exit",
            f"{name}body:",
        ]
        yield i
        self._body += [
            f"%{name}next = add i64 {i}, {step}",
            f"store i64 %{name}next, ptr {counter}",
            f"br label %{name}head",
            f"{name}exit:",
        ]

    @contextmanager
    def when(self, condition: str) -> Iterator[None]:
        """Emit `if condition` around the code emitted inside the context."""
        self._n += 1
        name = f"w{self._n}"
        self._body += [f"br i1 {condition}, label %{name}then, label %{name}exit", f"{name}then:"]
        yield
        self._body += [f"br label %{name}exit", f"{name}exit:"]
