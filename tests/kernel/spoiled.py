"""Randomly corrupted descriptions: numbers, names, choices and whole items replaced by invalid ones."""

from dataclasses import fields, is_dataclass, replace
from math import inf, nan
from random import Random

import numpy as np
from heavylift.kernel import KernelError
from heavylift.kernel.description import System
from heavylift.kernel.simulation import Simulation
from msgspec import Struct
from msgspec.structs import replace as replace_struct

NUMBERS = (0.0, 1.0, -1.0, 0.5, -0.0, 1e-9, -1e-9, 5e-324, 1e-160, 1e160, 1e308, -1e308, nan, inf, -inf)
NAMES = ("", "world", "nobody", "block")
SPAN_NS = 20_000_000
PATIENCE = 30  # native calls, each of some thousand steps at most; what is stiff beyond reason may be slow


def numbered(x):
    """Whether a tuple is made of numbers, to the bottom."""
    return all(numbered(e) if isinstance(e, tuple) else isinstance(e, float | int) for e in x)


def spoiled(x, random: Random):
    """x with one thing in it changed."""
    if isinstance(x, bool):
        return not x
    if isinstance(x, float | int):
        return random.choice((*NUMBERS, x * 1e6, x * 1e-6, -x, x + 1.0))
    if isinstance(x, str):
        return random.choice((*NAMES, x + "x", x.upper()))
    if isinstance(x, tuple):
        if not x:
            return x
        i = random.randrange(len(x))
        if random.random() < 0.15 and not numbered(x):
            return x[:i] + x[i + 1 :] if random.random() < 0.5 else (*x, x[i])
        return (*x[:i], spoiled(x[i], random), *x[i + 1 :])
    if is_dataclass(x) or isinstance(x, Struct):
        names = x.__struct_fields__ if isinstance(x, Struct) else [f.name for f in fields(x)]
        weights = [0.3 if isinstance(getattr(x, n), str) else len(str(getattr(x, n))) ** 0.5 for n in names]
        name = random.choices(names, weights)[0]
        new = {name: spoiled(getattr(x, name), random)}
        if name in ("q0", "v0") and not getattr(x, name):
            new = {name: random.choice(((1.0,), (nan,), (0.5,) * 3, (0.0,) * 6, (0.0,) * 7))}
        return replace_struct(x, **new) if isinstance(x, Struct) else replace(x, **new)
    return x


def misfit(x, random: Random):
    """x with one thing in it of another type or shape, or in another container."""
    if isinstance(x, tuple) and (not x or random.random() < 0.3):
        array = [np.array(x), np.full(np.shape(x), nan)] if x and numbered(x) else []
        return random.choice((list(x), x[:-1], (*x, *x[:1]), x[0] if x else None, *array))
    if isinstance(x, tuple):
        i = random.randrange(len(x))
        return (*x[:i], misfit(x[i], random), *x[i + 1 :])
    if is_dataclass(x) or isinstance(x, Struct):
        names = x.__struct_fields__ if isinstance(x, Struct) else [f.name for f in fields(x)]
        name = random.choice(names)
        new = {name: misfit(getattr(x, name), random)}
        return replace_struct(x, **new) if isinstance(x, Struct) else replace(x, **new)
    return random.choice((None, "heavy", 2.5, True, [1.0], {}, (nan,), np.float32(nan), np.float64(1.0), 10**400, x))


class Slow(Exception):
    """The run is not wrong, only long."""


def outcome(system: System) -> str:
    """ "ran", "slow" or the sentence that refuses or ends it; anything else is raised."""
    left = PATIENCE

    def pause():
        nonlocal left
        left -= 1
        if not left:
            raise Slow

    try:
        s = Simulation(system, 1e-4, 5_000_000, opt=0, cache=False)
        s.start()
        s.run(SPAN_NS, pause)
        s.interrupt(SPAN_NS)
    except KernelError as error:
        return str(error)
    except Slow:
        return "slow"
    for t, row in s.rows:
        assert all(abs(x) < inf for x in row.tolist()), f"not finite at {t} ns"
    return "ran"
