"""Several models in one node: one simulator, one bag for what comes from inside and outside, the log of the flat run.

Each mutant breaks one rule of the sharing; random models under random placements must tell it from the truth.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import pytest
from clockwork import Clockwork
from heavylift.coordinator.protocol import (
    Coordinator,
    Coupling,
    Node,
    NodeState,
    RunEnd,
    core as core_module,
    distance,
    together,
)
from heavylift.kernel import HeavyliftError
from heavylift.nodes.devs import FOREVER, NEVER, Atomic, Model, Simulator, Tag
from heavylift.nodes.devs.execution import Wire, flatten, transitions
from in_memory import run_in_memory
from mutants import changed
from random_models import Run, build, build_ring, distributed, flat, told as results

MODELS = range(24)
MANY = range(150)  # at most, for a mutant; most are reported by the first few
Patch = pytest.MonkeyPatch

truth = cache(lambda seed: flat(seed, build=_build(seed)))
apart = cache(lambda seed: distributed(seed, 1, build=_build(seed)))


def _build(seed: int) -> Callable[[int], Any]:
    return build_ring if seed % 4 else build


def shared(seed: int) -> Run:
    """A random placement, grants cut or tight or neither."""
    return distributed(seed, seed, cut=seed % 2 > 0, tight=seed % 5 < 2, build=_build(seed), together=seed)


def test_any_distribution_of_models_over_processes_gives_the_log_and_events_of_the_flat_simulator() -> None:
    inside = 0
    for seed in MODELS:
        run = shared(seed)
        assert run.logs == truth(seed), seed
        assert run.events == apart(seed).events, seed
        assert run.results == results(seed, build=_build(seed)), seed
        inside += len(run.events)
    assert inside > 1_000


def test_the_port_that_ends_a_run_acts_at_the_same_time_in_all_placements_of_nodes() -> None:
    finished = 0
    for seed in MODELS:
        finish = [*_build(seed)(seed).children][seed % 2], "uv"[seed % 2]
        alone, run = (distributed(seed, 5, finish=finish, build=_build(seed), together=x) for x in (None, seed))
        assert run == alone, seed
        finished += alone.outcome is RunEnd.FINISHED
    assert 0 < finished < len(MODELS)


def told(seed: int) -> bool:
    try:
        run = shared(seed)
    except HeavyliftError:
        return True
    return run.logs != truth(seed) or run.events != apart(seed).events


def what_comes_from_outside_stands_last_in_a_bag(patch: Patch) -> None:
    patch.setattr(flatten, "Model", lambda name: Model(f"zz{name}"))


def what_others_hear_counts_as_inner(patch: Patch) -> None:
    changed(patch, flatten, "_wired", lambda original, *wires: (original(*wires)[0], set()))


def what_is_said_inside_is_not_noted(patch: Patch) -> None:
    patch.setattr(Simulator, "among", lambda simulator: [])


def an_event_is_heard_once_for_each_coupling(patch: Patch) -> None:
    def hears(core: Coordinator, source: str, port: str, node: NodeState) -> None:
        if source not in node.models:
            core._receivers.setdefault((source, port), []).append(node)

    patch.setattr(Coordinator, "_receives", hears)


def events_leave_though_something_is_said_inside_before(patch: Patch) -> None:
    def begin(original: Callable[..., None], core: Coordinator) -> None:
        original(core)
        for node in core._by_rank:
            node.inner = frozenset()
            core._note(node)

    changed(patch, Coordinator, "_begin", begin)


def no_way_leads_from_model_to_model_within_a_node(patch: Patch) -> None:
    def between(original: Callable[..., Any], nodes: Any, couplings: list[Coupling], *more: Any) -> Any:
        crossing = [c for c in couplings if not any({c.source, c.target} <= {*models} for models in nodes)]
        return original(nodes, crossing, *more)

    changed(patch, core_module, "distances", between)


def only_the_first_model_of_a_node_hears(patch: Patch) -> None:
    def nearest(original: Callable[..., Any], begin: dict[int, Any], *more: Any) -> Any:
        heard = begin and all(delay == distance.ZERO for delay in begin.values())
        return original({min(begin): distance.ZERO} if heard else begin, *more)

    changed(patch, distance, "_nearest", nearest)


def a_node_is_quiet_for_ever_if_its_next_tag_is(patch: Patch) -> None:
    patch.setattr(transitions.Border, "quiet", lambda border, tag: Tag(2**63 - 1))


def inner_ports_are_on_no_way(patch: Patch) -> None:
    def begin(original: Callable[..., None], border: transitions.Border, roots: Any, atomics: list[Atomic]) -> None:
        original(border, roots, atomics)
        inner = [exit for m in atomics for port in transitions.outs(m) for exit, _ in port.inner]
        border.lookahead |= {f"{port.owner.name}.{port.name}": NEVER for port in inner}

    changed(patch, transitions.Border, "__init__", begin)


def one_coupling_brings_what_others_say(patch: Patch) -> None:
    def wired(original: Callable[..., Any], tops: dict[str, Model], wires: list[Wire], ahead: Any) -> Any:
        first = {w[:2]: w for w in reversed(wires) if w[2] in tops}
        return original(tops, [w for w in wires if w[0] in tops or first.get(w[:2]) is w], ahead)

    changed(patch, flatten, "_wired", wired)


def a_node_works_ahead_beyond_its_window(patch: Patch) -> None:
    def advance(original: Callable[..., None], simulator: Simulator, tag: Tag, bag: Any = (), until: Any = 0) -> None:
        original(simulator, tag, bag, FOREVER if until and simulator.models[1:] else until or Tag(-1))

    changed(patch, Simulator, "advance", advance)


MUTANTS = [
    what_comes_from_outside_stands_last_in_a_bag,
    what_others_hear_counts_as_inner,
    what_is_said_inside_is_not_noted,
    an_event_is_heard_once_for_each_coupling,
    events_leave_though_something_is_said_inside_before,
    only_the_first_model_of_a_node_hears,
    a_node_is_quiet_for_ever_if_its_next_tag_is,
    one_coupling_brings_what_others_say,
    a_node_works_ahead_beyond_its_window,
]


@pytest.mark.parametrize("mutant", MUTANTS)
def test_comparison_with_the_flat_simulator_detects_errors_planted_in_nodes_with_several_models(
    mutant: Callable[[Patch], None], monkeypatch: Patch
) -> None:
    mutant(monkeypatch)
    found = (seed for seed in MANY if told(seed))
    assert [next(found, None) is not None for _ in range(2)] == [True] * 2


def relayed() -> list[tuple[Tag, int]]:
    """What the last of four models hears: the first says it, the two between share a node and have no delay."""
    first, *between, last = Clockwork("a", [5]), Clockwork("b", delay=0), Clockwork("c", delay=0), Clockwork("d", [9])
    wires = [("a", "out", "b", "into"), ("b", "out", "c", "into"), ("c", "out", "d", "into")]
    nodes = {"a": [first], "b": between, "d": [last]}
    core = Coordinator(nodes, wires, models={name: [m.name for m in models] for name, models in nodes.items()})
    run_in_memory(core, [Node(name, Simulator(models, wires=wires)) for name, models in nodes.items()])
    return last.heard


@pytest.mark.parametrize("mutant", [no_way_leads_from_model_to_model_within_a_node, inner_ports_are_on_no_way])
def test_a_node_does_not_advance_past_events_between_its_own_models(
    mutant: Callable[[Patch], None], monkeypatch: Patch
) -> None:
    assert relayed() == [(Tag(5, 2), 100)]
    mutant(monkeypatch)
    with pytest.raises(
        HeavyliftError,
        match=r"^d at \(0.000000009 s, 0\): message from c.out is late: due at \(0.000000005 s, 2\)",
    ):
        relayed()


def test_an_error_message_about_very_many_models_names_only_some_of_them() -> None:
    assert together(["a"]) == "a"
    assert together(["a", "b", "c", "d"]) == "a, b, c, d"
    assert together([f"m{i}" for i in range(1024)]) == "m0, m1, m2 and 1021 others"
