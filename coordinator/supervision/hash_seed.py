"""One seed for the hashes of all processes of a run: who iterates over a set of strings does so alike in equal runs.

Python draws the seed at the start of a process unless PYTHONHASHSEED says otherwise, so the keeper is started with it
and the command `heavylift` starts itself again, in UTF-8 in any locale.  A script that runs models in its own
process has its seed already: `loose` finds the models that may show it.
"""

import os
import sys
from collections.abc import Iterator
from types import CodeType, FunctionType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from heavylift.nodes.devs import Model

SEED = {"PYTHONHASHSEED": "0", "PYTHONUTF8": "1"}


def fixed() -> bool:
    """Whether this process has the hash seed of all runs."""
    return not sys.flags.hash_randomization


def start_again() -> None:
    """Restart this command with the fixed hash seed; does nothing if another program called it."""
    message = os.environ.items() >= SEED.items()  # and not listened to: python -E
    if message or (fixed() and sys.flags.utf8_mode) or os.name != "posix":
        return
    if sys.orig_argv[-len(sys.argv) :] == sys.argv:
        os.execve(sys.executable, [sys.executable, *sys.orig_argv[1:]], {**os.environ, **SEED})


def loose(model: "Model") -> list[str]:
    """Paths of the atomics whose code creates sets or whose attributes contain them."""
    from heavylift.nodes.devs import Atomic  # for which the command line need not wait
    from heavylift.nodes.devs.execution.flatten import tree

    return [
        m.path
        for m in tree(model)
        if isinstance(m, Atomic)
        and (any(isinstance(x, set | frozenset) for x in vars(m).values()) or any(map(_makes_sets, _code(type(m)))))
    ]


def _code(cls: type) -> Iterator[CodeType]:
    """Code of the functions of a class and its bases outside this package."""
    for base in cls.__mro__:
        if not base.__module__.startswith("heavylift."):
            yield from (x.__code__ for x in vars(base).values() if isinstance(x, FunctionType))


def _makes_sets(code: CodeType) -> bool:
    """Whether the code creates a set other than a constant used for membership tests."""
    import dis

    before = None
    for step in dis.get_instructions(code):
        if step.opname in ("BUILD_SET", "SET_ADD") or (
            step.opname == "GET_ITER" and before is not None and isinstance(before.argval, frozenset)
        ):
            return True
        if step.opname == "LOAD_GLOBAL" and step.argval in ("set", "frozenset"):
            return True
        before = step
    return any(_makes_sets(x) for x in code.co_consts if isinstance(x, CodeType))
