"""Where the wall time of a recorded run went: who worked, who waited for whom, and what lookahead could change.

communication  what processes would cost a scene, measured
timeline    from the protocol messages of a recording; who was held back by whom, in chains
text        tables for people, the same as plain data, and as Chrome trace-event JSON for a viewer
"""

from heavylift.kernel.on_demand import face

from .text import data, text, trace_events
from .timeline import Chain, GrantSpan, HeldTime, Lane, Timeline, chains

__all__ = ["Chain", "GrantSpan", "HeldTime", "Lane", "Timeline", "chains", "data", "text", "trace_events"]

face(__name__)
