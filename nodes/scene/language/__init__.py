"""The language of the action list.

phrases      what is written to the right of `target:`, `when:`, ...
quantities   what conditions measure
grammar      reads it, by words
"""

from heavylift.kernel.on_demand import face

face(__name__)
