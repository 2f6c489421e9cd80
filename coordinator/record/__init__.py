"""What a run puts on record, in the words of `heavylift.recordings`.

run_record                any run: events, protocol traffic, where the wall time went, the reason of its end
facts               what a recording says of its scene at the start; the balance of energy
scene               the run of a scene: samples, pictures; what ropes would carry at rest
drawing             what viewers draw
"""

from heavylift.kernel.on_demand import face

face(__name__)
