"""What a lift must not exceed, and the findings of those who looked: `check` on the path, `run` on what happened.

Limit     one row of the table of limits: subject, quantity, value or chart, design factor, source
Use       the worst that was met of a limit, with time, stage and use
Signals   what is checked, as columns over the instants of a path or of a run
Check     a row of the list of checks, with its place, time, value and limit

    uses_on_path(plan, states)  -> a Use of each limit of the plan, on the equilibrium path
    uses_of(plan, [signals])    -> the same in a run
    checks_of(plan, uses, ...)  -> rows with a state: red, undecided, amber, green
    line_of(checks)             -> how many have which, and the worst
    table_of(checks)            -> the table that people read

judging, reading, signals    the table judged; how each quantity is read; of which columns
named                        the signal that a limit names
standards                    factors of standards; what slings and shackles may carry by them
reeving                      parts of a reeved rope; shares that are indeterminate
factors                      from loads at rest to design loads
ground                       what machines press on the ground: tracks, outriggers, wheels
geometry                     whether a block can be what the scene says
checks                       the state of each check: error and limit, what is assumed or not checked
run_tables                   what samples show besides limits: reactions, lugs, slings, stages, the block
messages                     the sentence of a use

Node processes import the table alone; what judges (and needs NumPy) is imported when it is first used.
"""

from typing import TYPE_CHECKING

from heavylift.kernel.description.findings import Check
from heavylift.kernel.on_demand import face, on_demand
from heavylift.nodes.plan.limit import RatedLimit, Use

if TYPE_CHECKING:
    from .checks import checks_of, line_of, table_of
    from .judging import uses_of, uses_on_path
    from .run_tables import RunTables
    from .signals import SignalColumns, signals_of

__all__ = [
    "Check", "RatedLimit", "RunTables", "SignalColumns", "Use", "checks_of", "line_of", "signals_of", "table_of",
    "uses_of", "uses_on_path",
]  # fmt: skip
__getattr__ = on_demand(__name__)

face(__name__)
