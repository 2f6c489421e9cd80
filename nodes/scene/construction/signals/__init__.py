"""What is measured in a scene, by words: in conditions, by interlocks, by models of a user's own.

subjects        hooks, ropes, boxes and winds by their names, and signals over them
conditions      conditions of the action list
interlocks      what stops a machine
own_models      what models of a user's own hear and lead
"""

from .conditions import Conditions, wrong_units
from .interlocks import build_interlocks
from .own_models import build_models, check_models

__all__ = ["Conditions", "build_interlocks", "build_models", "check_models", "wrong_units"]
