"""Text for people: time spans, events in a planner's words, suggestions for misspelt names."""

from collections.abc import Callable, Sequence
from difflib import get_close_matches
from math import degrees
from typing import Any, TypeVar

from heavylift.kernel.errors import SPACES, printable

GENERATOR = "heavylift"  # by which a file says who made it
T = TypeVar("T")
FORMULAS = tuple("=+-@\t\r\uff1d\uff0b\uff0d\uff20")  # how they begin, in wide letters, too
MOST = 30  # names in a sentence


def shown(data: T) -> T:
    """Return data from an unknown source with each text converted to a single printable line."""
    made: Any = data
    if isinstance(data, str):
        made = printable(data, keep=SPACES)
    elif isinstance(data, dict):
        made = {shown(key): shown(value) for key, value in data.items()}
    elif isinstance(data, list | tuple):
        made = [shown(each) for each in data]
    return made  # type: ignore[no-any-return]


def cell(value: object) -> object:
    """Return a value as a CSV cell in a single line, with an apostrophe before text that would count as a formula."""
    if not isinstance(value, str):
        return value
    return f"'{shown(value)}" if value.lstrip()[:1] in FORMULAS else shown(value)


def meant(name: str, names: Sequence[str]) -> str:
    """Return the question "did you mean ...?" with the known names most similar to a given name; if none is similar, a
    list of all names."""
    lower = {x.lower(): x for x in names}
    near = [lower[x] for x in get_close_matches(name.lower(), lower, n=3, cutoff=0.7)]
    if near:
        return f"did you mean {' or '.join(near)}?"
    more = f" and {len(names) - MOST} more" if len(names) > MOST else ""
    return f"there are {', '.join(names[:MOST]) or 'none'}{more}"


def duration(seconds: float) -> str:
    """Return a time span as text for people: 3.2 s, 4 min 05 s, 1 h 06 min 04 s."""
    if seconds < 60:
        return f"{seconds:.3g} s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02} min {rest:02} s" if hours else f"{minutes} min {rest:02} s"


LISTED: dict[str, Callable[[dict[str, Any]], str]] = {  # events that planners follow, in their words
    "Stage": lambda x: f"stage {x['name']} begins" if x["name"] else "",
    "RopeState": lambda x: f"{x['actor']} {x['state']}",
    "Hooked": lambda x: f"{x['actor']} hooked to {x['lug']}",
    "Unhooked": lambda x: f"{x['actor']} unhooked",
    "Overload": lambda x: (
        f"load of {x['actor']} {'above' if x['over'] else 'back below'} its rated "
        f"{x['rated'] / 1e3:.1f} kN: {x['tension'] / 1e3:.1f} kN"
    ),
    "Tripped": lambda x: f"interlock {x['actor']} {'tripped' if x['over'] else 'reset'}{', bypassed' * x['bypassed']}",
    "Limit": lambda x: f"{x['actor']} stopped: {x['limit']}",
    "Lifted": lambda x: f"{x['actor']} lifted off",
    "Touched": lambda x: f"{x['actor']} touches {x['support']}",
    "Landed": lambda x: f"{x['actor']} landed on its {x['face']} face",
    "Attitude": lambda x: (
        f"{x['actor']} turned to {turn} deg" if (turn := round(degrees(x["angle"]))) % 30 == 0 else ""
    ),
    "BrakeState": lambda x: f"{x['actor']} {'engaged' if x['engaged'] else 'released'}",
    "Begun": lambda x: f"lift {x['actor']} begins",
    "Ended": lambda x: f"lift {x['actor']} done",
    "OperatorCommand": lambda x: f"operator: {x['text']}",
    "OperatorAnswer": lambda x: x["refused"] or x["text"],
    "Skipped": lambda x: f"{x['actor']}: its condition held already, not moved",
    "Finished": lambda _: "action list done",
}
