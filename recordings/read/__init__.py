"""Reading a recording.

reader            Recording: facts, events in order, signals as arrays
container, chunks safe access to a file of unknown origin; its chunks as messages or tables
signal            a signal over time; all signals of a part of the scene; their display in a notebook
contents          decoding of messages into numbers; digest and peaks, computed again from all messages
verdict           the verdict of a run; contradictions within a recording; a recording as text
export            a recording as a table for other programs; copies with additional signals
recover           recovery of the readable part of a cut-off or damaged file
log               the log of a real machine
"""

from heavylift.kernel.on_demand import face

face(__name__)
