"""Where in a scene an action or an order stands, for sentences: messages carry numbers, the plan has the lines.

So a file name or a line number is in no message, and what a run says to itself does not depend on them.
"""

from __future__ import annotations

from .plan import Plan

__all__ = ["ASIDE", "located", "numbered", "place"]

ASIDE = -2  # in place of the number of an action: a command of an operator
COMMAND = "command"  # what stands in place of the line of a command


def place(plan: Plan, at: tuple[int, ...]) -> str:
    """`file:line:column` of an order at (action, order) or of an action at (action,); its numbers if it has none."""
    action, *order = at
    if action == ASIDE:
        return COMMAND
    listed = plan.actions[action]
    found = listed.orders[order[0]].where if order else listed.where
    return found or numbered(at)


def numbered(at: tuple[int, ...]) -> str:
    """The same in numbers from 1: "order 2 of action 5"."""
    action, *order = at
    if action == ASIDE:
        return "an operator's command"
    return f"order {order[0] + 1} of action {action + 1}" if order else f"action {action + 1}"


def located(plan: Plan, sentence: str, at: tuple[int, ...]) -> str:
    """A sentence that speaks of an order by its numbers, with its line instead."""
    return sentence.replace(numbered(at), place(plan, at)) if at and at[0] != ASIDE else sentence
