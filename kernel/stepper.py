"""The native blocks of one simulation and what is done to them between events: steps, commits, samples, stretches.

Local time is float seconds since the last event or command (the epoch); a new *stretch* begins at each of them, so
precision does not fade in long runs.  Samples lie on a grid of integer nanoseconds and are numbered.
"""

from __future__ import annotations

from math import ceil, sqrt
from types import SimpleNamespace

import numpy as np

from .checks import check_options
from .constraints.assembly import assemble, locked, lost
from .constraints.ropes import RigidAt, resolve
from .describe import System
from .emit import module
from .errors import KernelError
from .evaluation import Evaluation
from .failures import check_lengths, check_sliders, too_small, undefined, unsolved
from .fastest import Fastest, fastest
from .methods.choice import choose, control_of
from .methods.peers import Code, Peer, PeerCode
from .methods.stability import Balance, check_step, jacobian, unresolved
from .native import Library
from .oracle import Oracle
from .rate import Program
from .references import References
from .resistance import check_resistance
from .stepping import Stepping
from .structure import structure
from .switching import StateEvent

__all__ = ["FOREVER_NS", "NEVER", "Stepper"]

FOREVER_NS = 2**63 - 1
ROWS = 512  # rows of the table that native code fills, besides those that one step may add
NEVER = 1e15  # [s] local time that does not come
SHORTER = 0.8  # of its length: a rope that much shorter is a quarter stiffer
IMPLICIT_PEERS = ("scipy-radau", "scipy-bdf", "scipy-lsoda")


