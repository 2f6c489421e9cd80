"""Integration steps between events: tentative until they are committed, forced to a given time, or undone.

Local time is float seconds since the last event or command (the epoch); each epoch begins a new *stretch* of local
time, so that long runs do not lose precision.
"""

import numpy as np
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.references import References
from heavylift.kernel.simulation.native.native_state import NEVER, ROWS, NativeState
from heavylift.kernel.simulation.safeguards.chatter import StepBudget
from heavylift.kernel.simulation.safeguards.failures import too_slow, too_small, undefined, unsolved
from heavylift.kernel.simulation.safeguards.step_check import fastest_mode_text

from .held_rows import HeldRows
from .recorder import SampleRecorder

HALVINGS = 20  # of a forced step that has no solution
SHORTEST = 1e-9  # [s] of those that lead to an event in more than one


class Integrator:
    """Takes the integration steps of a run: attempts, commits and undoes them."""

    def __init__(
        self, native: NativeState, recorder: SampleRecorder, references: References, held: HeldRows, fixed: bool
    ) -> None:
        self.native, self._recorder, self._references, self._held = native, recorder, references, held
        self._fixed, self._name = fixed, native.method.method.name

    def commit(self) -> None:
        """Commit the tentative step with its samples and peaks."""
        native = self.native
        native.call("commit")
        if "top" in native.at:
            if native["steep"] > 0.0:
                native.call("slope")
            if native["hilly"] > 0.0:
                native.call("climbing")
        if native.method.method.completes and native["due"] > 0.0:
            native.call("complete")
        while native["due"] > 0.0:
            native.call("sample")
            if native["row"] >= ROWS:
                self._recorder.drain()
        self._recorder.drain()

    def led(self, t: float) -> None:
        """Advance the run to local time t [s] in one forced step, which is halved repeatedly if the method fails."""
        # each half ends in a committed state, from which the rest is tried again
        ends = [t]
        while ends:
            if self._solved(ends[-1]):
                ends.pop()
                if ends:
                    self.commit()
            elif len(ends) > HALVINGS:
                raise unsolved(self._name, self.native.epoch * 1e-9 + t)
            else:
                ends.append(0.5 * (self.native["t"] + ends[-1]))

    def forced(self, t: float) -> bool:
        """Take a forced step to local time t [s] without a change of step control; return whether it has a solution.

        If not, the state is restored, and the next step goes half as far.
        """
        native = self.native
        if self._solved(t):
            return True
        half = 0.5 * (t - native["t"])
        if self._fixed or half < SHORTEST:
            raise unsolved(self._name, native.epoch * 1e-9 + t)
        native.set(h=half)
        return False

    def _solved(self, t: float) -> bool:
        """Take a forced step and return whether it has a solution; if not, the state is restored."""
        native = self.native
        h, error, t_stop = native["h"], native["error"], native["t_stop"]
        if t <= native["t"]:
            return True
        # the first attempt may have used an old Jacobian; the method marks it stale when it fails
        for _ in range(2):  # the second time with a new Jacobian, if there is one
            # an infinite proposal is cut at t_stop: the step ends exactly there, and step control keeps its own
            # proposal
            native.set(h=NEVER, forced=1.0, t_stop=t)
            native.call("step")
            native.set(h=h, forced=0.0, error=error, t_stop=t_stop, locate=0.0)
            if self._sound:
                if not np.isfinite(native.state).all():
                    raise self.failure()
                return True
            self.take_back()
        return False

    @property
    def _sound(self) -> bool:
        """Whether the equations of an implicit step were solved."""
        return "sound" not in self.native.at or self.native["sound"] > 0.0

    def take_back(self) -> None:
        """Undo the tentative step and return to its start."""
        native = self.native
        for name, old in (("t", "t0"), ("y", "d0"), ("f", "f0")):
            native.X[native.at[name]] = native.X[native.at[old]]
        native.set(tentative=0.0)

    def new_stretch(self, t_ns: int) -> None:
        """Make t_ns the new epoch, at which local time is zero, and convert the times of peaks to it."""
        native = self.native
        # peak times count from the epoch, which moves
        native.X[native.at["peak_time"]] -= (t_ns - native.epoch) * 1e-9
        native.epoch = t_ns
        native.set(t=0.0, tentative=0.0)
        self._recorder.new_stretch()
        self._references.write(t_ns)

    def pass_break(self) -> None:
        """Commit the step that ends where a piece of a profile or history ends, and recompute the derivative there."""
        native = self.native
        self.commit()
        self._references.histories.write(native.epoch, native["t"])
        self._references.waves.write(native.epoch, native["t"])
        native.set(t_stop=next(iter(self._references.breaks(native.epoch, native["t"])), NEVER))
        native.call("refresh")

    def note_peaks(self) -> None:
        """Raise the recorded peak tension of each rope to its present tension if this is higher."""
        native = self.native
        T, peak, when = (native.part(name) for name in ("T", "peak", "peak_time"))
        if (higher := peak < T).any():
            peak[higher], when[higher] = T[higher], native["t"]
        if "top" in native.at:
            np.maximum(native.part("top"), T, out=native.part("top"))

    def check_pace(self, patience: StepBudget) -> None:
        """Raise KernelError if the run makes no progress because it takes too many steps per simulated second."""
        native = self.native
        if patience.ends(native.attempts, native.now):
            raise too_slow(self._name, native.now, native["h0"], fastest_mode_text(native))

    def failure(self) -> KernelError:
        """Return the error that explains why no further step can be taken."""
        native = self.native
        p, t = native.program, native.now
        if self._fixed:
            if not self._sound:
                return unsolved(self._name, t)
            # the failed step is forced, to name what is not finite in it
            native.set(forced=1.0)  # what the step would have led to
            native.call("step")
        if error := undefined(p, t, native.row(), native.velocities) or self._held.locked(t):
            return error
        return too_small(p, t, native.part("f")[p.nq : p.nq + p.nv], fastest_mode_text(native), self._name)
