"""Corrupted descriptions of random mechanisms run or are refused in one sentence."""

from dataclasses import fields, is_dataclass, replace
from math import inf, nan

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import JOINTS, WORLD, Brake, JointSpring, Lock, Stop
from heavylift.kernel.simulation import Simulation
from random_trees import KINDS, random_system
from small_scenes import SECOND, hand_over

NUMBERS = (nan, inf, -inf, 0.0, -1.0, 1.0, 1e300, -1e300, 1e-300, 1e9)
SHORT = SECOND // 100


def equipped(seed):
    """A mechanism with a law of each sort on some coordinate."""
    rng = np.random.default_rng(seed)
    system = random_system(seed, 4, 2.0, kinds=(*KINDS, "constant-velocity"))
    free = [(j.name, c) for j in system.joints for c in JOINTS[j.kind].actable]
    moving = next(j.name for j in system.joints if JOINTS[j.kind].n_v)
    if free:
        j, c = free[int(rng.integers(len(free)))]
        system = replace(
            system,
            springs=(JointSpring("spring", j, 1e3, 10.0, coordinate=c),),
            stops=(Stop("stop", j, -1.0, 1.0, 1e5, 1e2, coordinate=c),),
            brakes=(Brake("brake", j, 10.0, 1e5, 1e2, engaged=True, coordinate=c),),
        )
    return replace(system, locks=(Lock("lock", moving),))


def spoilt(x, rng):
    """The same with one number, name or kind replaced, anywhere inside."""
    if isinstance(x, tuple) and x:
        i = int(rng.integers(len(x)))
        if is_dataclass(x[0]) and rng.random() < 0.3:
            return x[:i] + x[i + 1 :] if rng.random() < 0.5 else (*x, x[i])
        return (*x[:i], spoilt(x[i], rng), *x[i + 1 :])
    if is_dataclass(x):
        names = [f.name for f in fields(x) if getattr(x, f.name) not in ((), None)]
        name = names[int(rng.integers(len(names)))]
        value = getattr(x, name)
        if name == "kind":
            return replace(x, kind=list(JOINTS)[int(rng.integers(len(JOINTS)))])
        if isinstance(value, str):
            return replace(x, **{name: str(rng.choice(["b0", "b1", "j1", WORLD, "nothing", ""]))})
        return replace(x, **{name: spoilt(value, rng)})
    if isinstance(x, float):
        return NUMBERS[int(rng.integers(len(NUMBERS)))]
    return x


@pytest.mark.parametrize("seed", range(24))
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_random_description_of_a_system_runs_or_is_refused(seed):
    rng = np.random.default_rng(seed)
    system = equipped(seed)
    for _ in range(1 + seed % 3):
        system = spoilt(system, rng)
    message = ""
    try:
        s = Simulation(system, opt=0, cache=False)
        s.start()
        hand_over(s, SHORT)
        s.settle()
        for lock in s.program.system.locks[:1]:
            s.set_lock(lock.name, True)
            s.settle()
        hand_over(s, 2 * SHORT)
        assert np.isfinite(s.state).all()
    except KernelError as error:
        message = str(error)
    assert "\n" not in message


def test_random_corruption_of_descriptions_reaches_every_field():
    """The mutations change numbers and lists."""
    rng = np.random.default_rng(1)
    made = [spoilt(equipped(3), rng) for _ in range(200)]
    assert {len(m.bodies) for m in made} == {3, 4, 5}
    assert any("nan" in repr(b) for m in made for b in m.bodies)
