"""The native blocks of one simulation: the state X, the parameters P, the table of samples, and what computes on them.

Each set of locked joints and calmed ropes is a variant with code of its own, compiled when it is first used; places in
X and P are the same in all.
"""

from __future__ import annotations

from math import ceil
from types import SimpleNamespace

import numpy as np
from heavylift.kernel.compiler.emit import module
from heavylift.kernel.compiler.machine_code import Library
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.description.notes import Note
from heavylift.kernel.errors import KernelError
from heavylift.kernel.methods.at_rest import AtRest
from heavylift.kernel.methods.choice import choose, control_of
from heavylift.kernel.methods.peers import Code, Peer, PeerCode
from heavylift.kernel.methods.small_motions import FINEST
from heavylift.kernel.methods.stability import Balance, jacobian
from heavylift.kernel.model.checks import check_options
from heavylift.kernel.model.code_structure import structure
from heavylift.kernel.model.evaluation import Evaluation, evaluate
from heavylift.kernel.model.program import Program
from heavylift.kernel.model.references import References
from heavylift.kernel.simulation.safeguards.fastest_mode import Fastest, fastest
from heavylift.kernel.simulation.safeguards.inertia_check import check_resistance

from .native_functions import Stepping
from .oracle import Oracle

__all__ = ["FOREVER_NS", "NEVER", "Blocks"]

FOREVER_NS = 2**63 - 1
ROWS = 512  # rows of the table that native code fills, besides those that one step may add
NEVER = 1e15  # [s] local time that does not come
IMPLICIT_PEERS = ("scipy-radau", "scipy-bdf", "scipy-lsoda")


