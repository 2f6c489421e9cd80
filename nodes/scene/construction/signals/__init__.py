"""Measured signals that a scene describes in words: in conditions, interlocks and user models.

subjects        hooks, ropes, boxes and winds by name, and the signals of their quantities
conditions      conditions of the action list
interlocks      interlocks, which stop a machine without the commander
limits          the table of limits, including signals that the scene itself limits
own_models      signals and set-points of user models
"""

from .conditions import Conditions, wrong_units
from .interlocks import build_interlocks
from .limits import build_limits
from .own_models import build_models, check_models

__all__ = ["Conditions", "build_interlocks", "build_limits", "build_models", "check_models", "wrong_units"]
