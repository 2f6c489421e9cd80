"""The native state of one simulation: the block X, the parameters P, the table of samples, and its native functions.

Each set of locked joints and calmed ropes has code of its own, compiled on first use; the layouts of X and P are the
same for all sets. The module also defines the options of a simulation.
"""

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass
from functools import partial
from math import ceil
from types import SimpleNamespace

import numpy as np
from heavylift.kernel.compiler.emit import Library
from heavylift.kernel.compiler.function import Places
from heavylift.kernel.description.findings import Note
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.errors import KernelError
from heavylift.kernel.methods.choice import choose, control_of
from heavylift.kernel.methods.control import FINEST
from heavylift.kernel.methods.method import LONGEST, AtRest, Method, StepCode
from heavylift.kernel.methods.stability import jacobian
from heavylift.kernel.model.checks import check_options
from heavylift.kernel.model.code_structure import structure
from heavylift.kernel.model.evaluation import Evaluation, evaluate
from heavylift.kernel.model.program import Program, program_of

from .native_functions import Oracle, Stepping


@dataclass(frozen=True)
class Options:
    """Options of a simulation, such as method, tolerance and sample period.

    `tolerance`: largest error of a step, relative to 1 + |y|; `sample_ns`: period of samples [ns]; `h_max`: longest
    step [s] (None: as the method chooses); `native=False` runs the same code on floats (slow reference); `opt`:
    optimisation level of LLVM; `cache`: use the cache of machine code; `method`: one of `kernel.methods.METHODS`;
    `step`: length of fixed steps [s]; `formulation`: one of `kernel.multibody.formulations.FORMULATIONS`; `fused`:
    products are added unrounded, a little faster, with bits that depend on the processor.
    """

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


FOREVER_NS = 2**63 - 1
ROWS = 512  # rows of the table that native code fills, besides those that one step may add
NEVER = 1e15  # [s] local time that does not come

Variant = tuple[Program, Stepping, StepCode]
MOST_LOADED = 64  # structures whose machine code stays loaded
_loaded: dict[tuple[str, int], tuple[Stepping, Library]] = {}  # by structure and LLVM's level, the oldest first


