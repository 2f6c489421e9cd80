"""Runs of a yard: its lifts from the mechanics, one recorded run, replications, studies.

    sheet, run = run_yard("vlcc", replications=100)

lifting       lifts at rest, from a table that is swept once, or simulated where they stand
model         a yard file as a model to be run, with these lifts
running       one run, or replications
"""

from heavylift.kernel.on_demand import face

face(__name__)
