"""A scene as a co-simulation unit of FMI 2.0 or 3.0, which another program steps.

steppable_run   a run that advances step by step, with speeds of drives and of the wind from outside
scene_unit      the variables and the state of a unit, whatever its version of FMI
fmi2, fmi3      the slaves of pythonfmu and pythonfmu3; early_return.c: returns of FMI 3 at events
environment     a scene stepped by a controller in Python: `reset`, `step`, `observe`
exporting       the unit as a file
unit_definitions units of its variables
"""

from heavylift.kernel.on_demand import face

face(__name__)
