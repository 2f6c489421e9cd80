"""No steps at all: the equations as they are, for statics, with the least code around them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from .peers import Peer

__all__ = ["AtRest"]


class AtRest(Peer):
    """A method of which nothing but evaluations is asked; one-sided laws are smooth beyond their guards."""

    name = "at-rest"
    vectors = ()

    def __init__(self) -> None:
        self.solver = ""

    def interpolate(self, s: SimpleNamespace, x: Any) -> Any:
        return s.d0
