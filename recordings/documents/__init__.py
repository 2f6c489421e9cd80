"""The planner's document of a run, and two alternatives beside each other.

document  the document as a sheet, and in a file
beside    two alternatives beside each other

tables    its tables, the one place to add another
facts     what they read: verdict, plan, peaks
scene     what was lifted, with what, and how it was computed
"""

from heavylift.kernel.on_demand import face

from .beside import alternatives
from .document import report, report_sheet
from .facts import Facts, facts

__all__ = ["Facts", "alternatives", "facts", "report", "report_sheet"]

face(__name__)
