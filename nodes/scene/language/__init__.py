"""The language of the action list.

phrases      phrases to the right of `target:`, `when:`, ...; the quantities that conditions measure
grammar      reads phrases, by `words`
"""

from heavylift.kernel.on_demand import face

face(__name__)
