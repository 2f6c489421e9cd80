"""Tables of functions: mechanics or DEVS models that Python builds from parameters, and responses of runs.

def period(length):                                     def shop(servers):
    return {"T": ..., "top": ...}                           return Coupled(...)

tabulate(period, {"length": [1.0, 2.0]})                tabulate("shop.py:shop", {"servers": [1, 2, 3]}, until=3600.0)
"""

import re
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import nullcontext
from itertools import product
from pathlib import Path
from typing import Any

import msgspec
from heavylift.coordinator.run.models import referred, run_models
from heavylift.coordinator.run.replications import numbers
from heavylift.coordinator.supervision.pool import Pool, cores, submits
from heavylift.kernel import errors
from heavylift.kernel.description.user_code import raised
from heavylift.kernel.errors import HeavyliftError, ModelError, SceneError
from heavylift.nodes.devs import Coupled
from heavylift.nodes.devs.references import imported, read

NAME = re.compile(r"[A-Za-z_][\w. -]*")  # of a response
Value = float | int | str | bool


def tabulate(
    function: str | Callable[..., Any],
    values: Mapping[str, Sequence[Value]],
    executor: Executor | None = None,
    workers: int = 0,
    until: float | None = None,
) -> list[dict[str, Value]]:
    """Call a function with all combinations of values of its arguments; return a row of arguments and results for each.

    The function, or its reference "module:name" or "file.py:name", returns a number, numbers by name, or a Coupled DEVS
    model, which is run to its end or `until` [s] and whose results are named "path.field". `executor`: any object whose
    `submit` returns a future; default: a pool of `workers` processes. Raises HeavyliftError.
    """
    if executor is not None and not submits(executor):
        raise ModelError(f"executor={executor!r}: give an object with `submit`, such as one of concurrent.futures")
    if not values or not all(isinstance(x, Sequence) and not isinstance(x, str) and x for x in values.values()):
        raise ModelError(f"values={values!r:.80}: give a list of values for each argument, such as {{'k': [1, 2]}}")
    reference = referred(function)
    given = [dict(zip(values, row, strict=True)) for row in product(*values.values())]
    with nullcontext(executor) if executor else Pool(min(workers or cores(), len(given))) as pool:
        answers = [pool.submit(_row, reference, row, until) for row in given]
        return [{**row, **_read(answer.result())} for row, answer in zip(given, answers, strict=True)]


def _row(reference: str, given: dict[str, Value], until: float | None) -> bytes:
    """Return the encoded numbers of one call, or its error."""
    try:
        found = called(reference, **given)
        if isinstance(found, Coupled):
            where, name, arguments, named = read(reference)
            words = [*map(repr, arguments), *(f"{key}={x!r}" for key, x in {**named, **given}.items())]
            run = run_models(f"{where}:{name}({', '.join(words)})", until, in_process=True)
            found = {name: x for path, result in run.results.items() for name, x in numbers(path, result)}
        row = found if isinstance(found, Mapping) else {"result": found}
        return msgspec.msgpack.encode(({str(name): float(x) for name, x in row.items()}, "", ""))
    except HeavyliftError as error:
        return msgspec.msgpack.encode(({}, type(error).__name__, f"{given}: {error}"))
    except (TypeError, ValueError, OverflowError) as error:
        message = f"{given}: {reference} returns something other than numbers ({error})"
        return msgspec.msgpack.encode(({}, ModelError.__name__, message))


def _read(answer: bytes) -> dict[str, float]:
    values, kind, sentence = msgspec.msgpack.decode(answer, type=tuple[dict[str, float], str, str])
    if sentence:
        raise getattr(errors, kind, ModelError)(sentence)
    return values


def responses_of(given: Sequence[str]) -> dict[str, str]:
    """Read texts NAME=REFERENCE, such as "sway=own.py:sway"; return the reference of each function by name.

    Raises HeavyliftError for a function that does not exist.
    """
    found = dict[str, str]()
    for text in given:
        name, _, reference = text.partition("=")
        if not NAME.fullmatch(name) or ":" not in reference or name in found:
            raise SceneError(f"--response '{text}': give NAME=FUNCTION, each name once, such as 'sway=own.py:sway'")
        where = reference.partition("(")[0].rpartition(":")[0]
        whole = str(Path(where).resolve()) if where.endswith(".py") else where  # as seen from any folder
        found[name] = whole + reference[len(where) :]
        _function(found[name])
    return found


def _function(reference: str) -> tuple[Callable[..., Any], list[object], dict[str, object]]:
    where, name, arguments, named = read(reference)
    function = getattr(imported(where), name, None)
    if not callable(function):
        raise ModelError(f"{reference}: {where} has no function {name}")
    return function, arguments, named


def called(reference: str, *first: object, **more: object) -> Any:
    """Call the function that a reference names with the given arguments; raises ModelError if there is none, or if it
    fails."""
    function, arguments, named = _function(reference)
    try:
        return function(*first, *arguments, **named, **more)
    except HeavyliftError:
        raise
    except Exception as error:
        raise ModelError(f"{reference}: the function raised {raised(error)}") from error
