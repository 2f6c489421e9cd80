"""The native side of a run: its functions, its state, its sample rows.

steps                         step, location of guards, commit and sample, as text over one state block
native_functions              that text on the blocks of one program, with the loops around it
native_state                  state X, parameters P and the table of samples
sample_row, samples           columns of a sample; channels with units
peaks                         largest tensions between the ends of steps
oracle                        the same functions interpreted on floats
"""
