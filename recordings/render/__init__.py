"""A recording drawn: figures, pages, layouts.

plot, storyboard             the figure of a run; the lift itself at some instants; what figures share
curves                       any signals as curves over time
compare, differences               two recordings side by side; where they part, beside the values of signals
view, content                a recording as one page; what it shows, and of another one beside it
server                       the page of a run that goes on, and its server; foxglove: other viewers, their layout
"""

from heavylift.kernel.on_demand import face

face(__name__)
