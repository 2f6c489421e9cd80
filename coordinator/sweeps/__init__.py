"""Many runs of one scene: variants, executors, and results.

axes                `--vary` and `--sample`: values of paths, grids
variant             one run as a row of numbers, in any worker; dask_workers: untrusted workers of a dask scheduler
study, sweeping     the folder of rows; `sweep` on any concurrent.futures.Executor
function_studies    tables of mechanics or DEVS models that Python functions build from parameters
seeds               the verdict on a random sea or wind: quantiles over many seeds
operability         the share of a scatter table of seas in which a lift passes
limiting, motions   the value of a number at which the verdict turns red; speeds of all moves of a kind
planning            the shortest timing of an action list within its limits
timing              possible accelerations, written into the scene; comparison of two timings
summary, page       sampling designs and statistics of rows: histograms, Sobol indices, Clopper-Pearson intervals; pages
"""

from heavylift.kernel.on_demand import face

from .sweeping import sweep

__all__ = ["sweep"]

face(__name__)
