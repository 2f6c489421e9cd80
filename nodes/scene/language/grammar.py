"""Parser for the phrases of an action list; `phrases` documents the grammar.

It is a recursive-descent parser over one line; every error is a sentence with its column.
"""

import re
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from typing import Literal, TypeVar, cast

import msgspec
from heavylift.nodes.plan.actions import AfterCondition, MovesDone
from heavylift.nodes.plan.verbs import VERBS, Verb
from heavylift.nodes.scene.text import units
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.units import Dimension
from heavylift.recordings.format.spellings import BEAM

from .phrases import (
    QUANTITIES,
    ConditionPhrase,
    CrossTest,
    GroundTest,
    OrderPhrase,
    PhraseError,
    SlingTest,
    State,
    SwingRamp,
    Test,
)
from .words import PhraseReader

Phrase = TypeVar("Phrase")


def read_order(text: str) -> OrderPhrase:
    """Parse an order; raises PhraseError if the text is not a valid order."""
    return _whole(text, _order)


def read_ramp(text: object, dimension: Dimension) -> float | SwingRamp:
    """Return a ramp's acceleration in SI units, or a ramp without swing; raises ValueError if the text is neither."""
    if not isinstance(text, str) or not {"one", "in"} & set(text.split()):
        return dimension.read(text)
    return _whole(text, lambda r: _ramp(r, dimension))


def read_condition(text: str) -> ConditionPhrase:
    """Parse a condition; raises PhraseError if the text is not a valid condition."""
    return _whole(text, _condition)


def _whole(text: str, reads: Callable[[PhraseReader], Phrase]) -> Phrase:
    reader = PhraseReader(text)
    phrase = reads(reader)
    reader.end()
    return phrase


def _order(r: PhraseReader) -> OrderPhrase:
    column = r.at
    name = r.take(*VERBS)
    if not name:
        raise r.error(f"an order begins with a verb, not {r._found()}", closest(r.next, VERBS))
    verb = VERBS[name]
    match verb.becomes:
        case "own":
            own: OrderPhrase = import_module(verb.module).phrase(r)
            return replace(own, verb=name)
        case "wait":
            return OrderPhrase(name, seconds=r.quantity(units.DURATION))
        case "hook":
            return OrderPhrase(name, lugs=_lugs(r) if r.next else ())
        case "level":
            return _level(r, name)
        case "stop" if not verb.engages and r.take("ramp"):
            turning = r.turning
            return OrderPhrase(name, turning=turning, ramp=r.positive(units.STROKE_RAMP))
        case "stop" if verb.engages and r.take("height"):
            return OrderPhrase(name, height=True)
        case "move" | "turn":
            return _motion(r, verb)
    if r.next:
        raise PhraseError(f"nothing can follow '{name}': remove '{r.text[r.at :]}'", "", column)
    return OrderPhrase(name)


def _motion(r: PhraseReader, verb: Verb) -> OrderPhrase:
    turning, pulls = verb.units == "turning" or (verb.units == "either" and r.turning), verb.units == "pulling"
    speed = r.positive(units.TENSION_RATE if pulls else units.RATE if turning else units.SPEED)
    stroke = units.FORCE if pulls else units.ANGLE if turning else units.LENGTH
    ramps = units.ANGULAR_ACCELERATION if turning else units.ACCELERATION
    ramp = _ramp(r, ramps) if not pulls and r.take("ramp") else None
    if isinstance(ramp, SwingRamp) and verb.becomes == "turn":
        raise r.error("hooks move on arcs in a turn, so no ramp avoids swing: write only an acceleration after 'ramp'")
    goals = ("to",) if verb.becomes == "turn" else ("by", "to", "until")
    word = r.expect(*goals, after=f"after the {'rate' if verb.becomes == 'turn' else 'speed'}")
    order = OrderPhrase(verb.name, speed, turning, ramp)
    if word == "until":
        order = replace(order, until=_condition(r))
    elif word == "by":
        order = replace(order, by=r.positive(stroke) if verb.sign else r.quantity(stroke), until=_or_until(r))
    elif verb.becomes == "move" and not verb.sign and not pulls and r.take("above"):
        order = replace(order, above=_lugs(r, "above"), until=_or_until(r))
    else:
        to = r.quantity(stroke)
        of_rope = verb.becomes == "move" and bool(r.take("of"))
        if of_rope:
            r.expect("rope", after="after 'of'")
        order = replace(order, to=to, of_rope=of_rope, until=_or_until(r))
    r.take(",")
    return replace(order, together=verb.becomes == "move" and bool(r.take("together")))


def _level(r: PhraseReader, name: str) -> OrderPhrase:
    speed = r.positive(units.SPEED)
    r.expect("within", after="after the speed")
    within = r.positive(units.ANGLE)
    to = r.quantity(units.ANGLE) if r.take("at") else None
    r.expect("with", after="after the angle")
    hooks = [_names(r)]
    while r.take(","):
        hooks.append(_names(r))
    return OrderPhrase(name, speed, to=to, within=within, hooks=tuple(hooks))


def _ramp(r: PhraseReader, dimension: Dimension) -> float | SwingRamp:
    if r.take("one"):
        r.expect("swing", after="after 'ramp one'")
        return SwingRamp()
    accel = r.positive(dimension)
    if not r.take("in"):
        return accel
    r.expect("two", after="after 'in'")
    r.expect("pulses", after="after 'two'")
    return SwingRamp(2, accel)


