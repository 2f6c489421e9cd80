"""Random models, cut into 2 to 5 nodes, DONEs in random order: every log equals the flat one, line for line.

Each mutant breaks one rule of the protocol; if one of them passed here, the test would prove nothing about that rule.
"""

from functools import cache

import pytest
from heavylift.coordinator.protocol import Coordinator, RunEnd
from heavylift.kernel import HeavyliftError, ProtocolError
from heavylift.nodes.devs import Tag
from mutants import MUTANTS, changed
from one_wave import wave
from random_models import END, Logs, distributed, flat

MODELS = range(100)
FEW = range(40)
MANY = range(300)  # at most, for a mutant; most are reported by the first few
ENOUGH = 2  # models that must tell a mutant from the truth
PATIENCE = 20_000  # decisions after which a mutant counts as stuck; no model needs a tenth of them

truth = cache(flat)


def test_distributed_runs_log_as_the_flat_simulator_for_any_message_order_and_grant_size_and_lookahead() -> None:
    transitions = confluent = crossing = 0
    for seed in MODELS:
        runs = [
            distributed(seed, 1),
            distributed(seed, 2, cut=True, tight=True),
            distributed(seed, 3, cut=True, ahead=True),
        ]
        assert [run.logs == truth(seed) for run in runs] == [True] * 3, seed
        assert runs[0].events == runs[1].events == runs[2].events, seed
        assert runs[0].events == sorted(runs[0].events), seed
        transitions += sum(map(len, truth(seed).values()))
        confluent += sum(line.kind == "confluent" for log in truth(seed).values() for line in log)
        crossing += len(runs[0].events)
    assert transitions > 25_000
    assert confluent > 1_500
    assert crossing > 3_000


def test_no_node_advances_beyond_the_time_of_the_message_that_ends_the_run() -> None:
    finished = 0
    for seed in FEW:
        whole = distributed(seed)
        text = [event.t for event in whole.events if (event.source, event.port) == ("g0", "u")]
        run = distributed(seed, 5, finish=("g0", "u"))
        if not text:
            assert run.outcome is not RunEnd.FINISHED
            continue
        finished += 1
        assert (run.outcome, run.end) == (RunEnd.FINISHED, Tag(text[0] + 1))
        assert run.logs == flat(seed, text[0] + 1)
        assert run.events == [event for event in whole.events if event.t <= text[0]]
    assert finished > 10


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """No mutant may hang the test."""
    decisions = dict[Coordinator, int]()

    def done(original: object, core: Coordinator, *text: object) -> None:
        decisions[core] = decisions.get(core, 0) + 1
        if decisions[core] > PATIENCE:
            raise ProtocolError("this does not come to an end")
        original(core, *text)  # type: ignore[operator]

    changed(monkeypatch, Coordinator, "done", done)
    return monkeypatch


def told(seed: int) -> bool:
    """Whether this model tells the protocol from the truth, by its logs, the order of events, or an error."""
    try:
        runs = [distributed(seed, 1), distributed(seed, 2, cut=True, tight=True)]
    except HeavyliftError:
        return True
    return any(run.logs != truth(seed) or run.events != sorted(run.events) for run in runs)


@pytest.mark.parametrize("name", MUTANTS)
@pytest.mark.large(beyond=8)
def test_comparison_with_the_flat_simulator_detects_errors_planted_in_the_time_protocol(
    name: str, impatient: pytest.MonkeyPatch
) -> None:
    MUTANTS[name](impatient)
    found = (seed for seed in MANY if told(seed))
    assert [next(found, None) is not None for _ in range(ENOUGH)] == [True] * ENOUGH


def test_comparison_with_the_flat_simulator_detects_a_protocol_that_delays_outputs_by_one_microstep() -> None:
    assert sum(wave(seed) != truth(seed) for seed in FEW) > 10


def test_a_node_advances_up_to_the_end_of_its_grant_but_not_to_it() -> None:
    logs: Logs = distributed(3).logs
    assert all(line.tag.t < END for log in logs.values() for line in log)
