"""Many runs of one scene: what is varied, on which engine, and what comes of it.

axes                `--vary` and `--sample`: values of paths, grids
variant             one run as a row of numbers, in any worker; dask_workers: those of a scheduler, who are not trusted
study, sweeping     the folder of rows; `sweep` on any concurrent.futures.Executor
limiting, motions   how far a number may go before the verdict turns red; speeds of all moves of a kind
planning            the shortest timing of an action list within its limits
timing              what of it can be quicker, written into the scene; two timings beside each other
summary, page       designs and what the rows say: counts, curves, histograms, indices, probabilities; pages
"""

from heavylift.kernel.on_demand import face

from .sweeping import sweep

__all__ = ["sweep"]

face(__name__)
