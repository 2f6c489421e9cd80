"""A recording that is read.

reader            Recording: facts, events in order, signals as arrays
container, chunks safe access to a file of unknown origin; its chunks as messages or tables
signal            a signal over time; all that is recorded of a part of the scene; how a signal looks in a notebook
contents          messages made numbers in one pass; digest and peaks, computed again from all of them
verdict           the verdict of a run; where a recording contradicts itself; a recording as text
export            a recording as a table for other programs; with what was measured beside it
recover           what a cut-off or damaged file still holds
log               the log of a real machine
"""

from heavylift.kernel.on_demand import face

face(__name__)