class NativeState:
    """The memory blocks of a simulation (state X, parameters P, matrices M, samples) with the machine code for them."""

    program: Program
    method: Stepping
    code: StepCode

    def __init__(self, system: System, options: Options) -> None:
        o = options
        check_options(o.tolerance, o.sample_ns, LONGEST if o.h_max is None else o.h_max, o.step, o.opt)
        self._system, self.options = system, options
        self.epoch = 0  # start of local time [ns]
        self.calm: frozenset[str] = frozenset()  # ropes without events
        self.notes: list[Note] = []  # warnings of the run so far
        self._variants: dict[tuple[frozenset[str], frozenset[str]], Variant] = {}
        self.use(None)
        self.P = self.program.parameters.initial.copy()
        self.X = np.zeros(self.method.layout.size)
        self.at: Places = self.method.layout.at
        chosen = self.method.method
        self.M = np.zeros(chosen.matrices) if chosen.matrices else None
        for name, value in chosen.constants().items():
            self.X[self.at[name]] = value
        h_max = o.step or o.h_max or chosen.longest
        self.table = np.zeros((ROWS + ceil(h_max * 1e9 / o.sample_ns) + 2, self.method.columns))
        self.set(scale=FINEST, grain=1.0, faint=1.0)
        self.set(tol=o.tolerance, h=o.step or 1e-4, error=1e-4, h_min=1e-12, h_max=h_max, rows=ROWS)
        self.X[self.at["y"]] = self.program.initial_state()
        if chosen.name != o.method:
            self.notes.append(Note(0, f"method '{o.method}' was removed: '{chosen.name}' takes its place"))

    # ---- code ---------------------------------------------------------------------------------------------

    def use(self, locked: frozenset[str] | None) -> None:
        """Switch to the machine code for a set of engaged locks; None stands for the locks engaged at the start."""
        if locked is None or (locked, self.calm) not in self._variants:
            variant = self._variant(locked)
            locked = variant[0].locked
            self._variants[locked, self.calm] = variant
        self.program, self.method, self.code = self._variants[locked, self.calm]
        self._calls: dict[str, Callable[[], None]] = {}

    def _variant(self, locked: frozenset[str] | None) -> Variant:
        o = self.options
        clamped, at_rest = o.method == "dopri5", o.method == AtRest.name
        program = program_of(self._system, o.formulation, locked, clamped, at_rest, self.calm)
        if not program.nv:
            raise KernelError("nothing in this scene can move: all joints are fixed; free a joint")
        found = choose(o.method, program)
        key = self._structure(program, found), o.opt
        if o.native and o.cache and key in _loaded:
            alike, library = _loaded[key]
            m = copy(alike)
            m.program, m.method, m.control = program, found, control_of(found, o.step, program)
            return program, m, found.run(library, m.layout.at, m.rate_sizes)
        m = Stepping(program, found, control_of(found, o.step, program))
        code: StepCode = Oracle(m)
        if o.native:
            code = library = Library(key[0], partial(m.ir, o.fused), o.opt, o.cache)
            _loaded.update({key: (m, library)} if o.cache else {})
            for old in list(_loaded)[: max(0, len(_loaded) - MOST_LOADED)]:
                _loaded.pop(old, None)
        return program, m, found.run(code, m.layout.at, m.rate_sizes)

    def _structure(self, program: Program, method: Method) -> str:
        return structure(program, method.name, self.options.step is not None, self.options.fused)

    @property
    def structure(self) -> str:
        """Key that is equal for simulations which share machine code."""
        return self._structure(self.program, self.method.method)

    def call(self, name: str) -> None:
        """Run a native function by its name on the blocks of the simulation."""
        if name not in self._calls:
            blocks = [self.X, self.P]
            assert self.X.size == self.method.layout.size, "block of another variant"
            assert self.P.size == self.program.parameters.initial.size, "block of another variant"
            if self.M is not None and name in ("advance", "step", "sample"):
                blocks.append(self.M)
            if name in ("advance", "sample", "look"):
                blocks.append(self.table)
            self._calls[name] = self.bound(name, *blocks)
        self._calls[name]()

    def bound(self, name: str, *blocks: np.ndarray) -> Callable[[], None]:
        """Return a native function bound, for many calls, to blocks that the caller must keep alive."""
        code = self.code
        if isinstance(code, Library):
            return code.bound(name, *blocks, unlocked=name == "advance")  # many steps; all others are short
        return partial(code.call, name, *blocks)

    # ---- state --------------------------------------------------------------------------------------------

    def __getitem__(self, name: str) -> float:
        return self.X.item(self.at[name])

    def set(self, **values: float) -> None:
        """Write scalars of the state block X, or fill its vectors with one value."""
        for name, v in values.items():
            self.X[self.at[name]] = v

    def part(self, name: str) -> np.ndarray:
        """Return a named vector of the state block X as a view."""
        x: np.ndarray = self.X[self.at[name]]
        return x

    @property
    def state(self) -> np.ndarray:
        """Coordinates, velocities and energy accounts (ny,), committed or tentative, as a view."""
        return self.part("y")

    @property
    def velocities(self) -> np.ndarray:
        """Velocities of all degrees of freedom (nv,), as a view."""
        return self.state[self.program.nq : self.program.nq + self.program.nv]

    @property
    def angles(self) -> np.ndarray:
        """View of the state's angles over several turns [rad] and of its memory states of wave radiation."""
        p = self.program
        return self.state[p.nq + p.nv + len(p.accounts) :]

    def account(self, what: str, name: str) -> int:
        """Return the index in the state of the energy account (heat or work) of a law."""
        return self.program.nq + self.program.nv + self.program.accounts.index((what, name))

    @property
    def attempts(self) -> float:
        """Number of attempted steps so far."""
        return self["accepted"] + self["rejected"]

    @property
    def evaluations(self) -> int:
        """Number of evaluations of the right-hand side in steps and Jacobians, not for samples, events and peaks."""
        method = self.method.method
        return round(method.evaluations * self.attempts + sum(n * self[name] for name, n in method.counted.items()))

    @property
    def now(self) -> float:
        """Time of the state since the start of the run [s]."""
        return self.epoch * 1e-9 + self["t"]

    def local(self, t_ns: int) -> float:
        """Return the local time [s], counted from the epoch, of a simulation time [ns]."""
        return (t_ns - self.epoch) * 1e-9 if t_ns < FOREVER_NS else NEVER

    def reached_ns(self, t: float) -> int:
        """Return the first simulation time [ns] that is not before local time t [s]."""
        n = self.epoch + max(0, ceil(t * 1e9) - 1)  # below: the same comparison as at the end of steps
        while self.local(n) < t:
            n += 1
        return n

    def among(self) -> float:
        """Return a local time [s] within the present pieces of all speed profiles, which selects these pieces."""
        return self["t"] + 0.5 * min(1.0, self["t_stop"] - self["t"])

    # ---- evaluations --------------------------------------------------------------------------------------

    def row(self) -> SimpleNamespace:
        """Return the present state as a sample row."""
        return self.method.row_layout.unpack(self.raw().copy(), SimpleNamespace)

    def raw(self) -> np.ndarray:
        """Return the present sample row as a view of the native table; valid until the next call."""
        self.call("look")
        row: np.ndarray = self.table[int(self["row"])]
        return row

    def shown(self, t_ns: int, before: np.ndarray | None, still: bool) -> np.ndarray:
        """Return the sample row at a time within the tentative step, or at rest, without changing the state.

        `before`: state block X before an event within that step was located.
        """
        now = self.X.copy()
        if before is not None:
            self.X[:] = before
        if still or not self["tentative"] > 0.0:
            row = self.raw().copy()
        else:
            if self.method.method.completes and self["coarse"] > 0.0:
                self.call("complete")
            self.set(t_out=self.local(t_ns))
            at = int(self["row"])
            self.call("sample")
            row = self.table[at].copy()
        self.X[:] = now
        row[self.method.row_layout.at["peak_time"]] += self.epoch * 1e-9
        return row

    def instant(self) -> Evaluation:
        """Return the evaluation of the present state in floats: forces, accelerations, guards."""
        return evaluate(self.program, self["t"], self.state.copy(), self.P, self.among())

    def close(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Take one Newton step from state y onto the constraints; return the new state, and residual, residual rate and
        pivot of each constraint row."""
        self.X[self.at["y"]] = y
        self.call("close")
        place, gap, slip, pivot = (self.part(name).copy() for name in ("y", "gap", "slip", "pivot"))
        return place, gap, slip, pivot

    def survey(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the Delassus matrix (n, n), speeds and free accelerations (n,) of all constraint rows at present."""
        self.call("survey")
        matrix, speed, free = (self.part(name).copy() for name in ("delassus", "speed", "free"))
        return matrix.reshape(len(speed), len(speed)), speed, free

    def kick(self, impulses: np.ndarray) -> None:
        """Change the velocities by impulses (n,) on the constraint rows [N s]."""
        self.X[self.at["impulse"]] = impulses
        self.call("kick")

    def rate(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the state's derivative (ny,) and the rope tensions [N] at state y and the present time."""
        return self.rate_at(self["t"], self.among(), y)

    def rate_at(self, t: float, among: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the state's derivative (ny,) and the rope tensions [N] at local time t [s] and state y; `among`: a
        time in the same profile piece."""
        if "rate" not in self._calls:
            self._given = np.zeros(2), np.zeros(len(y))
            self._rates = {name: np.zeros(n) for name, n in self.method.rate_sizes.items()}
            self._calls["rate"] = self.bound("rate", *self._given, self.P, *self._rates.values())
        self._given[0][:], self._given[1][:] = (t, among), y
        self._calls["rate"]()
        return self._rates["dy"].copy(), self._rates["T"].copy()

    def jacobian(self) -> np.ndarray:
        """Return the derivative (n, n) of the rates of coordinates and velocities at the present state."""
        return jacobian(lambda y: self.rate(y)[0], self.state.copy(), self.program.nq + self.program.nv)
