"""A speed profile changes its acceleration at 1/3 s, no whole nanosecond; a law switches 10 ms later.

Whether anybody hears of that event, and however the grants were cut: commands stand at exactly their nanosecond, and
later events have the same tags.  A load and a weight fall freely beside the trolley, so all instants are known.
"""

from math import ceil
from random import Random

import msgspec
import numpy as np
import pytest
from heavylift.coordinator.participants import KernelConfig, KernelNode, RowFrames
from heavylift.kernel.description import Body, Drive, Joint, Line, Point, Rope, Stop, System, Threshold
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.devs import Event, Tag, encode, succ
from heavylift.nodes.models.parts import messages as m
from small_scenes import SECOND, G, X, started

BREAK = 333_333_334  # [ns] 1/3 s, rounded up
LATER = 1 / 3 + 0.010  # [s] when the law switches
AT_ONCE = 1 / 3 + 0.4e-9  # the same, in the nanosecond to which the break is rounded up
EVENT = ceil(LATER * 1e9)
END = 2 * SECOND
SPEED, RAMP = 0.1, 0.3  # 1/3 s of ramp


def scene(law: str, event_s: float = LATER) -> System:
    """A trolley on a servo, a load above a slack rope or a stop, and a weight that falls for ever."""
    bodies = (Body("trolley", 2.0e4), Body("load", 1.0e3), Body("weight", 1.0e3))
    joints = (
        Joint("rail", "prismatic", "world", "trolley", axis=X),
        Joint("guide", "prismatic", "trolley", "load"),
        Joint("shaft", "prismatic", "world", "weight"),
    )
    depth = G * event_s**2 / 2  # of the fall until then
    rope = Rope("law", (Line(Point("trolley", (0.0, 0.0, 1.0)), Point("load")),), 2.0e6, 1.0 + depth, 1.0e3)
    stop = Stop("law", "guide", -depth, 10.0, 2.0e6, 1.0e3)
    return System(
        bodies,
        joints,
        drives=(Drive("travel", "rail", "servo", 1.0e6, 2.0e5),),
        ropes=(rope,) if law == "rope" else (),
        stops=(stop,) if law == "stop" else (),
        thresholds=(Threshold("deep", "height", point=Point("weight")), Threshold("far", "joint", of="rail")),
        gravity=G,
    )


LAWS, HEARD = ("rope", "stop"), ((), ("law",))
WHAT = {"rope": "taut", "stop": "closed"}


def stand(law: str, heard: tuple[str, ...], t_ns: int, granted: int) -> Simulation:
    """At a command at t_ns; the kernel was granted time up to `granted` before."""
    s = started(scene(law), subscribed=frozenset(heard))
    s.references.set_profile("travel", 0, SPEED, RAMP, None)
    s.settle()
    s.run(granted)
    while s.event and s.next_ns < t_ns:
        s.fire()
        s.settle()
        s.run(granted)
    assert s.next_ns >= t_ns
    if s.event and s.next_ns == t_ns:  # both at once: the law switches first
        s.fire()
    else:
        s.interrupt(t_ns)
    s.settle()
    return s


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("heard", HEARD, ids=["not subscribed", "subscribed"])
@pytest.mark.parametrize("t_ns", [BREAK - 1, BREAK, BREAK + 1, EVENT - 1, EVENT, EVENT + 1, EVENT + 5_000_000])
def test_a_kernel_command_takes_effect_at_the_time_at_which_it_is_given(law, heard, t_ns):
    s = stand(law, heard, t_ns, t_ns)
    assert (s.epoch, s["t"]) == (t_ns, 0.0)
    row = s.row()
    assert row.q[2] == pytest.approx(-G * (t_ns * 1e-9) ** 2 / 2, rel=1e-12)
    assert row.v[2] == pytest.approx(-G * t_ns * 1e-9, rel=1e-12)
    assert s.references.own("travel", t_ns)[1] == pytest.approx(min(SPEED, RAMP * t_ns * 1e-9), rel=1e-12)
    fired = [(t, e.name, e.what) for t, e in s.log]
    assert fired == ([(EVENT, "law", WHAT[law])] if t_ns >= EVENT else [])
    less = stand(law, heard, t_ns, t_ns - 1)
    assert less.state.tobytes() == s.state.tobytes()
    assert [t for t, _ in less.rows] == [t for t, _ in s.rows]
    assert less.log == s.log


def command(t_ns: int, k: int, value: m.KernelInput) -> Event:
    return Event(t_ns, k, "boss", "kernel", 0, type(value).__name__, encode(value))


