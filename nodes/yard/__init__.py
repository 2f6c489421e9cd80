"""The yard above the lifts: blocks, their erection network, resources and calendars, as Parallel DEVS.

    load("yard.yaml", ["rule=latest finish"])     -> Yard; raises SceneError with all errors at file, row, column

beginning     whether a file is one of a yard, and where the bundled yards are
reading       the file and its table of blocks; taking: values and cells whose errors are faults
fields        dates, shifts, predecessors and durations as they are written
calendars     working time: shifts across midnight, holidays
weather       wind of a series, or drawn by month; it tells when it crosses a limit
orders        lifts as a step orders them for a block; lifts: what the mechanics finds of them at rest
network       activities, forward and backward pass, priority rules
generation    serial schedule generation, the PERT chain
optimising    a schedule by CP-SAT, and a bound that none can beat
models        dispatcher with its critical sequence, steps and resources as atomics
answers       what `heavylift check` and `heavylift run` say of a yard, as a sheet
gantt         the schedule as a chart; exchange: for other programs, and from them
"""

from heavylift.kernel.on_demand import face

face(__name__)
