"""The shipyard in which lifts take place: blocks, their erection network, resources and calendars, as Parallel DEVS
models.

    load("yard.yaml", ["rule=latest finish"])     -> Yard; raises SceneError with all errors at file, row, column

beginning     how a yard file is recognised, and where the bundled yards are
reading       the yard file and its table of blocks
fields        typed values and cells with errors at their places; dates, shifts, predecessors, durations
calendars     working time: shifts across midnight, holidays
weather       measured or random wind and sea, which report when they cross a limit; waves: limits by peak period
orders        lifts as a yard file describes them; lifts: their results from statics
network       activities, forward and backward pass, priority rules, serial schedule generation, PERT
optimising    an optimised schedule by CP-SAT, and a bound that no schedule can beat
dispatching   the dispatcher with its critical sequence; models: steps and resources as atomic models
answers       the tables that `heavylift check` and `heavylift run` print for a yard
exchange      the schedule for other programs and as a Gantt chart; plans: schedules of other programs
"""

from heavylift.kernel.on_demand import face

face(__name__)
