"""The contents of a recording, byte by byte.

mcapfile               a thin writer of MCAP files; causes of read errors: bytes, libraries, the system
schema                 protobuf and JSON schemas; templates of messages in which only numbers change
samples                assignment of sample columns to topics; rounding of recorded numbers
viewer_messages        messages for viewers in the foxglove schemas
machines               cranes, slings and the block of a recorded plan; settings of a run in one or two lines
digest                 hash that is equal for equal runs; a temporary file for the data of a long run
spellings              former spellings that stay valid in scenes and recordings
text                   time spans and suggestions as text; foreign text made safe to print
"""

from heavylift.kernel.on_demand import face

face(__name__)
