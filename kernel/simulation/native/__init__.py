"""Native code of a run: its functions, its state, its sample rows.

steps                         step, location of guards, commit with projection onto the constraints, sample
native_functions              these functions for one program, with the native loops around them
native_state                  state X, parameters P and the table of samples; options of a simulation
sample_row, samples           the columns of a sample; projection onto the constraints (no Baumgarte); channels
peaks, dips                   maxima of tensions, and guards that fall and recover, between the ends of steps
"""

from heavylift.kernel.on_demand import face

face(__name__)
