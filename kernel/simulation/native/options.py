"""With what a scene is simulated."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Options:
    """`tolerance`: of a step, relative to 1 + |y|; `sample_ns`: period of samples; `h_max`: longest step [s], None: the
    method's; `native=False` runs the same text on floats (slow oracle); `opt`: LLVM's level; `cache`: of machine code;
    `method`: one of `kernel.methods.METHODS`; `step`: fixed steps of so many seconds; `formulation`: one of
    `kernel.multibody.formulations.FORMULATIONS`; `fused`: products are added unrounded, a little faster, with bits
    that depend on the processor."""

    tolerance: float = 1e-7
    sample_ns: int = 500_000_000
    h_max: float | None = None
    native: bool = True
    opt: int = 1
    cache: bool = True
    method: str = "dopri5"
    step: float | None = None
    formulation: str = "recursive"
    fused: bool = False
