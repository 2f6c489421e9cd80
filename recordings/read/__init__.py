"""A recording that is read.

reader            Recording: facts, events in order, signals as arrays
container, chunks safe access to a file of unknown origin; its chunks as messages or tables
decoding          messages of several topics made numbers in one pass; rows of one lift alone
signal, part      a signal over time; all that is recorded of a part of the scene; how a signal looks in a notebook
contents          digest and peaks, computed again from all messages
verdict           the verdict of a run; where a recording contradicts itself
info, export      a recording as text; as a table for other programs, and what ports of a DEVS run said
recover           what a cut-off or damaged file still holds
log, extended     the log of a real machine; a recording with what was measured beside it
"""

from heavylift.kernel.on_demand import face

face(__name__)