class Stepper:
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
        self.notes: list[str] = []  # what a user must know of the run: sentences with their times
        self._fused = fused

        def compiled(locked: frozenset[str] | None) -> Code:
            self.program = Program(system, formulation, locked, clamped=method == "dopri5", calm=self._calm)
            if not self.program.nv:
                raise KernelError("nothing in this scene can move: all joints are fixed")
            found = choose(method, self.program)
            self.method = Stepping(self.program, found, control_of(found, step, self.program))
            code: Code = Library(self.structure(), self._ir, opt, cache) if native else Oracle(self.method)
            if isinstance(found, Peer):
                return PeerCode(code, found, self.method.layout.at, len(self.program.guards))
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
        self._signs = np.where([False] * (1 + len(self.program.stored)) + works, -1.0, 1.0)
        self._mass = sum(b.mass for b in system.bodies)
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
    def state(self) -> np.ndarray:
        """(ny,) coordinates, velocities and accounts, committed or tentative."""
        y: np.ndarray = self.X[self._at["y"]]
        return y

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
        return self.program.evaluate(self["t"], self.state.copy(), self.P, self._among())

    def _close(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """One Newton step onto the constraints from y; gaps and slips before it, pivots of the rows."""
        self.X[self._at["y"]] = y
        self._call("close")
        at = (self._at[name] for name in ("y", "gap", "slip", "pivot"))
        place, gap, slip, pivot = (self.X[i].copy() for i in at)
        return place, gap, slip, pivot

    def _assemble(self) -> None:
        """Close the loops of the initial pose; raises KernelError if they cannot be closed or leave no freedom."""
        if len(self.program.constraints):
            y = self.state.copy()
            self.X[self._at["y"]] = assemble(self.program, y, self._close)
            self._pivots = self.X[self._at["pivot"]].copy()
            self.X[self._at["gap"]] = 0.0

    def _resolve(self) -> list[StateEvent]:
        """Impulses of rigid ropes and loops, and the ropes that are taut then; what has changed."""
        ropes, at = self.program.system.rigid_ropes, self.program.parameters.at
        after = resolve(self.program, self["t"], self._among(), self.state.copy(), self.P)
        slots = [self.P[at["rigid", r.name]] for r in ropes]
        before = [p[RigidAt.TAUT] > 0.0 for p in slots]
        for p, may in zip(slots, after.may, strict=True):
            p[RigidAt.TAUT] = float(may)
        nq, first = self.program.nq, self.program.nq + self.program.nv
        y = self.state.copy()
        y[:nq] = self._close(y)[0][:nq]  # the nanometre by which a rope was too long
        y[nq:first] = after.v
        for p, r, taut, heat, work in zip(slots, ropes, after.taut, after.heat, after.work, strict=True):
            p[RigidAt.TAUT] = float(taut)
            y[first + self.program.accounts.index(("heat", r.name))] += heat
            if r.winch:
                y[first + self.program.accounts.index(("work", r.name))] += work
        self.X[self._at["y"]], self.X[self._at["gap"]] = y, 0.0
        changes = zip(ropes, before, after.taut, after.impulse, strict=True)
        return [StateEvent(r.name, "taut" if b else "slack", x) for r, a, b, x in changes if a != b]

    def _check_rows(self) -> None:
        """Raises KernelError if a constraint has been lost in the steps that count."""
        if error := lost(self.program, self.X[self._at["gap"]], self.epoch * 1e-9 + self["t"]):
            raise error

    def _commit(self) -> None:
        self._call("commit")
        if self.method.method.completes and self["due"] > 0.0:
            self._call("complete")
        while self["due"] > 0.0:
            self._call("sample")
            if self["row"] >= ROWS:
                self._drain()
        self._drain()

    def _drain(self) -> None:
        n = int(self["row"])
        if n:
            self._balance.see(self._table[:n, self._kinetic], self._table[:n, self._parts] * self._signs)
        for i in range(n):
            self._keep(self._samples * self._sample_ns, self._table[i].copy())
            self._samples += 1
        self._set(row=0.0)

    def _keep(self, t_ns: int, row: np.ndarray) -> None:
        """Take a row of the native table as a sample; raises KernelError if a rope is used up."""
        at = self.method.row_layout.at
        check_lengths(self.program, t_ns * 1e-9, row[at["length"]])
        check_sliders(self.program, t_ns * 1e-9, row[at["q"]])
        row[at["peak_time"]] += self.epoch * 1e-9
        if self.fixed:
            self._check_energy(row, t_ns * 1e-9)
            if (row[at["length"]] < SHORTER * self._checked).any():
                self._check_step()
        self.rows.append((t_ns, row))

    def _energies(self, row: np.ndarray) -> tuple[float, np.ndarray]:
        """Of a row of the native table: kinetic energy; potential, stored, heats, works with the opposite sign [J]."""
        parts = row[self._parts]
        parts *= self._signs
        return float(row[self._kinetic]), parts

    def _check_energy(self, row: np.ndarray, t: float) -> None:
        """Raises KernelError if energy has come out of nothing, or gone there, since the last event; t: of the run."""
        kinetic, parts = self._energies(row)
        mass = self._mass
        size = (
            kinetic + float(np.abs(parts).sum()) + sqrt(2.0 * kinetic * mass) + abs(self.program.system.gravity) * mass
        )
        what = f"step {self._step:g} s" if self.fixed else f"method '{self.method.method.name}'"
        before = self._balance.lost
        self._balance.check(f"{what} at {t:.3f} s", kinetic, parts, self["accepted"] * size)
        if self._balance.lost > 0.0 and not before:
            self.notes.append(
                f"{what} at {t:.3f} s: {self._balance.lost:.3g} J, more than half of what was turned over, "
                "are gone with motions too fast for the steps; choose shorter ones to see those"
            )

    def _rate(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivative and tensions at state y at the present time."""
        p = self.program
        dy, T, G = np.zeros(p.ny), np.zeros(len(p.system.straight_ropes)), np.zeros(len(p.guards))
        self._code.call("rate", np.array([self["t"], self._among()]), y, self.P, dy, T, G)
        return dy, T

    def _jacobian(self) -> np.ndarray:
        return jacobian(lambda y: self._rate(y)[0], self.state.copy(), self.program.nq + self.program.nv)

    def _fastest(self) -> Fastest | None:
        """The fastest mode of the scene as it stands."""
        return fastest(self, self._jacobian())

    def _check_step(self) -> None:
        """Raises KernelError if the fixed step is unstable for the scene as it stands; a note if it misses a mode."""
        t, method = self.epoch * 1e-9 + self["t"], self.method.method
        self._checked = self.row().length.copy()
        J = self._jacobian()

        def told() -> str:
            mode = fastest(self, J)
            return mode.told if mode else "the scene is unstable"

        check_step(method, J, self._step, self.program.nq, t, told)
        missed = unresolved(method, J, self._step)
        if missed and not self._missed:
            self._missed = True
            self.notes.append(
                f"step {self._step:g} s at {t:.3f} s: method '{method.name}' follows no oscillation from "
                f"{missed:.3g} Hz upwards for more than 500 radians; the fastest: {told()}"
            )

    def _note_peaks(self) -> None:
        """The present tensions count among the peaks."""
        T, peak, when = (self.X[self._at[name]] for name in ("T", "peak", "peak_time"))
        higher = peak < T
        peak[higher], when[higher] = T[higher], self["t"]

    def _forced(self, t: float) -> None:
        """One step from the committed state to local time t, accepted as it is; step control is not touched."""
        h, error, t_stop = self["h"], self["error"], self["t_stop"]
        if t > self["t"]:
            for _ in range(2):  # the second time with a new Jacobian, if there is one
                self._set(h=NEVER, forced=1.0, t_stop=t)
                self._call("step")
                self._set(h=h, forced=0.0, error=error, t_stop=t_stop, locate=0.0)
                if "sound" not in self._at or self["sound"] > 0.0:
                    break
                self._to_start()
            else:
                raise unsolved(self.method.method.name, self.epoch * 1e-9 + t)
            if not np.isfinite(self.state).all():
                raise self._failure()

    def _to_start(self) -> None:
        """Back to the start of the tentative step."""
        for name, old in (("t", "t0"), ("y", "d0"), ("f", "f0")):
            self.X[self._at[name]] = self.X[self._at[old]]
        self._set(tentative=0.0)

    def _new_stretch(self, t_ns: int) -> None:
        """Local time starts again at t_ns."""
        shift = (t_ns - self.epoch) * 1e-9
        self.X[self._at["peak_time"]] -= shift
        self.epoch = t_ns
        base = (self._samples * self._sample_ns - t_ns) * 1e-9
        self._set(t=0.0, t_base=base, t_out=base, dt_out=self._sample_ns * 1e-9, count=0.0, tentative=0.0)
        self.references.write(t_ns)

    def _failure(self) -> KernelError:
        """Why there is no next step."""
        p, t = self.program, self.epoch * 1e-9 + self["t"]
        if self.fixed:
            if "sound" in self._at and not self["sound"] > 0.0:
                return unsolved(self.method.method.name, t)
            self._set(forced=1.0)  # what the step would have led to
            self._call("step")
        nq, end = p.nq, p.nq + p.nv
        if error := undefined(p, t, self.row(), self.state[nq:end]):
            return error
        if len(p.constraints) and (error := locked(p, self._pivots, self._close(self.state.copy())[3], t)):
            return error
        mode = self._fastest()
        return too_small(p, t, self.X[self._at["f"]][nq:end], mode.told if mode else "")
