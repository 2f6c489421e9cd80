"""Random models in lockstep, where no event becomes bytes: transitions, events, end and results are those of the time
protocol, whose messages are frames."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from random import Random

import pytest
from heavylift.coordinator.participants import Lockstep, lockstep
from heavylift.kernel import HeavyliftError, ModelError, ProtocolError
from heavylift.nodes.devs import Coupled, Event, Tag
from without_bytes import without_bytes

sys.path.append(str(Path(__file__).parents[1] / "protocol"))

import random_models
from random_models import END, Ahead, Logs, Run, build, build_deep, build_ring, distributed, flat, parts
from test_events_come_from_outside import WIRE, Script, by_script, spoken

MODELS = range(40)
FEW = range(20)
SHARE = 0.3  # of the rounds before which somebody outside speaks


def stepped(
    seed: int,
    build: Callable[[int], Coupled] = build,
    ahead: bool = False,
    finish: tuple[str, str] | None = None,
    together: int | None = None,
) -> Run:
    logs, events = Logs(), list[Event]()
    simulators, couplings = parts(seed, logs, build, [(*finish, "", "")] if finish else [], together)
    models = {name: [m.name for m in simulator.models] for name, simulator in simulators.items()}
    nodes = {name: Ahead(simulator) if ahead else simulator for name, simulator in simulators.items()}
    with without_bytes():
        run = Lockstep(nodes, couplings, Tag(END), finish, events.append, models=models)
        outcome = run.advance()
        results = {path: x for s in simulators.values() for path, x in s.results(run.end).items()}
    assert outcome is not None
    return Run(logs, events, outcome, run.end, results)


def _like(seed: int) -> dict[str, object]:
    """A kind of model and its placement, of each in turn."""
    return {"build": (build, build_ring, build_deep)[seed % 3], "together": seed if seed % 2 else None}


def _same(run: Run, other: Run) -> bool:
    return run.events == other.events and (*run[:1], *run[2:]) == (*other[:1], *other[2:])


@pytest.mark.parametrize("block", range(20))
@pytest.mark.large(beyond=1)
def test_random_models_give_the_same_run_in_lockstep_and_through_the_protocol(block: int) -> None:
    crossing = 0
    for seed in range(len(MODELS) * block, len(MODELS) * (block + 1)):
        how = _like(seed)
        run = stepped(seed, ahead=seed % 4 > 1, **how)  # type: ignore[arg-type]
        assert run.logs == flat(seed, build=how["build"]), seed  # type: ignore[arg-type]
        assert _same(run, distributed(seed, 1, **how)), seed  # type: ignore[arg-type]
        crossing += len(run.events)
    assert crossing > 1_000


def test_the_port_that_ends_a_run_acts_at_the_same_time_in_lockstep_and_through_the_protocol() -> None:
    finished = 0
    for seed in FEW:
        how = {**_like(seed), "finish": ("g0", "uv"[seed % 2])}
        run = stepped(seed, **how)  # type: ignore[arg-type]
        assert _same(run, distributed(seed, 1, **how)), seed  # type: ignore[arg-type]
        finished += run.end < Tag(END)
    assert finished > 5


def spoken_to(seed: int, ahead: bool = False) -> tuple[Logs, Script]:
    """A run that is advanced piece by piece, into which somebody outside speaks at or after the safe time."""
    r, logs, script = Random(seed), Logs(), Script()
    simulators, couplings = parts(seed, logs, wires=[WIRE])
    nodes = {name: Ahead(simulator) if ahead else simulator for name, simulator in simulators.items()}
    run = Lockstep(nodes, couplings, Tag(END), outside=[WIRE])
    horizon, over = Tag(0), None
    while over is None:
        t = run.safe.t + (run.safe.k > 0) + r.choice([0, 0, 0, 1, 3])
        t = max(t, script[-1][0] + 1) if script else t
        if r.random() < SHARE and t < END:
            script.append((t, r.randrange(1000)))
            run.inject(*spoken(script[-1:]))
        horizon = max(horizon, Tag(run.first.t + r.choice([0, 0, 1, 4]), run.first.k + r.randrange(1, 3)))
        over = run.advance(horizon)
    return logs, script


def test_a_lockstep_run_with_events_from_outside_equals_a_run_in_the_flat_simulator_that_receives_them() -> None:
    words = 0
    for seed in FEW:
        logs, script = spoken_to(seed, ahead=seed % 2 > 0)
        assert logs == by_script(seed, script), seed
        words += len(script)
    assert words > 100


def test_an_event_from_outside_that_comes_too_early_or_has_no_receiver_is_refused() -> None:
    simulators, couplings = parts(3, Logs(), wires=[WIRE])
    run = Lockstep(simulators, couplings, Tag(END), outside=[WIRE])
    run.advance(Tag(30))
    with pytest.raises(ProtocolError, match="has already been computed"):
        run.inject(*spoken([(1, 5)]))
    with pytest.raises(ProtocolError, match="no node receives outside events"):
        run.inject(stepped(3).events[0])


@pytest.mark.parametrize("microsteps", [3, 5, 8])
def test_a_run_in_which_time_stands_still_ends_with_an_error_in_lockstep_and_through_the_protocol(
    microsteps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Which loop is named may differ: by the protocol one node may be far ahead of another."""
    monkeypatch.setattr(random_models, "MICROSTEPS", microsteps)
    ended = [0, 0]
    for seed in FEW:
        both = []
        for run in (stepped, distributed):
            with suppress(ModelError):
                both.append(run(seed).events)  # type: ignore[operator]
        assert both == [] or both[0] == both[1], seed
        ended[bool(both)] += 1
    assert min(ended) > 1


def test_the_test_detects_a_lockstep_run_that_ignores_possible_answers_of_other_nodes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(lockstep, "succ", lambda tag: Tag(tag.t + 5))
    wrong = 0
    for seed in MODELS:
        try:
            wrong += stepped(seed, ahead=True).logs != flat(seed)
        except HeavyliftError:
            wrong += 1
    assert wrong > 5
