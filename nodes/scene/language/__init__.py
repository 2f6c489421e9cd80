"""The language of orders and conditions in the action list.

phrases      the grammar of phrases after `target:`, `when:`, ...; the quantities that conditions measure
grammar      the parser of phrases, which reads them word by word with `words`
"""

from heavylift.kernel.on_demand import face

face(__name__)
