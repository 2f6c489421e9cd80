"""An operator's order during a run, written as `target: order` in the language of the action list.

It is read and checked like a line of the scene; an error is one sentence with a caret below the text.
"""

from typing import TYPE_CHECKING

from heavylift.kernel.errors import SceneError
from heavylift.nodes.plan import actions
from heavylift.nodes.scene.construction.machines import build_machines
from heavylift.nodes.scene.construction.resolve import build_orders
from heavylift.nodes.scene.language.grammar import read_order
from heavylift.nodes.scene.language.phrases import PhraseError
from heavylift.nodes.scene.language.words import LONGEST
from heavylift.nodes.scene.text.source import Mark, Path, SourceText

if TYPE_CHECKING:
    from .loaded_scene import LoadedScene

NAME = "command"
PLACE: Path = (NAME,)
NOWHERE = ""  # a command stands in no file, and its orders, which are on record, on no line


def spoken(scene: "LoadedScene", words: str) -> actions.Action:
    """Return the orders of an operator's command as an action; raises SceneError if the command is invalid."""
    words = " ".join(words.split())
    if len(words) > LONGEST:
        raise SceneError(f"{NAME}: it has {len(words)} characters; use at most {LONGEST}")
    target, colon, rest = words.partition(":")
    phrase = rest.strip()
    at = len(words) - len(phrase)
    if not colon or not phrase:
        raise _wrong(words, len(words), "name a target and its order, such as 'west H1: hoist 3 m/min by 2 m'")
    try:
        meant = read_order(phrase)
    except PhraseError as error:
        raise _wrong(words, at + error.column, str(error), error.hint) from None
    source = SourceText(NOWHERE)
    builder = build_machines(source, scene.scene)
    builder.machines, builder.interlocks = [*scene.plan.machines], scene.plan.interlocks
    source.keys[PLACE], source.values[PLACE] = Mark(NOWHERE, 1, 1, words), Mark(NOWHERE, 1, at + 1, words)
    orders = build_orders(builder, PLACE, target.strip(), meant)
    for fault in source.faults:
        column = source.mark(fault.path, on_key=fault.on_key).column - 1 + fault.column
        raise _wrong(words, column, fault.sentence, fault.hint)
    for order in orders:
        if message := _refused(scene, order):
            raise _wrong(words, at, message)
    return actions.Action(orders=orders)


def _refused(scene: "LoadedScene", order: actions.Order) -> str:
    """Return the reason why an order cannot be given during a run; "" if it can."""
    until = order.until if isinstance(order, actions.Move | actions.Turn) else None
    parts = until.all if isinstance(until, actions.And) else (until,)
    if any(isinstance(part, actions.CrossingCondition) for part in parts):
        return "a command cannot wait for a measured quantity: give a distance, or a time with 'until after'"
    if isinstance(order, actions.Move) and order.pulses:
        return "ramps without swing are possible only in the action list: give an acceleration, 'ramp 0.05 m/s2'"
    if isinstance(order, actions.Wait):
        return "a command does something at once; to wait, give it later"
    listed = (other for action in scene.plan.actions for other in action.orders)
    turned = {other.block for other in listed if isinstance(other, actions.Turn)}
    if isinstance(order, actions.Turn) and order.block not in turned:
        return "a block that the scene never turns cannot be turned"
    return ""


def _wrong(words: str, column: int, sentence: str, hint: str = "") -> SceneError:
    caret = f"{' ' * column}^{' ' + hint if hint else ''}"
    return SceneError(f"{NAME}: {sentence}\n    {words}\n    {caret}")
