"""Note on loads that rigid bodies do not determine: loops or rigid ropes that constrain the same motion twice.

The pivots of the rows' elimination show at almost no cost whether rows are redundant; only then are the joints and
ropes determined that share a load (see `reactions.joint_reactions`). Redundant rows without load, such as those across
the plane of a planar linkage, cause no note.
"""

import numpy as np
from heavylift.kernel.constraints.row_structure import RigidAt
from heavylift.kernel.description.findings import Note
from heavylift.kernel.simulation.assembly.assembly import INDEPENDENT
from heavylift.kernel.simulation.native.native_state import NativeState

LOADED = 1e-6  # part of the largest reaction from which something is carried
NAMED = 6


def note_shared_loads(native: NativeState, looked: set[frozenset[str]]) -> None:
    """Add a note about statically undetermined loads, unless the set of taut ropes is among those already checked."""
    p = native.program
    c = p.constraints
    n, at = len(c.of) + len(c.ropes), p.parameters.at
    taut = frozenset(r.name for r in c.ropes if native.P[at["rigid", r.name]][RigidAt.TAUT] > 0.0)
    if not (c.of or len(taut) > 1) or taut in looked:
        return
    looked.add(taut)
    now = native.X.copy()
    pivots = native.close(native.state.copy())[3][:n]
    native.X[:] = now
    repeated = np.flatnonzero(pivots <= INDEPENDENT)
    names = _sharing(native) if len(repeated) else []
    if not names:
        return
    message = (
        f"{', '.join(names[:NAMED])}{f' and {len(names) - NAMED} more' * (len(names) > NAMED)} at "
        f"{native.epoch * 1e-9:.3f} s: how they share their load is not determined by rigid bodies, and what is "
        "recorded of it is one of the possible shares; make them elastic, or let one of them hold fewer directions"
    )
    if all(note.sentence != message for note in native.notes):
        native.notes.append(Note(native.epoch, message))


def _sharing(native: NativeState) -> list[str]:
    """Return the joints and ropes of groups with undetermined loads."""
    from heavylift.kernel.model.reactions.joint_reactions import reactions

    found = reactions(native, least=False)
    lever = found.lever or 1.0
    loads: dict[tuple[str, str, int], float] = {("rope", name, 0): T for name, T in found.tensions.items()}
    for name, r in found.items():
        parts = (*r.force.tolist(), *(x / lever for x in r.moment.tolist()))
        loads |= {("joint", name, i): abs(x) for i, x in enumerate(parts)}
    least = LOADED * max(loads.values(), default=0.0)
    loaded = [keys for keys in found.groups if any(loads.get(key, 0.0) > least for key in keys)]
    return list(dict.fromkeys(f"{kind} '{name}'" for keys in loaded for kind, name, _ in keys if kind != "contact"))
