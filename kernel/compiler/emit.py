"""Translation of traced functions to LLVM IR text, as straight-line code with one loop construct around it, and its
compilation.

Every function takes pointers to blocks of doubles.  Arithmetic is strict IEEE (no reassociation except inside dot
products of fixed lanes, no contraction unless asked for), so that the bits are the same at every optimisation level.

LLVM IR -> machine code in this process, with a cache of object files.

The key of the cache is made from the sources of the kernel, the structure of the scene, llvmlite and the processor,
so that a second start needs neither tracing nor compiling.
"""

import ctypes
import gc
import hashlib
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial

import llvmlite
import llvmlite.binding as llvm
import numpy as np
from heavylift.kernel.cache import read_cached, sources, write_cached

from .function import Function, Primitive
from .llvm_function import StraightLineCode, blocks_of, named_code
from .simd_batches import WIDEST

_DECLARE = [
    "declare double @llvm.sqrt.f64(double)",
    "declare double @llvm.fabs.f64(double)",
    *(
        f"declare <{w} x double> @llvm.fabs.v{w}f64(<{w} x double>)\n"
        f"declare <{w} x double> @llvm.sqrt.v{w}f64(<{w} x double>)\n"
        f"declare double @llvm.vector.reduce.fadd.v{w}f64(double, <{w} x double>)"
        for w in range(1, WIDEST + 1)
    ),
]


class EmittedParts:
    """A named combination of traced functions, sequences and loops that becomes one native function."""

    name: str
    parts: "tuple[Function | EmittedParts, ...]"

    @property
    def blocks(self) -> list[str]:
        return list(dict.fromkeys(b for p in self.parts for b in blocks(p)))


@dataclass(frozen=True)
class Sequence(EmittedParts):
    """Traced functions or loops that run one after the other in one native function."""

    name: str
    parts: tuple[Function | EmittedParts, ...]


@dataclass(frozen=True)
class While(EmittedParts):
    """A loop in native code that repeats its parts while block[flag] > 0."""

    name: str
    flag: int
    parts: tuple[Function | EmittedParts, ...]
    block: str = "X"


def blocks(f: Function | EmittedParts) -> list[str]:
    """Return the names of the memory blocks of a function in the order of its pointer arguments."""
    return f.blocks if isinstance(f, EmittedParts) else blocks_of(f)


def module(*functions: Function | EmittedParts, fused: bool = False) -> str:
    """Return the LLVM IR of functions and loops with all functions they call; `fused`: use fused multiply-adds."""
    texts: list[str] = []
    seen: dict[str, Function | EmittedParts] = {}

    def visit(f: Function | EmittedParts, lanes: int, shared: frozenset[str] = frozenset()) -> None:
        name = f.name if isinstance(f, EmittedParts) else named_code(f, lanes, shared)
        if name in seen:
            assert seen[name] is f, f"two functions are called '{name}'"
            return
        seen[name] = f
        if isinstance(f, EmittedParts):
            for part in f.parts:
                visit(part, 0)
            texts.append(_sequence(f))
            return
        if isinstance(f, Primitive):
            texts.append(f.text)
            return
        code = StraightLineCode(f, lanes, fused, shared)
        texts.append(code.text())
        for called in code.called:
            visit(*called)

    with _uncollected():
        for f in functions:
            visit(f, 0)
    return "\n".join([*_DECLARE, *texts])


