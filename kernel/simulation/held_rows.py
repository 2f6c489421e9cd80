"""Constraint rows during a run: loops closed at the start and kept closed in steps, impulses at events."""

import numpy as np
from heavylift.kernel.constraints.row_structure import RigidAt
from heavylift.kernel.description.findings import Note
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.references import References
from heavylift.kernel.model.switching import StateChange
from heavylift.kernel.simulation.assembly.assembly import assemble, locked, lost, torn
from heavylift.kernel.simulation.impacts.active_sets import Act, ContactSets
from heavylift.kernel.simulation.impacts.rope_impacts import resolve
from heavylift.kernel.simulation.native.native_state import NativeState

APART = 1e-6  # [m, rad, m/s, rad/s] by which rows gape that drives tear
TOO_SHORT = 1e-6  # [m] by which a rigid rope may be too short by rounding


class HeldRows:
    """The constraint rows of a run (loops, rigid ropes, contacts); determines at events which of them are active."""

    def __init__(self, native: NativeState, references: References) -> None:
        self._native, self._references = native, references
        self._contacts = ContactSets(native.program, native.P)
        self._pivots = np.zeros(0)

    def assemble(self) -> None:
        """Close the loops of the initial pose; raises KernelError if they cannot be closed or leave no freedom."""
        native = self._native
        if len(native.program.constraints):
            y, message = assemble(native.program, native.state.copy(), native.P, native.close)
            self._set_state(y)
            native.notes += [Note(0, sentence) for sentence in message]
            self._pivots = native.part("pivot").copy()

    def measure(self) -> None:
        """Record the present pivots (measures of the independence of constraint rows) as reference for checks."""
        if len(self._native.program.constraints):
            self._pivots = self._native.close(self._native.state.copy())[3]

    def check_start(self) -> None:
        """Raise KernelError for a hooked rigid rope that is too short, or for overlapping shapes."""
        native = self._native
        for r, slack in zip(native.program.system.rigid_ropes, native.row().slack, strict=True):
            if r.hooked and slack < -TOO_SHORT:
                raise KernelError(
                    f"rope '{r.name}': it is rigid and {-slack * 1e3:.3g} mm too short for its ends; "
                    "make it longer or bring them closer"
                )
        if native.program.contacts.sites:
            self._contacts.check_start(native.state)

    def check(self) -> None:
        """Raise KernelError if a kinematic loop has opened in the steps committed so far."""
        native = self._native
        if not len(native.program.constraints):
            return
        if error := lost(native.program, native.part("gap"), native.now, self._moving()):
            raise error

    def locked(self, t: float) -> KernelError | None:
        """Return the error for steps that became too small if dependent constraint rows are the reason; else None."""
        native = self._native
        if not len(native.program.constraints):
            return None
        _, gap, slip, pivot = native.close(native.state.copy())
        apart = float(np.abs(np.append(gap, slip)).max()) > APART
        return locked(native.program, self._pivots, pivot, t, self._moving() if apart else [])

    def torn(self, rope: str) -> str:
        """Return why a rigid rope switches endlessly between taut and slack; "" if no drive causes it."""
        native, system = self._native, self._native.program.system
        row = len(native.program.constraints.of) + [r.name for r in system.rigid_ropes].index(rope)
        movable = bool(native.instant().constraint_rows().movable[row])
        return torn(native.program, rope, movable, self._moving())

    def _moving(self) -> list[str]:
        """Names of the prescribed drives that move now."""
        native = self._native
        prescribed = [d.name for d in native.program.system.drives if d.kind == "prescribed"]
        return [name for name in prescribed if self._references.moves(name, native.epoch + round(native["t"] * 1e9))]

    # ---- events -------------------------------------------------------------------------------------------

    def resolve(self, fallen: list[int], t_ns: int) -> list[StateChange]:
        """Apply impacts and determine which rigid ropes and contacts are active afterwards; return the changes."""
        native = self._native
        if not native.program.contacts.sites:
            return self._ropes()
        act = Act(native.survey, lambda: native.row().slack, native.kick, self._onto_rows)
        after = self._contacts.resolve(fallen, t_ns * 1e-9, native["t"], native.state, act)
        self._onto_rows()
        for account, energy in after.accounts.items():
            if account in native.program.accounts:
                native.state[native.account(*account)] += energy
        return after.events

    def _ropes(self) -> list[StateChange]:
        """Apply the impulses of rigid ropes and loops, and set the ropes that become taut; return the changes."""
        native = self._native
        p, ropes, at = native.program, native.program.system.rigid_ropes, native.program.parameters.at
        after = resolve(p, native["t"], native.among(), native.state.copy(), native.P)
        slots = [native.P[at["rigid", r.name]] for r in ropes]
        before = [slot[RigidAt.TAUT] > 0.0 for slot in slots]
        for slot, may in zip(slots, after.may, strict=True):
            slot[RigidAt.TAUT] = float(may)
        y = native.state.copy()
        y[: p.nq] = native.close(y)[0][: p.nq]  # the nanometre by which a rope was too long
        y[p.nq : p.nq + p.nv] = after.v
        for slot, r, taut, heat, work in zip(slots, ropes, after.taut, after.heat, after.work, strict=True):
            slot[RigidAt.TAUT] = float(taut)
            y[native.account("heat", r.name)] += heat
            if r.winch:
                y[native.account("work", r.name)] += work
        self._set_state(y)
        changes = zip(ropes, before, after.taut, after.impulse, strict=True)
        return [StateChange(r.name, "taut" if b else "slack", x) for r, a, b, x in changes if a != b]

    def _onto_rows(self) -> None:
        """Project positions and velocities onto the constraint rows."""
        self._set_state(self._native.close(self._native.state.copy())[0])

    def _set_state(self, y: np.ndarray) -> None:
        self._native.X[self._native.at["y"]] = y
        self._native.set(gap=0.0)
