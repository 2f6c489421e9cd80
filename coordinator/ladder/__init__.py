"""The measured ladder: what a run is wrong by is measured on the scene itself, for any machine.

in_memory       one run of a plan in this process; all below it look at runs of this kind; keeping: its kernel
figures         what a run shows, as figures: peaks, swings, places, times, loads, limits
model_levels    levels of a plan, and the methods and tolerances by which each is run
measuring       runs of model_levels, and how far they are apart in the figures that are asked; looking: their errors
choosing        from the cheapest candidate upwards until what is asked is kept; remembered by plan and question
run_pool        runs side by side on the cores
within          the best of what fits into a time
certificate     bars of a run: numerical, model, inputs; sensitivities: which input moves which figure
tradeoff        the whole ladder as a table; page: with the work-precision figure on a page

How errors are measured stands in LADDER.md.
"""

from heavylift.kernel.on_demand import face

face(__name__)
