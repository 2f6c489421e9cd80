"""Model only what a scene requires: from what it asks and how accurately to the rung that answers at least cost.

    choose(plan, followed, question, named) -> Verdict: fidelity, method, tolerance; every choice with its reason

question   what a scene can ask                          case     the numbers of a scene that the rules need
rules      one small function per rule                   choose   which of them may be taken together
always     what is left out without a question           cost     states and evaluations, predicted
method     method and tolerance by cost (STEPS.md)       verdict  the report, and what is not promised
"""

from .choose import choose, unpromised
from .question import ASKABLE, Question
from .verdict import Verdict

__all__ = ["ASKABLE", "Question", "Verdict", "choose", "unpromised"]