@contextmanager
def _uncollected() -> Iterator[None]:
    """Suspend the search for garbage while functions are traced: all that is recorded stays, and it is much."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _sequence(w: EmittedParts) -> str:
    parameters = ", ".join(f"ptr %{k}" for k in w.blocks)
    calls = "\n".join(f"  call void @{p.name}({', '.join(f'ptr %{k}' for k in blocks(p))})" for p in w.parts)
    if not isinstance(w, While):
        return f"define void @{w.name}({parameters}) {{\n{calls}\n  ret void\n}}"
    return f"""define void @{w.name}({parameters}) {{
  %p = getelementptr double, ptr %{w.block}, i64 {w.flag}
  br label %head
head:
  %f = load double, ptr %p
  %go = fcmp ogt double %f, 0.0
  br i1 %go, label %body, label %exit
body:
{calls}
  br label %head
exit:
  ret void
}}"""


_FLOAT = np.dtype(np.float64)
_ANY = ctypes.c_char * 0


class Library:
    """Machine code of LLVM IR, loaded from the cache if it is stored there.

    `structure`: key in the cache; `ir`: returns the IR text, called only without cached code; `opt`: LLVM optimisation
    level 0 to 3; `cpu`: LLVM name of the target processor, if it is not this one.
    """

    def __init__(
        self,
        structure: str,
        ir: Callable[[], str],
        opt: int = 1,
        cache: bool = True,
        cpu: str | None = None,
    ) -> None:
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        features = "" if cpu else llvm.get_host_cpu_features().flatten()
        cpu = cpu or llvm.get_host_cpu_name()
        target = llvm.Target.from_default_triple()
        self._machine = target.create_target_machine(opt=opt, cpu=cpu, features=features)
        parts = [structure, cpu, features, llvmlite.__version__, str(opt), sys.platform]
        key = hashlib.sha256(sources() + "|".join(parts).encode()).hexdigest()
        name = f"{key}.o"
        code = read_cached(name) if cache else b""
        self.cached = bool(code)
        if not code:
            code = self._compile(ir(), opt)
            if cache:
                write_cached(name, code)
        self.size = len(code)
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), self._machine)
        self._engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        self._engine.finalize_object()
        self._calls: dict[tuple[str, int, bool], Callable[..., None]] = {}

    def _compile(self, ir: str, opt: int) -> bytes:
        module = llvm.parse_assembly(ir)
        if opt:
            options = llvm.create_pipeline_tuning_options(speed_level=opt)
            options.slp_vectorization = False
            passes = llvm.create_pass_builder(self._machine, options)
            if opt == 1:  # straight-line code without branches, beside short loops, has little use for other passes
                few = llvm.create_new_module_pass_manager()
                few.add_loop_rotate_pass()  # loops are unrolled in this form only
                few.add_loop_unroll_pass()
                few.add_sroa_pass()
                few.add_simplify_cfg_pass()
                few.add_instruction_combine_pass()
                few.run(module, passes)
            else:
                passes.getModulePassManager().run(module, passes)
        return bytes(self._machine.emit_object(module))

    def number(self, name: str) -> float:
        """Read a named floating-point constant from the compiled machine code; return its value."""
        address = self._engine.get_global_value_address(name)
        return ctypes.c_double.from_address(address).value

    def address(self, name: str) -> int:
        """Return the address of a native function."""
        found: int = self._engine.get_function_address(name)
        assert found, f"no native function '{name}'"
        return found

    def call(self, name: str, *blocks: np.ndarray) -> None:
        """Run a native function on contiguous float64 blocks; the caller must ensure that they are large enough."""
        self.bound(name, *blocks)()

    def bound(self, name: str, *blocks: np.ndarray, unlocked: bool = False) -> Callable[[], None]:
        """Return a native function bound to its blocks for repeated calls; the caller must keep the blocks alive.

        It runs without the interpreter's lock if `unlocked`, which costs a short function more than it takes.
        """
        for b in blocks:
            assert b.dtype == _FLOAT, f"{name}: block of {b.dtype}"
        call = self._calls.get((name, len(blocks), unlocked))
        if call is None:
            prototype = ctypes.CFUNCTYPE if unlocked else ctypes.PYFUNCTYPE
            call = prototype(None, *[ctypes.c_void_p] * len(blocks))(self.address(name))
            self._calls[name, len(blocks), unlocked] = call
        # from_buffer refuses what is not contiguous
        return partial(call, *[ctypes.addressof(_ANY.from_buffer(b)) for b in blocks])  # type: ignore[arg-type]
