"""How sure the figures of a run are: bars of what its steps, its model and its inputs leave open.

    sensitivities(load("lift"), ["block.mass +- 3 %"])        which input moves which figure most

figures         what a planner asks of a run: peaks, lift-off times, swings, positions
running         runs with other inputs, steps or rungs, side by side
certificate     the three bars of each figure: numerical, model, inputs
sensitivities   by which input a figure moves, and by how much
"""

from heavylift.kernel.on_demand import face

face(__name__)
