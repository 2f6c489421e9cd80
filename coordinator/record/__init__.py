"""Recording of a run by means of `heavylift.recordings`.

run_record                record of any run: events, protocol messages, wall time by cause, reason of the end
facts               facts about the scene at the start; the energy balance
scene               record of the run of a scene: samples, shapes; static tensions of ropes
drawing             shapes and rope lines for viewers
"""

from heavylift.kernel.on_demand import face

face(__name__)
