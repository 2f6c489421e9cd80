"""The refusal of an order or a condition, without lines of the scene.

For an operator's command the sentence goes into a message; for the action list it is prefixed with its line.
"""

from __future__ import annotations

from heavylift.kernel.errors import ModelError


class OrderRejected(ModelError):
    """An order that cannot be carried out; `by`: numbers (action, order) of the order that conflicts, if any."""

    def __init__(self, sentence: str, by: tuple[int, ...] = ()) -> None:
        super().__init__(sentence)
        self.by = by
