"""The native side of a run: its functions, its state, its sample rows.

steps                         step, location of guards, commit and sample, as text over one state block
native_functions              that text on the blocks of one program, with the loops around it
row_functions                 rows: projection onto them, their matrix, impulses; joints locked in motion
native_state                  state X, parameters P and the table of samples; with what a scene is simulated
sample_row, samples           the table of columns of a sample; channels with units; scalars read from a sample row
peaks, dips                   tops of tensions, and guards that fall and recover, between the ends of steps
"""

from heavylift.kernel.on_demand import face

face(__name__)
