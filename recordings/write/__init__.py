"""Writing a recording.

broadcast         observers of a run in progress; data for programs that draw it
writer            the recorder: one file per run, complete once it has its final name
sink              the MCAP file as the recorder uses it (bytes: format.mcapfile); encoding of sample rows
outputs, partfile choice of an output's name; the file under construction
"""

from heavylift.kernel.on_demand import face

face(__name__)
