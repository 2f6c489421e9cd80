"""A simulation called out of order reports the call that is due; accepted calls act at their time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import Drive, Line, Point, Rope, System, Threshold
from heavylift.kernel.islands import Islands
from heavylift.kernel.simulation import Simulation
from small_scenes import MASS, SECOND, X, hand_over, hung, slider, started

END = 3 * SECOND
CALLS = 60  # of a story
EXACT = 1e-6  # of a free fall at the default tolerance


def yard() -> System:
    """Two scenes that nothing ties together: a load that falls into its rope, and a cart on a rail."""
    fall, cart = hung(59.8, winch=True, damping=3e5), slider("cart", 2.0e4, axis=X)
    return replace(
        fall,
        bodies=fall.bodies + cart.bodies,
        joints=fall.joints + cart.joints,
        ropes=(*fall.ropes, Rope("tag", (Line(Point("world", (40.0, 0.0, 0.0)), Point("cart")),), 1e6, 42.0)),
        drives=(Drive("travel", "cart-guide", "servo", 1.0e6, 2.0e5),),
        thresholds=(Threshold("far", "joint", of="cart-guide"), Threshold("low", "joint", of="load-guide")),
    )


def build(face: type) -> Any:
    s = face(yard(), sample_ns=SECOND // 5, subscribed=frozenset({"rope", "far", "low"}))
    s.start()
    return s


def a_call(random: np.random.Generator, s: Any) -> tuple[str, Callable[[Any], object]]:
    """Any call with any time, and what it is."""
    t, u = int(random.integers(0, END)), random.uniform
    speed, distance = u(-0.5, 0.5), u(-2.0, 2.0)
    t = random.choice([t, s.epoch, min(END - 1, s.epoch + t // 20), min(END - 1, s.next_ns)])
    start, value, rising = s.epoch, u(-60.0, 2.0), bool(random.integers(2))
    calls: list[tuple[str, Callable[[Any], object]]] = [
        ("run", lambda s: s.run(int(t))),
        ("run", lambda s: s.run(int(t))),
        ("interrupt", lambda s: s.interrupt(int(t))),
        ("interrupt", lambda s: s.interrupt(int(t))),
        ("fire", lambda s: s.fire()),
        ("settle", lambda s: s.settle()),
        ("settle", lambda s: s.settle()),
        ("command", lambda s: s.set_profile("travel", start, abs(speed) + 0.1, 0.5, distance)),
        ("command", lambda s: s.set_profile("rope", start, speed, 0.2, None)),
        ("command", lambda s: s.watch("far", value, rising)),
        ("command", lambda s: s.watch("low", value, rising)),
        ("command", lambda s: s.unwatch("far")),
        ("command", lambda s: s.unhook("tag")),
        ("command", lambda s: s.hook("tag", L0=45.0)),
    ]
    return calls[int(random.integers(len(calls)))]


def told(call: Callable[[Any], object], s: Any) -> str:
    try:
        call(s)
    except KernelError as error:
        return str(error)
    return ""


def finished(s: Any) -> tuple[Any, ...]:
    """To the end in the proper order, and all that can be seen."""
    if s.order.phase in ("paused", "stopped"):
        s.settle()
    while True:
        s.run(END)
        if not (s.event and s.next_ns < END):
            break
        s.fire()
        s.settle()
    s.interrupt(END)
    s.settle()
    return [(t, row.tobytes()) for t, row in s.rows], s.log, s.notes


@pytest.mark.parametrize("face", [Simulation, Islands])
@pytest.mark.parametrize("seed", range(25))
@pytest.mark.large(beyond=16)
def test_kernel_functions_called_in_random_order_are_refused_or_act_at_their_time(face: type, seed: int) -> None:
    random = np.random.default_rng(seed)
    s, kept = build(face), list[tuple[str, int, Callable[[Any], object], str]]()
    for _ in range(CALLS):
        name, call = a_call(random, s)
        settles, epoch = name in ("run", "interrupt") and s.order.phase == "paused", s.epoch
        refused = told(call, s)
        if settles and (s.order.phase != "paused" or s.epoch > epoch):  # on its way, even if it was refused
            kept.append(("settle", epoch, lambda s: s.settle(), ""))
        if name != "run" and (not refused or (name == "command" and s.order.phase == "stopped")):
            kept.append((name, s.epoch, call, refused))
    ordered = build(face)
    for name, t, call, refused in kept:
        if name in ("fire", "interrupt") and ordered.order.phase not in ("paused", "fired", "stopped"):
            ordered.run(t)
        assert (told(call, ordered), ordered.epoch) == (refused, t)
    assert finished(s) == finished(ordered)


def driven(subscribed: frozenset[str] = frozenset()) -> Simulation:
    return started(yard(), subscribed=subscribed)


SETTLE = "an event or a command has stopped the simulation; call settle() first"
STOP = "the run has advanced since then; call interrupt(t_ns) or fire() before, and settle() after it"


def test_interrupting_a_simulation_before_its_present_time_is_refused() -> None:
    s = driven()
    s.run(3 * SECOND)
    with pytest.raises(KernelError, match=r"^time 1000000000 ns is before the present time, 2\d{9} ns$"):
        s.interrupt(SECOND)


def test_an_interrupt_within_an_integration_step_gives_the_state_at_that_instant() -> None:
    s, straight = driven(), driven()
    s.run(SECOND)
    assert s.next_ns > SECOND + 1
    s.interrupt(SECOND + 1)
    hand_over(straight, SECOND + 1)
    assert s.state.tobytes() == straight.state.tobytes()


def test_a_simulation_refuses_to_advance_past_an_event_that_the_caller_has_not_handled() -> None:
    s = driven(frozenset({"rope"}))
    with pytest.raises(KernelError) as e:
        s.interrupt(SECOND)
    t = s.next_ns
    assert str(e.value) == (
        f"time 1000000000 ns: an event of 'rope' at {t} ns comes before; call fire() and settle() first"
    )
    assert t * 1e-9 == pytest.approx(np.sqrt(2.0 * 0.2 / 9.80665), rel=EXACT)
    assert [x.what for x in s.fire()] == ["taut"], "nothing is lost by the refusal"


COMMANDS: dict[str, Callable[[Simulation], object]] = {
    "set_profile": lambda s: s.set_profile("travel", s.epoch, 1.0, 1.0, None),
    "set_follow": lambda s: s.set_follow("travel", "", (0.0, 0.0, 0.0)),
    "set_value": lambda s: s.references.set_value("travel", s.epoch, 1.0),
    "watch": lambda s: s.watch("far", 1.0, True),
    "unwatch": lambda s: s.unwatch("far"),
    "unhook": lambda s: s.unhook("tag"),
}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_is_refused_while_the_simulation_has_not_been_interrupted(name: str) -> None:
    s = driven()
    s.run(SECOND)
    before = s.P.tobytes()
    with pytest.raises(KernelError) as e:
        COMMANDS[name](s)
    assert str(e.value) == f"{name} at {s.epoch * 1e-9:.9g} s: {STOP}"
    assert s.P.tobytes() == before
    s.interrupt(SECOND)
    COMMANDS[name](s)
    for what, call in (("run", s.run), ("interrupt", s.interrupt)):
        with pytest.raises(KernelError) as e:
            call(2 * SECOND)
        assert str(e.value) == f"{what} at 1 s: {SETTLE}"
    s.settle()
    s.run(2 * SECOND)


def test_calling_settle_without_an_earlier_stop_of_the_simulation_is_refused() -> None:
    s = driven()
    s.run(SECOND)
    with pytest.raises(KernelError, match=r"^settle at 0\.\d+ s: the run has advanced since then; call interrupt"):
        s.settle()


def test_calling_settle_twice_has_the_effect_of_calling_it_once() -> None:
    s, once = driven(), driven()
    for x, times in ((s, 2), (once, 1)):
        hand_over(x, SECOND)
        for _ in range(times):
            x.settle()
        hand_over(x, 2 * SECOND)
    assert s.state.tobytes() == once.state.tobytes()


def test_starting_a_simulation_again_during_its_run_is_refused() -> None:
    s = driven()
    s.run(SECOND)
    with pytest.raises(KernelError, match="the simulation has already advanced; create another one"):
        s.start()


def test_a_speed_profile_cannot_begin_in_the_past_or_before_a_running_move() -> None:
    s = driven()
    s.set_profile("travel", 0, 0.5, 1.0, None)
    s.settle()
    hand_over(s, SECOND)
    with pytest.raises(KernelError) as e:
        s.set_profile("travel", SECOND // 2, 1.0, 1.0, 1.0)
    assert str(e.value) == "'travel' at 0.5 s: the simulation has reached 1 s; start the profile there or later"
    with pytest.raises(KernelError) as e:
        s.set_profile("travel", 2 * SECOND, 1.0, 1.0, 1.0)
    assert str(e.value) == (
        "'travel' at 2 s: the simulation has reached 1 s; it moves until then; start the profile there"
    )


@pytest.mark.parametrize("other", [hung(60.1), replace(yard(), gravity=1.62), slider(mass=MASS)])
def test_a_snapshot_of_one_scene_is_refused_by_a_simulation_of_another_scene(other: System) -> None:
    s = driven()
    with pytest.raises(KernelError, match="the snapshot was not taken from this scene with these options"):
        s.restore(started(other).snapshot())
    with pytest.raises(KernelError, match="the snapshot was not taken from this scene with these options"):
        s.restore(started(yard(), tolerance=1e-6).snapshot())
