"""One hash seed for all processes of a run, so that iteration over a set of strings has the same order in equal runs.

Python draws the seed at the start of a process unless PYTHONHASHSEED is set, so the process manager is started with a
fixed seed and the command `heavylift` restarts itself, in UTF-8 in any locale. A script that runs models in its own
process has a random seed; `loose` finds the models whose results may depend on it.
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
    """Return whether this process has the hash seed that is fixed for all runs."""
    return not sys.flags.hash_randomization


def start_again() -> None:
    """Restart this command with the fixed hash seed and UTF-8, unless another program has called it as a function."""
    message = os.environ.items() >= SEED.items()  # and not listened to: python -E
    if message or (fixed() and sys.flags.utf8_mode) or os.name != "posix":
        return
    if sys.orig_argv[-len(sys.argv) :] == sys.argv:
        os.execve(sys.executable, [sys.executable, *sys.orig_argv[1:]], {**os.environ, **SEED})


def loose(model: "Model") -> list[str]:
    """Return the paths of atomic models whose code or attributes contain sets, whose order depends on the hash seed."""
    from heavylift.nodes.devs import Atomic  # for which the command line need not wait
    from heavylift.nodes.devs.execution.flatten import tree

    return [
        m.path
        for m in tree(model)
        if isinstance(m, Atomic)
        and (any(isinstance(x, set | frozenset) for x in vars(m).values()) or any(map(_makes_sets, _code(type(m)))))
    ]


def _code(cls: type) -> Iterator[CodeType]:
    """Yield the code of the functions of a class and its bases outside this package."""
    for base in cls.__mro__:
        if not base.__module__.startswith("heavylift."):
            yield from (x.__code__ for x in vars(base).values() if isinstance(x, FunctionType))


def _makes_sets(code: CodeType) -> bool:
    """Return whether the code creates or iterates over a set; constants in membership tests do not count."""
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
