"""Model only what a scene requires: from what it asks and how accurately to the rung that answers at least cost.

    choose(plan, followed, question, named) -> Verdict: the fidelity, and every choice with its rule and reason

question   what a scene can ask                          case     the numbers of a scene that the rules need
rules      one small function per rule                   choose   which of them may be taken together
"""

from .choose import Verdict, choose
from .question import ASKABLE, Question

__all__ = ["ASKABLE", "Question", "Verdict", "choose"]
