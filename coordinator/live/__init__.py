"""Runs in progress: how they are watched and operated.

    find("turnover.mcap")          the run that writes this recording; also by run id, by scene, or the only one
    observe(find())                all its events so far and then live, as (number, event)
    order(find(), RunOrder("pause"))  what the commands pause, step, continue, command and stop send
    operator_commands(recording)   what an operator said in a run, for run(..., commands=...)

On the coordinator's side `shown` makes a run findable and shows its events.  What holds for observers, for real time
and for an operator's orders stands in LIVE.md.

announce, observers                  how a run is found and given orders; what observers are shown, as a line for people
command_queue                        an operator's orders, and where a run takes them
keys, pace                           keys of the terminal; how fast a run goes, and when it may go on
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
