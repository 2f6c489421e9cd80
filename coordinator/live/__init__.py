"""A run while it runs: who may look at it, and what an operator may do to it.

    find("turnover.mcap")          the run that writes this recording; also by run id, by scene, or the only one
    observe(find())                all its events so far and then live, as (number, event)

On the coordinator's side `shown` makes a run findable and shows its events.  What holds for observers, for real time
and for an operator's orders stands in LIVE.md.
"""

from .announce import Found, Notice, find, running
from .audience import Audience, Ended
from .observe import Observer, observe
from .show import shown

__all__ = ["Audience", "Ended", "Found", "Notice", "Observer", "find", "observe", "running", "shown"]
