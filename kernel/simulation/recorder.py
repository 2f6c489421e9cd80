"""Samples of a run: rows that native code has written are checked and become rows of the run.

Samples lie on a grid of integer nanoseconds and are numbered; events have rows of their own. All samples of a period of
rest are stored as one row, and repeated on demand.
"""

import numpy as np
from heavylift.kernel.description.findings import Note
from heavylift.kernel.errors import KernelError
from heavylift.kernel.simulation.native.native_state import ROWS, NativeState
from heavylift.kernel.simulation.safeguards.deflection_check import LASTING, check_compression, compressed, relieve
from heavylift.kernel.simulation.safeguards.failures import check_lengths, check_sliders, off_beams, wound_up
from heavylift.kernel.simulation.safeguards.step_check import EnergyCheck, StepCheck


class SampleRecorder:
    """Recorder of a run's samples, which checks each row and stores it with its time."""

    def __init__(self, native: NativeState, sample_ns: int, tolerance: float, step: float | None) -> None:
        self._native, self.sample_ns, self._step = native, sample_ns, step
        self.rows: list[tuple[int, np.ndarray]] = []  # times [ns] and rows
        self.number = 1  # of the next periodic sample
        self.rested: tuple[int, int, np.ndarray] | None = None  # a past rest: first sample without a row, end [ns], row
        self.energy = EnergyCheck(native, tolerance, step)
        self.steps = None if step is None else StepCheck(native, step)  # check of fixed steps

    @property
    def next_ns(self) -> int:
        """The time of the next periodic sample [ns]."""
        return self.number * self.sample_ns

    def drain(self) -> None:
        """Move the sample rows from the native table, in which native code wrote them, to `rows`."""
        native = self._native
        if native["row"] > 0.0:
            rows = native.table[: int(native["row"])].copy()
            notable, start = self._notable(rows).nonzero()[0].tolist(), 0
            for end in [*notable, len(rows)]:
                self._take(rows[start:end])
                self._look(rows[end : end + 1])
                start = end + 1
            native.set(row=0.0)
        if "passing" in native.at and native["passing"] > 0.0:
            t_ns = native.epoch + round((native["passing"] - 1.0) * 1e9)
            native.set(passing=-1.0)
            message = (
                f"step {self._step:g} s at {t_ns * 1e-9:.3f} s: what moves so fast can pass through what it meets "
                f"within a step of method '{native.method.method.name}', unseen; choose a shorter one, or leave it out"
            )
            native.notes.append(Note(t_ns, message))

    def _notable(self, rows: np.ndarray) -> np.ndarray:
        """Return which rows (n, columns) need a check one by one; energies are not considered here."""
        native = self._native
        at, program = native.method.row_layout.at, native.program
        if self.steps:
            return np.ones(len(rows), dtype=bool)
        notable: np.ndarray = np.any(wound_up(rows[:, at["length"]]), axis=1)
        if program.sliders:
            notable |= off_beams(program, rows[:, at["q"]])
        if program.compressible:
            notable |= compressed(native, rows)
        return notable

    def _take(self, rows: np.ndarray) -> None:
        """Store samples (n, columns) that need no check one by one, unless their energies need one."""
        if not len(rows):
            return
        if not self.energy.fine(rows):
            self._look(rows)
            return
        native = self._native
        if native.program.compressible:
            relieve(native)
        rows[:, native.method.row_layout.at["peak_time"]] += native.epoch * 1e-9
        times = range(self.next_ns, self.next_ns + len(rows) * self.sample_ns, self.sample_ns)
        self.rows += zip(times, rows, strict=True)
        self.number += len(rows)

    def _look(self, rows: np.ndarray) -> None:
        """Check and store samples (n, columns) one by one."""
        for row in rows:
            self.energy.see(row[None])
            self.keep(self.next_ns, row)
            self.number += 1

    def keep(self, t_ns: int, row: np.ndarray) -> None:
        """Store a row written by native code as a sample; raises KernelError if it shows an invalid state."""
        native = self._native
        at = native.method.row_layout.at
        check_lengths(native.program, t_ns * 1e-9, row[at["length"]])
        check_sliders(native.program, t_ns * 1e-9, row[at["q"]])
        if native.program.compressible:
            check_compression(native, row, t_ns)
        row[at["peak_time"]] += native.epoch * 1e-9
        if not self.energy.balance.strict:
            self.energy.check(row, t_ns * 1e-9)
        if self.steps:
            self.steps.see(t_ns, row)
        self.rows.append((t_ns, row))

    def new_stretch(self) -> None:
        """Restart the numbering of periodic samples at the epoch, the time of the last event or command."""
        base = self._native.local(self.next_ns)
        self._native.set(t_base=base, t_out=base, dt_out=self.sample_ns * 1e-9, count=0.0)

    # ---- rests --------------------------------------------------------------------------------------------

    def rest(self, t_ns: int) -> None:
        """Record rest up to t_ns as one row, which `unroll` repeats; raises KernelError for lasting buckling."""
        first = self.next_ns
        if first > t_ns:
            return
        self.keep(first, np.array(self._native.method.row_layout.pack(self._native.row())))
        row = self.rows.pop()[1]
        self.rested = first, t_ns + 1, row
        self.number = t_ns // self.sample_ns + 1
        for t in range(first, t_ns + 1, self.sample_ns)[1:] if self._native.program.compressible else ():
            try:
                check_compression(self._native, row, t)
            except KernelError:
                self.rested = first, t, row
                raise
            if t - first > LASTING * 1e9:
                return

    def unroll(self, start_ns: int = 0) -> bool:
        """Write the next sample rows of a period of rest, stored as a single row; return whether more rows remain."""
        if self.rested is None:
            return False
        first, end, row = self.rested
        times = range(max(first, start_ns), end, self.sample_ns)
        self.rows += [(t, row) for t in times[:ROWS]]
        self.rested = (times[ROWS], end, row) if len(times) > ROWS else None
        return self.rested is not None
