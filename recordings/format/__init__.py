"""What stands in a recording, byte by byte.

mcapfile               a thin writer of MCAP files; what goes wrong where a file is read: bytes, libraries, the system
schema                 protobuf and JSON schemas; a message in which only numbers change
samples                which columns of a kernel sample belong to which topic; how they stand in the file, rounded
viewer_messages        what viewers draw, in the foxglove schemas
machines               cranes, slings and the block of a recorded plan; what a run says of itself in one or two lines
digest                 what two equal runs share to the last byte; a temporary file of rows, read again in blocks
spellings              former spellings that stay valid in scenes and recordings
text                   tables, time spans and events for people, what others wrote as it may be printed
"""

from heavylift.kernel.on_demand import face

face(__name__)
