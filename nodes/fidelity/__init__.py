"""Model only what a scene requires: the cheapest fidelity that answers what it asks as accurately as it asks.

    choose(plan, followed, question, named) -> Verdict: fidelity, method, tolerance; every choice with its reason

lifts, following      a lift as the rules read it, and its path at rest
case, hooks, moving   the numbers of a scene that the rules need
response, rests    how a load answers the whole action list; how its rest moves along the static path
rules, always      one small function per rule; what is left out without a question
chance             what two models may differ by, however little is between them
choose, cost       which rules may be taken together; states and evaluations, predicted
method             method and tolerance by cost (STEPS.md)
verdict, own       the report, and what is not guaranteed; what the fidelity of a scene leaves out
"""

from heavylift.kernel.on_demand import face
from heavylift.nodes.plan.fidelity import ASKABLE, Question

from .choose import choose, unpromised
from .following import Following, following
from .lifts import lift_of
from .verdict import Verdict

__all__ = ["ASKABLE", "Following", "Question", "Verdict", "choose", "following", "lift_of", "unpromised"]

face(__name__)