def _or_until(r: PhraseReader) -> ConditionPhrase | None:
    if not r.take("or"):
        return None
    r.expect("until", after="after 'or'")
    return _condition(r)


def _lugs(r: PhraseReader, after: str = "hook") -> tuple[str, ...]:
    r.expect("[", after=f"after '{after}'")
    lugs = [r.name("the name of a lug")]
    while r.expect(",", "]", after="after a lug") == ",":
        lugs.append(r.name("the name of a lug"))
    return tuple(lugs)


def _condition(r: PhraseReader) -> ConditionPhrase:
    tests = [_worded(r)]
    while r.take("and"):
        tests.append(_worded(r))
    return tuple(tests)


def _worded(r: PhraseReader) -> Test:
    start = r.at
    test = _test(r)
    return msgspec.structs.replace(test, text=r.text[start : r.at].strip())


def _test(r: PhraseReader) -> Test:
    column = r.at
    if r.take("after"):
        return AfterCondition(seconds=r.quantity(units.DURATION))
    moves = ("moves", *(verb.name for verb in VERBS.values() if verb.becomes in ("move", "turn")))
    states = ("lifted", "landed") if r.next in moves else ("lifted", "landed", "done")
    of = r.name("a block") if re.match(rf"[\w-]+\s+({'|'.join(states)})\b", r.text[r.at :]) else ""
    state = r.take(*states)
    if state:
        on = r.name("what it lands on") if state == "landed" and r.take("on") else ""
        return GroundTest(cast(Literal["lifted", "landed", "done"], state), column, of, on)
    first = r.take(*moves)
    if first:
        stopped = r.expect("done", "stopped", after=f"after '{first}'") == "stopped"
        return MovesDone(verbs=() if first == "moves" else (first,), stopped=stopped)
    if r.next in {quantity.split()[0] for quantity in QUANTITIES}:
        return _crossing(r)
    return _tension_state(r)


def _tension_state(r: PhraseReader) -> SlingTest:
    column = r.at
    if r.next in {"taut", "slack"}:
        message = f"'{r.next}' needs to know of what"
        raise r.error(message, f"write 'all slings {r.next}'")
    each = r.take("all", "any")
    noun = r.take("slings", "ropes")
    of = ""
    if not noun:
        word = r.next
        if not each and word not in {"", "the"} and not re.search(r"\b(taut|slack)\b", r.text[r.at :]):
            words = ("all slings taut", "moves done", "lifted", "landed", "after 60 s", *QUANTITIES)
            raise r.error(f"'{word}' begins no condition", closest(word, words))
        of = r.name("a set of slings")
        noun = r.take("slings", "ropes")
    if each == "" and noun:
        each = "all"
    if each and not noun:
        raise r.error(f"'slings' or 'ropes' must follow, not {r._found()}", closest(r.next, ("slings", "ropes")))
    state = r.expect("taut", "slack", after="after the slings")
    return SlingTest(
        cast(Literal["all", "any"], each or "all"),
        of,
        cast(Literal["slings", "ropes", "one"], noun or "one"),
        cast(State, state),
        column,
    )


def _crossing(r: PhraseReader) -> CrossTest:
    column = r.at
    quantity = _quantity(r)
    row, of = QUANTITIES[quantity], ""
    if row.of == "two":
        r.take("of")
        of = f"{r.name('a name')} {r.name('a second name')}"
    elif row.of != "none" and r.take("of"):
        of = _names(r)
    elif row.of == "one":
        raise r.error(f"'{quantity}' needs 'of' and a name, such as '{quantity} of {BEAM}-1'")
    at = r.at
    sign = r.take(">=", "<=", "==", "=", ">", "<")
    if sign in {"=", "=="}:
        message = "two real numbers are never exactly equal"
        rest = r.text[r.at :]
        raise PhraseError(message, f"write '{quantity} >= {rest}' or '{quantity} <= {rest}'", at)
    if sign in {">", "<"}:
        raise PhraseError(f"write '{sign}=' instead of '{sign}'", "", at)
    if not sign:
        r.expect(">=", "<=", after=f"after '{quantity}'")
    turning, share = r.turning, row.rated and r.share
    value = r.quantity(units.RATIO if share else row.dimension)
    return CrossTest(quantity, of, sign == ">=", value, turning, column, share)


def _quantity(r: PhraseReader) -> str:
    """Read and return the longest name of a quantity at the present place."""
    words = r.take(*{quantity.split()[0] for quantity in QUANTITIES})
    seconds = [quantity.split()[1] for quantity in QUANTITIES if quantity.startswith(f"{words} ")]
    more = r.take(*seconds) if words in QUANTITIES or not seconds else r.expect(*seconds, after=f"after '{words}'")
    return f"{words} {more}".strip()


def _names(r: PhraseReader) -> str:
    """Read and return a name of one or two words ("west H1"), or a set of slings or ropes."""
    if r.take("all", "any") == "any":
        return "any " + r.expect("hook", "sling", after="after 'any'")
    names = [r.name("a name")] if r.next not in {"slings", "ropes"} else []
    if noun := r.take("slings", "ropes"):
        return " ".join([*names, noun])
    if r.next not in {">=", "<=", "==", "=", ">", "<", ",", ""}:
        names.append(r.name("a name"))
    return " ".join(names)