def orders(second: int) -> list[Event]:
    """A ramp of 1/3 s; at `second` another one; two thresholds, the second true already."""
    return [
        command(0, 1, m.SetProfile("travel", 0, SPEED, RAMP)),
        command(0, 2, m.Watch("deep", -G / 2, False)),  # after a second of fall
        command(second, 0, m.SetProfile("travel", second, 2 * SPEED, RAMP)),
        command(SECOND + SECOND // 2, 0, m.Watch("far", 0.0, True)),
    ]


def played(
    law: str, heard: tuple[str, ...], untils: list[Tag], event_s: float = LATER, second: int = BREAK
) -> tuple[list, bytes, list]:
    """What the kernel said, its sample rows and their times, under grants that end at `untils`."""
    batches: list[bytes] = []
    subscriptions = {name: ["boss"] for name in ("deep", "far", *heard)}
    config = KernelConfig([scene(law, event_s)], G, 1e-8, 10_000_000, subscriptions)
    node = KernelNode(config, RowFrames(batches.append))
    node.start()
    text, inputs = [], orders(second)
    for until in untils:
        while True:
            due = node.next_time
            first = inputs[0].tag if inputs else Tag(END + 1)
            tag = min(due, first)
            if tag >= until:
                break
            bag = [d for d in inputs if d.tag == tag]
            inputs = inputs[len(bag) :]
            if tag == due:
                offer = node.outputs()
                assert offer == node.outputs()
                text += [(e.tag, e.value.name, e.value.what, e.payload) for e in offer]
            ahead = inputs[0].tag if inputs else until
            node.advance(tag, bag, min(until, ahead))
    node.finish(Tag(END))
    numbers, times, rows = zip(*(msgspec.msgpack.decode(batch) for batch in batches), strict=True)
    assert [sum(map(len, times[:i])) for i in range(len(times))] == list(numbers)
    return text, b"".join(rows), [t for some in times for t in some]


def cut(seed: int) -> list[Tag]:
    """Ends of grants: anywhere, some microsteps on, and around all that happens."""
    random = Random(seed)
    ends = [Tag(random.randrange(END), random.choice([0, 0, 1, 5, 2**31])) for _ in range(150)]
    for t_ns in (BREAK, EVENT, 2 * BREAK, SECOND):
        ends += [Tag(t_ns + random.randint(-3, 3), random.randrange(3)) for _ in range(10)]
    return [*sorted(ends), Tag(END)]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("heard", HEARD, ids=["not subscribed", "subscribed"])
@pytest.mark.parametrize("event_s", [LATER, AT_ONCE], ids=["10 ms later", "at once"])
@pytest.mark.parametrize("second", [BREAK, SECOND // 2], ids=["command at the break", "command later"])
@pytest.mark.large(beyond=4)
def test_events_and_samples_do_not_depend_on_how_time_grants_are_split(law, heard, event_s, second):
    whole = played(law, heard, [Tag(END)], event_s, second)
    for seed in range(6):
        assert played(law, heard, cut(seed), event_s, second) == whole


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("second", [BREAK, SECOND // 2], ids=["command at the break", "command later"])
def test_an_event_at_a_corner_of_a_speed_profile_occurs_in_the_first_microstep(law, second):
    text, _, _ = played(law, ("law",), [Tag(END)], AT_ONCE, second)
    assert text[0][:2] == (Tag(BREAK), "law")


@pytest.mark.parametrize("law", LAWS)
def test_events_of_force_laws_and_thresholds_have_the_times_and_microsteps_of_closed_forms(law):
    text, _, times = played(law, ("law",), [Tag(END)])
    tags = [(tag, name, what) for tag, name, what, _ in text]
    assert tags[0] == (Tag(EVENT), "law", WHAT[law])
    (deep,) = (tag for tag, name, _ in tags if name == "deep")
    assert deep.k == 0
    assert abs(deep.t - SECOND) <= 1
    at = SECOND + SECOND // 2
    assert [tag for tag, name, _ in tags if name == "far"] == [succ(Tag(at))]
    assert {BREAK, EVENT, at} <= set(times)


@pytest.mark.parametrize("law", LAWS)
def test_subscribing_to_the_events_of_a_force_law_changes_no_other_event_and_no_sample(law):
    unheard, rows, times = played(law, (), [Tag(END)])
    text, same, instants = played(law, ("law",), [Tag(END)])
    assert unheard == [event for event in text if event[1] != "law"]
    assert np.array_equal(np.frombuffer(rows), np.frombuffer(same))
    assert times == instants
