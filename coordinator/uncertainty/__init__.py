"""The uncertainty of a run's figures, found by further runs of the same scene.

certificate     error estimates of a run: numerical, model, inputs
sensitivities   effect of each uncertain input on each figure
"""

from heavylift.kernel.on_demand import face

face(__name__)
