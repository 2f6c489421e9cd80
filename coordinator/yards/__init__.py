"""Runs of a yard: properties of its lifts from mechanics, one recorded run, replications, studies.

    sheet, run = run_yard("vlcc", replications=100)

lifting       lifts from statics, from a table that is swept once, or simulated when they begin
model         the DEVS model of a yard file, with these lifts
running       one run, or replications
"""

from heavylift.kernel.on_demand import face

face(__name__)
