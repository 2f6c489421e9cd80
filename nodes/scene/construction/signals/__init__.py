"""What is measured in a scene, by words: in conditions, by interlocks, by models of a user's own.

subjects        hooks, ropes, boxes and winds by their names, and signals over them
conditions      conditions of the action list
interlocks      what stops a machine
limits          the table of limits, with signals that the scene limits itself
own_models      what models of a user's own hear and lead
"""

from .conditions import Conditions, wrong_units
from .interlocks import build_interlocks
from .limits import build_limits
from .own_models import build_models, check_models

__all__ = ["Conditions", "build_interlocks", "build_limits", "build_models", "check_models", "wrong_units"]
