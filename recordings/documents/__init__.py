"""The planner's document of a run, and two alternatives beside each other.

document  the document as a sheet and as a file; comparison of two alternatives
tables    the tables of the document; further tables are added here
facts     data for the tables: verdict, plan, peaks; description of block, machines and computation
"""

from heavylift.kernel.on_demand import face

from .document import alternatives, report, report_sheet
from .facts import Facts, facts

__all__ = ["Facts", "alternatives", "facts", "report", "report_sheet"]

face(__name__)
