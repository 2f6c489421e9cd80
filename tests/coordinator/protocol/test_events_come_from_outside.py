"""An operator speaks into a random run whenever it can: the run is the one in which the words were known before.

The truth is one flat simulator that has the operator as a model with a script.
"""

from random import Random

import pytest
from heavylift.coordinator.protocol import GrantDone, Hello, Node, OpenCoordinator
from heavylift.kernel import HeavyliftError, ProtocolError
from heavylift.nodes.devs import FOREVER, Atomic, Event, Out, Simulator, Tag, encode
from in_memory import answer
from random_models import END, MICROSTEPS, Logs, Number, build, parts

OPERATOR = "operator"
WIRE = (OPERATOR, "out", "g0", "p")
MODELS = range(60)
FEW = range(30)
SHARE = 0.3  # of the rounds before which the operator speaks

Script = list[tuple[int, int]]  # (t [ns], what is said)


class Reader(Atomic):
    """Says what stands in a script, when it stands there."""

    out = Out(Number)

    def __init__(self, script: Script) -> None:
        super().__init__(OPERATOR)
        self.script = script

    def start(self) -> None:
        self.n = 0
        self.wait()

    def wait(self) -> None:
        if self.n < len(self.script):
            self.hold_in(self.script[self.n][0] - self.now.t)
        else:
            self.passivate()

    def output(self) -> None:
        self.out.send(Number(self.script[self.n][1]))

    def internal(self) -> None:
        self.n += 1
        self.wait()


def by_script(seed: int, script: Script) -> Logs:
    logs: Logs = {}
    root = build(seed)
    _, port, target, into = WIRE
    reader = root.add(Reader(script))
    root.connect(reader.ports[port], root.children[target].ports[into])
    simulator = Simulator(root, log=lambda line: logs.setdefault(line.path, []).append(line), microsteps=MICROSTEPS)
    simulator.start()
    simulator.run(END)
    logs.pop(reader.path, None)
    return logs


def spoken(script: Script) -> list[Event]:
    return [Event(t, 0, OPERATOR, "out", 0, "Number", encode(Number(word))) for t, word in script]


def live(seed: int, order: int, known: Script | None = None, slices: bool = True) -> tuple[Logs, Script, list[Event]]:
    """A run in nodes; without a known script the operator speaks at or after the safe time when chance says so."""
    r, logs, events = Random(order), Logs(), list[Event]()
    script: Script = []
    simulators, couplings = parts(seed, logs, wires=[WIRE])
    core = OpenCoordinator(simulators, couplings, Tag(END), None, events.append, [WIRE])
    nodes = {name: Node(name, simulator) for name, simulator in simulators.items()}
    for event in spoken(known or []):
        core.inject(event)
    for name in r.sample(sorted(nodes), len(nodes)):
        core.hello(name, nodes[name].hello())  # type: ignore[arg-type]
    answers: list[tuple[str, GrantDone]] = []
    horizon = Tag(0)
    while True:
        if known is None and r.random() < SHARE:
            t = core.safe.t + (core.safe.k > 0) + r.choice([0, 0, 0, 1, 3])
            t = max(t, script[-1][0] + 1) if script else t
            if t < END:
                script.append((t, r.randrange(1000)))
                core.inject(*spoken(script[-1:]))
        if slices:
            horizon = max(
                horizon, Tag(core.first.t, core.first.k + r.randrange(1, 3)) if r.random() < 0.7 else Tag(END)
            )
        for name, grant in core.ready(horizon) if slices else core.ready():
            answers.append((name, answer(nodes[name], grant, core)))
        if core.over is not None:
            return logs, script, events
        if answers:
            name, done = answers.pop(r.randrange(len(answers)))
            core.done(name, done)


@pytest.mark.parametrize("slices", [True, False], ids=["with horizons", "as fast as it goes"])
@pytest.mark.large(beyond=1)
def test_a_run_with_events_from_outside_equals_a_run_in_the_flat_simulator_that_receives_them(slices: bool) -> None:
    text = late = 0
    for seed in MODELS:
        logs, script, events = live(seed, seed, slices=slices)
        assert logs == by_script(seed, script), seed
        again, _, events_again = live(seed, seed + 1, script, slices)
        assert again == logs, seed
        assert events_again == events, seed
        assert events == sorted(events, key=lambda event: event.order), seed
        text += len(script)
        late += sum(t > 0 for t, _ in script)
    assert late > text / 2 > 300


def test_the_protocol_test_detects_a_coordinator_that_accepts_outside_events_without_regard_to_lookahead(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(OpenCoordinator, "safe", property(lambda core: core.floor))
    wrong = 0
    for seed in FEW:
        try:
            logs, script, _ = live(seed, seed)
            wrong += logs != by_script(seed, script)
        except HeavyliftError:
            wrong += 1
    assert wrong > 5


def test_the_earliest_time_for_events_from_outside_accounts_for_committed_messages_not_yet_granted() -> None:
    """j runs below x's next tag, 6; through m, which takes 3, it reaches i at 8, and i has its offer there."""
    wires = [
        ("j", "out", "m", "in"),
        ("m", "out", "i", "in"),
        ("j", "out", "x", "in"),
        ("x", "out", "j", "in"),
        ("g0", "out", "i", "in"),
    ]
    core = OpenCoordinator(["g0", "i", "j", "m", "x"], wires, Tag(END), outside=[WIRE])
    for name, next_, lookahead in (("g0", FOREVER, 0), ("m", FOREVER, 3), ("j", Tag(5), 0)):
        core.hello(name, Hello(next_, [], next_, {f"{name}.out": lookahead}))
    for name, next_ in (("x", Tag(6)), ("i", Tag(8))):
        core.hello(name, Hello(next_, [Event(next_.t, 0, name, "out", 0, "Number", b"")], next_))
    assert [(name, grant.until) for name, grant in core.ready()] == [("j", Tag(6))]
    assert core.floor == Tag(5, 1)
    assert core.safe == Tag(8)  # g0 would reach i at once


def test_events_from_outside_for_past_times_or_unknown_nodes_are_refused() -> None:
    core = OpenCoordinator(["g0"], [], Tag(END), outside=[WIRE])
    core.floor = Tag(5, 1)
    with pytest.raises(
        ProtocolError, match=r"operator.out at \(0.000000005 s, 0\): everything up to \(0.000000005 s, 1\)"
    ):
        core.inject(*spoken([(5, 1)]))
    core.inject(*spoken([(6, 1)]))
    with pytest.raises(ProtocolError, match=r"no node receives outside events on g0\.out"):
        core.inject(Event(9, 0, "g0", "out", 0, "Number", b""))
