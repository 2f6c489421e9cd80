"""The planner's document of a run: what every stage asked of ropes, hooks and cranes.

facts     numbers of a recording, as frozen tables
document  the same as one self-contained page, as PDF or as a workbook

loads     what lugs, slings, stools and portals bore, and where the block was
scene     what was lifted, with what, and how it was computed
tables    what is printed of all that
workbook  tables as sheets
browser   prints a page to PDF
"""

from heavylift.kernel.on_demand import face

from .document import Issue, report
from .facts import Facts, facts

__all__ = ["Facts", "Issue", "facts", "report"]

face(__name__)
