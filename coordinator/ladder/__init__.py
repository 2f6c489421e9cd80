"""The measured ladder of model levels: the errors of a run, measured by further runs of the same scene.

figures         results of a run as single numbers: peaks, swings, positions, times, loads, utilisations
model_levels    model levels of a plan, and the methods and tolerances with which each is run
measuring       runs of these candidates, and the differences of their figures; looking: their errors
choosing        the cheapest candidate within the requested accuracy; cached by plan and question
run_pool        parallel runs on all cores; beside: code and runs of a choice in other processes
within          the best accuracy that fits into a time limit
tradeoff        all candidates as a table; page: the table and the work-precision figure on a page

LADDER.md explains how errors are measured.
"""

from heavylift.kernel.on_demand import face

face(__name__)
