"""The limits of a lift, and their evaluation: `check` evaluates them on the equilibrium path, `run` in a simulation.

Limit     one row of the table of limits: subject, quantity, value or chart, design factor, source
Use       the highest utilisation of a limit, with its value, time and stage
Signals   the quantities that are checked, as columns over the instants of an equilibrium path or a run
Check     a row of the list of checks, with its place, time, value and limit

    uses_on_path(plan, states)  -> a Use for each limit of the plan, on the equilibrium path
    uses_of(plan, [signals])    -> the same for a run
    checks_of(plan, uses, ...)  -> rows with a state: red, undecided, amber, green
    line_of(checks)             -> one line: number of checks in each state, and the worst check
    table_of(checks)            -> the table for planners

judging, reading, signals    evaluation of the limits; of the quantity of each; the columns that it needs
named                        the signals that a limit checks, and their reduction
standards                    factors of standards, and the loads that they allow for slings and shackles
reeving                      tensions in the parts of a reeved rope
factors                      factors between static loads and design loads
wind                         off-lead of a hanging load in a stated wind
splash                       slack slings and loads on hooks in the splash zone
sharing                      indeterminate load sharing, speeds at lift-off and landing, factors of standards
geometry                     plausibility of a block's size, mass and lugs
checks                       the state of each check, from its value, error and limit
run_tables                   tables of a run besides limits: reactions, lugs, slings, stages, the block
messages                     sentences about the utilisation of limits
check_numbers                checks as a table of numbers for workbooks

Node processes import only the table of limits; the evaluation, which needs NumPy, is imported on first use.
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
