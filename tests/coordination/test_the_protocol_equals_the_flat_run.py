"""Random models, cut into 2 to 5 nodes, DONEs in random order: every log equals the flat one, line for line.

The mutants are the tempting simplifications; if one of them passed here, the test would prove nothing.
"""

import pytest
from heavylift.coordinator import node as node_module
from heavylift.coordinator.core import Outcome
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.devs import FOREVER, Tag
from random_models import END, distributed, flat, wave

MODELS = range(300)
FEW = range(60)


def test_log_for_log_in_any_order_with_any_cut_and_any_work_ahead() -> None:
    transitions = confluent = 0
    for seed in MODELS:
        truth = flat(seed)
        runs = [
            distributed(seed, 1),
            distributed(seed, 2, cut=True),
            distributed(seed, 3, cut=True, ahead=True),
        ]
        assert [run.logs == truth for run in runs] == [True] * 3, seed
        assert runs[0].events == runs[1].events == runs[2].events, seed
        assert runs[0].events == sorted(runs[0].events, key=lambda event: event.order), seed
        transitions += sum(map(len, truth.values()))
        confluent += sum(line.kind == "confluent" for log in truth.values() for line in log)
    assert transitions > 30_000
    assert confluent > 2_500


def test_a_finish_port_ends_the_run_with_its_time_and_no_node_passes_it() -> None:
    finished = 0
    for seed in FEW:
        whole = distributed(seed)
        said = [event.t for event in whole.events if (event.source, event.port) == ("g0", "u")]
        run = distributed(seed, 5, finish=("g0", "u"))
        if not said:
            assert run.outcome is not Outcome.FINISHED
            continue
        finished += 1
        assert (run.outcome, run.end) == (Outcome.FINISHED, Tag(said[0] + 1))
        assert run.logs == flat(seed, said[0] + 1)
        assert run.events == [event for event in whole.events if event.t <= said[0]]
    assert finished > 20


def differing(seeds: range) -> int:
    """Models that a mutant gets wrong, by their logs or by an error."""
    wrong = 0
    for seed in seeds:
        try:
            wrong += distributed(seed, 1).logs != flat(seed)
        except HeavyliftError:
            wrong += 1
    return wrong


def test_mutant_wave_outputs_at_the_next_microstep() -> None:
    assert sum(wave(seed) != flat(seed) for seed in FEW) > 20


def test_mutant_rash_no_stop_after_speaking(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(node_module, "plus", lambda tag, delay: FOREVER)
    assert differing(FEW) > 3


def test_the_bound_is_half_open() -> None:
    assert all(line.tag.t < END for log in distributed(3).logs.values() for line in log)
