"""Places of actions and orders in a scene, for error messages: messages of a run contain numbers, and the plan maps
them to lines.

So no message in a run contains a file name or a line number, and a run does not depend on them.
"""

from .plan import Plan

ASIDE = -2  # in place of the number of an action: a command of an operator
LED = -3  # the same: a set-point of a model
WHEN = -1  # in place of the number of an order: the condition of the action
COMMAND = "command"  # what stands in place of the line of a command


def place(plan: Plan, at: tuple[int, ...]) -> str:
    """Return `file:line:column` of an action or order; if unknown, words such as "order 2 of action 5"."""
    action, order = _split(at)
    if action == ASIDE:
        return COMMAND
    listed = plan.action(action)
    return (listed.where if order is None else listed.orders[order].where) or numbered(at)


def numbered(at: tuple[int, ...]) -> str:
    """Return the numbers of an action and order as words, counted from 1, such as "order 2 of action 5"."""
    action, order = _split(at)
    if action < WHEN:
        return "a set-point" if action == LED else "an operator's command"
    return f"action {action + 1}" if order is None else f"order {order + 1} of action {action + 1}"


def located(plan: Plan, sentence: str, at: tuple[int, ...]) -> str:
    """Return a sentence in which the numbers of an action and order are replaced by their place in the scene file."""
    return sentence.replace(numbered(at), place(plan, at)) if at and at[0] != ASIDE else sentence


def _split(at: tuple[int, ...]) -> tuple[int, int | None]:
    """Return the numbers of the action and the order; the second is None for the condition of the action itself."""
    return at[0], at[1] if len(at) > 1 and at[1] != WHEN else None
