"""What the commander raises for an order or a condition that cannot be; it says nothing of lines of the scene.

The sentence of an operator's command goes into a message, that of the action list gets its line in front.
"""

from __future__ import annotations

from heavylift.kernel.errors import ModelError

__all__ = ["Refused"]


class Refused(ModelError):
    """An order that cannot be carried out; `by` is (action, order) of the one that is in its way, where one is."""

    def __init__(self, sentence: str, by: tuple[int, ...] = ()) -> None:
        super().__init__(sentence)
        self.by = by
