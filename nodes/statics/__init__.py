"""Statics of a scene: the equilibrium path along its action list.

StaticState   a point of that path: what stands where, and what carries how much
"""

from .state import StaticState

__all__ = ["StaticState"]
