"""Drawing a recording: figures, pages, layouts.

plot, storyboard             the figure of a run; the lift at some instants; common style of figures
curves                       any signals as curves over time
compare, differences         comparison of two recordings; differences other than in signals
view, content                a recording as one page, also with a second one beside it; data of the page
server                       the live page of a run, and its server; foxglove: other viewers, their layout
"""

from heavylift.kernel.on_demand import face

face(__name__)
