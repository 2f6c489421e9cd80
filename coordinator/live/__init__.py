"""Runs in progress: how they are watched and operated.

    find("turnover.mcap")          the run that writes this recording; also by run id, by scene, or the only one
    observe(find())                all its events so far and then live, as (number, event)
    order(find(), RunOrder("pause"))  what the commands pause, step, continue, command and stop send
    operator_commands(recording)   an operator's commands in a run, for run(..., commands=...)

On the coordinator's side `shown` makes a run findable and shows its events.  LIVE.md states the guarantees for
observers, for real time and for an operator's orders.

announce, observers                  finding a run and giving orders; data for observers, and as lines of text
command_queue                        queue of an operator's orders
keys, pace                           keys of the terminal; rate and pauses of a run
"""

from heavylift.kernel.on_demand import face

from .announce import AnnouncedRun, Notice, RunOrder, find, order, running
from .command_queue import TimedCommand, operator_commands
from .observers import EventPublisher, Observer, RunEnded, observe, shown
from .pace import Pace, RealTime

__all__ = [
    "AnnouncedRun", "EventPublisher", "Notice", "Observer", "Pace", "RealTime", "RunEnded", "RunOrder", "TimedCommand",
    "find", "observe", "operator_commands", "order", "running", "shown",
]  # fmt: skip

face(__name__)
