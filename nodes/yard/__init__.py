"""The yard above the lifts: blocks, their erection network, resources and calendars, as Parallel DEVS.

    load("vlcc.yaml", ["rule=latest finish"])     -> Yard; raises SceneError with all errors at file, row, column
    yard("vlcc.yaml", [], 7)                      -> Coupled to be run; seed 0 takes expected durations

beginning     whether a file is one of a yard
reading       the file and its table of blocks
fields        dates, shifts, predecessors and durations as they are written
calendars     working time: shifts across midnight, holidays
network       activities, forward and backward pass, priority rules
generation    serial schedule generation, the PERT chain
models        dispatcher with its critical sequence, steps and resources as atomics
answers       what `heavylift check` and `heavylift run` say of a yard, as a sheet; its schedule as a calendar
"""

from heavylift.kernel.on_demand import face

face(__name__)
