"""Recording of a run by means of `heavylift.recordings`, or in memory.

run_record                record of any run: events, protocol messages, wall time by cause, reason of the end
facts               facts about the scene at the start; the energy balance
scene               record of the run of a scene: samples, shapes; static tensions of ropes
in_memory           a run in this process that nobody records, kept in memory; kept_rows: its rows
drawing             shapes and rope lines for viewers
"""

from heavylift.kernel.on_demand import face

face(__name__)
