"""A recording while it is written.

broadcast         who looks at a run while it goes on; programs that draw it
writer            the recorder: one file per run, whole once it bears its name
sink              the MCAP file as the recorder sees it (its bytes: format.mcapfile); sample rows on their way into it
outputs, partfile under which name an output is written; the file under construction
"""

from heavylift.kernel.on_demand import face

face(__name__)
