"""The planner's document of a run: what every stage asked of ropes, hooks and cranes.

facts     numbers of a recording, as frozen tables
document  the same as one self-contained page

scene     what was lifted, with what, and how it was computed
browser   prints a page to PDF
"""

from heavylift.recordings.read.verdict import LimitTable

from .document import report
from .facts import Facts, facts

__all__ = ["Facts", "LimitTable", "facts", "report"]