class Blocks:
    """X (state), P (parameters) and the table of samples, with the machine code that works on them."""

    def __init__(
        self,
        system: System,
        tolerance: float,
        sample_ns: int,
        h_max: float,
        native: bool,
        opt: int,
        cache: bool,
        method: str,
        step: float | None,
        formulation: str,
        fused: bool,
    ) -> None:
        check_options(tolerance, sample_ns, h_max, step, opt)
        self.fixed, self._step = step is not None, step or 0.0
        self._calm: frozenset[str] = frozenset()  # ropes without events
        self.notes: list[Note] = []
        self._fused = fused

        def compiled(locked: frozenset[str] | None) -> Code:
            clamped, at_rest = method == "dopri5", method == AtRest.name
            self.program = Program(system, formulation, locked, clamped, at_rest, self._calm)
            if not self.program.nv:
                raise KernelError("nothing in this scene can move: all joints are fixed")
            found = choose(method, self.program)
            self.method = Stepping(self.program, found, control_of(found, step, self.program))
            code: Code = Library(self.structure(), self._ir, opt, cache) if native else Oracle(self.method)
            if isinstance(found, Peer):
                return PeerCode(code, found, self.method.layout.at, self.method.rate_sizes)
            return code

        self._compiled = compiled
        self._variants: dict[tuple[frozenset[str], frozenset[str]], tuple[Program, Stepping, Code]] = {}
        self._use(None)
        self.P = self.program.parameters.initial.copy()
        self.X = np.zeros(self.method.layout.size)
        self._at = self.method.layout.at
        chosen = self.method.method
        implicit = bool(chosen.matrices) or chosen.name in IMPLICIT_PEERS
        self._balance = Balance(0.0 if self.fixed else tolerance, implicit)
        places, works = self.method.row_layout.at, [what == "work" for what, _ in self.program.accounts]
        columns = np.arange(self.method.columns)
        self._kinetic = int(columns[places["kinetic"]])
        self._parts = np.concatenate([np.ravel(columns[places[k]]) for k in ("potential", "stored", "accounts")])
        self._signs = np.where([False] * (1 + len(self.program.stores)) + works, -1.0, 1.0)
        self._mass = sum(b.mass for b in system.bodies)
        self._softness = np.array([0.5 / r.EA for r in system.ropes])  # of a metre: energy held by a tension squared
        self._checked = np.zeros(len(system.ropes))  # unstretched lengths of ropes when the step was last looked at
        self.M = np.zeros(chosen.matrices) if chosen.matrices else None
        for name, value in chosen.constants().items():
            self.X[self._at[name]] = value
        h_max = step or h_max
        one_step = ceil(h_max * 1e9 / sample_ns) + 2
        self._table = np.zeros((ROWS + one_step, self.method.columns))
        self.references = References(self.program.parameters, self.P, system)
        self._sample_ns = sample_ns
        self.rows: list[tuple[int, np.ndarray]] = []
        self.epoch = 0
        self._missed = False
        self._samples = 1  # number of the next periodic sample
        self._set(scale=FINEST, grain=1.0, faint=1.0)
        self._set(tol=tolerance, h=step or 1e-4, error=1e-4, h_min=1e-12, h_max=h_max, rows=ROWS)
        y0 = self.program.initial_state()
        self.X[self._at["y"]] = y0
        check_resistance(self.program, y0)

    def _use(self, locked: frozenset[str] | None) -> None:
        """Go on with the code of the scene in which these locks hold (None: those of the start).

        Each variant is compiled when it is first used; places in X and P are the same in all.
        """
        if locked is None or (locked, self._calm) not in self._variants:
            code = self._compiled(locked)
            locked = self.program.locked
            self._variants[locked, self._calm] = self.program, self.method, code
        self.program, self.method, self._code = self._variants[locked, self._calm]

    @property
    def operations(self) -> int:
        """Arithmetic operations of one evaluation of the equations."""
        return self.method.f_rate.operations

    def structure(self) -> str:
        """Equal for simulations that share machine code."""
        return structure(self.program, self.method.method.name, self.fixed, self._fused)

    def _ir(self) -> str:
        return module(self.method.advance, *self.method.functions.values(), fused=self._fused)

    def __getitem__(self, name: str) -> float:
        return float(self.X[self._at[name]])

    def _set(self, **values: float) -> None:
        for name, v in values.items():
            self.X[self._at[name]] = v

    def _call(self, name: str) -> None:
        blocks = [self.X, self.P]
        sizes = self.method.layout.size, len(self.program.parameters.initial)
        assert (self.X.size, self.P.size) == sizes, "blocks of another variant"
        if name in ("advance", "sample", "look"):
            blocks.append(self._table)
        if self.M is not None and name in ("advance", "step"):
            blocks.append(self.M)
        self._code.call(name, *blocks)

    def _survey(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Matrix (n, n), speeds and free accelerations (n,) of all rows at the present state."""
        self._call("survey")
        matrix, speed, free = (self.X[self._at[name]].copy() for name in ("delassus", "speed", "free"))
        return matrix.reshape(len(speed), len(speed)), speed, free

    def _kick(self, impulses: np.ndarray) -> None:
        """Change the velocities by impulses (n,) of the rows [N s]."""
        self.X[self._at["impulse"]] = impulses
        self._call("kick")

    def _local(self, t_ns: int) -> float:
        return (t_ns - self.epoch) * 1e-9 if t_ns < FOREVER_NS else NEVER

    def _among(self) -> float:
        """A local time within the piece of the profiles that begins now, as in the steps."""
        return self["t"] + 0.5 * min(1.0, self["t_stop"] - self["t"])

    @property
    def evaluations(self) -> int:
        """Of the right-hand side in all attempted steps, with those of Jacobians; samples and events not counted."""
        method = self.method.method
        attempts = self["accepted"] + self["rejected"]
        return round(method.evaluations * attempts + sum(n * self[name] for name, n in method.counted.items()))

    @property
    def state(self) -> np.ndarray:
        """(ny,) coordinates, velocities and accounts, committed or tentative."""
        y: np.ndarray = self.X[self._at["y"]]
        return y

    @property
    def _angles(self) -> np.ndarray:
        """Integrals of the angles, in place (see `continuous_angles`)."""
        p = self.program
        counted: np.ndarray = self.state[p.nq + p.nv + len(p.accounts) :]
        return counted

    def row(self) -> SimpleNamespace:
        """The present state as a sample row."""
        return self.method.row_layout.unpack(self._raw().copy())

    def _raw(self) -> np.ndarray:
        """The same as it stands in the native table until the next call."""
        self._call("look")
        row: np.ndarray = self._table[int(self["row"])]
        return row

    def instant(self) -> Evaluation:
        """All that the equations say of the present state, on floats: forces, accelerations, guards."""
        return evaluate(self.program, self["t"], self.state.copy(), self.P, self._among())

    def _close(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """One Newton step onto the constraints from y; gaps and slips before it, pivots of the rows."""
        self.X[self._at["y"]] = y
        self._call("close")
        at = (self._at[name] for name in ("y", "gap", "slip", "pivot"))
        place, gap, slip, pivot = (self.X[i].copy() for i in at)
        return place, gap, slip, pivot

    def _rate(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivative and tensions at state y at the present time."""
        return self.rate_at(self["t"], self._among(), y)

    def rate_at(self, t: float, among: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivative and tensions at local time t and state y; `among`: a time in the same piece of the profiles."""
        out = {name: np.zeros(n) for name, n in self.method.rate_sizes.items()}
        self._code.call("rate", np.array([t, among]), y, self.P, *out.values())
        return out["dy"], out["T"]

    def rate_now(self) -> np.ndarray:
        """(ny,) derivative at the present state."""
        return self._rate(self.state.copy())[0]

    def _jacobian(self) -> np.ndarray:
        return jacobian(lambda y: self._rate(y)[0], self.state.copy(), self.program.nq + self.program.nv)

    def _fastest(self) -> Fastest | None:
        """The fastest mode of the scene as it stands."""
        return fastest(self, self._jacobian())
