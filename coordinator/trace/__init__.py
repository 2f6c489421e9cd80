"""Wall time of a recorded run: which node worked, which waited for which, and what lookahead could change.

communication  measured cost of distributing a scene to processes
timeline    working and waiting times from the recorded protocol messages; chains of waiting nodes
text        tables as text, the same as plain data, and Chrome trace-event JSON for a viewer
"""

from heavylift.kernel.on_demand import face

from .text import data, text, trace_events
from .timeline import Chain, GrantSpan, HeldTime, Lane, Timeline, chains

__all__ = ["Chain", "GrantSpan", "HeldTime", "Lane", "Timeline", "chains", "data", "text", "trace_events"]

face(__name__)
