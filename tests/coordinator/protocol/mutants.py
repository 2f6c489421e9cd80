"""The protocol with one rule broken: each tempting simplification that we know, as a patch of our own code.

A mutant that no random model tells from the truth would mean that the models prove nothing about that rule.
"""

from bisect import insort
from collections.abc import Callable, Sequence
from typing import Any

import msgspec
import pytest
from heavylift.coordinator.protocol import (
    Coordinator,
    Delay,
    Grant,
    GrantDone,
    Hello,
    Matrix,
    Node,
    NodeState,
    core as core_module,
    distance,
    distance as known_module,
    node as node_module,
)
from heavylift.nodes.devs import FOREVER, Event, Tag, after, succ

Patch = pytest.MonkeyPatch
Ways = list[tuple[int, int, int]]
MUTANTS: dict[str, Callable[[Patch], None]] = {}


def mutant(break_it: Callable[[Patch], None]) -> Callable[[Patch], None]:
    MUTANTS[break_it.__name__] = break_it
    return break_it


def changed(patch: Patch, owner: Any, name: str, change: Callable[..., Any]) -> None:
    """`change(original, *arguments)` in place of a function."""
    original = getattr(owner, name)
    patch.setattr(owner, name, lambda *arguments, **named: change(original, *arguments, **named))


@mutant
def a_scheduled_output_has_lookahead(patch: Patch) -> None:
    def note(original: Callable[..., None], core: Coordinator, node: NodeState) -> None:
        original(core, node)
        if not node.committed and 0 < node.least < FOREVER.t:
            says = after(node.next, node.least)
            core._tags[node.rank], core._tags[2 * core._n + node.rank] = says, min(says, after(node.hears, node.least))

    changed(patch, Coordinator, "_note", note)


@mutant
def pending_inputs_cause_nothing(patch: Patch) -> None:
    def note(original: Callable[..., None], core: Coordinator, node: NodeState) -> None:
        original(core, node)
        core._tags[core._n + node.rank], core._tags[2 * core._n + node.rank] = FOREVER, core._tags[node.rank]

    changed(patch, Coordinator, "_note", note)


@mutant
def who_runs_says_nothing(patch: Patch) -> None:
    def grant(original: Callable[..., Grant], core: Coordinator, node: NodeState, window: Tag) -> Grant:
        for at in (node.rank, core._n + node.rank, 2 * core._n + node.rank):
            core._tags[at] = FOREVER
        return original(core, node, window)

    changed(patch, Coordinator, "_grant", grant)


@mutant
def who_is_silent_next_stays_silent(patch: Patch) -> None:
    def take(original: Callable[..., None], core: Coordinator, node: NodeState, text: GrantDone) -> None:
        original(core, node, text)
        if not text.offer:
            node.quiet = FOREVER
            core._note(node)

    changed(patch, Coordinator, "_take", take)


@mutant
def granted_without_a_commit(patch: Patch) -> None:
    patch.setattr(NodeState, "uncommitted", property(lambda node: False))


@mutant
def an_earlier_input_does_not_void_an_offer(patch: Patch) -> None:
    patch.setattr(NodeState, "uncommitted", property(lambda node: bool(node.offer) and not node.committed))


@mutant
def an_equal_input_voids_an_offer(patch: Patch) -> None:
    missing = property(lambda node: bool(node.offer) and not node.committed and node.next < node.hears)
    patch.setattr(NodeState, "uncommitted", missing)


@mutant
def committed_a_nanosecond_too_soon(patch: Patch) -> None:
    """A microstep too soon would be right: who is next at (t, k + 1) has moved at (t, k), so its window was above."""

    def window(original: Callable[..., Tag | None], core: Coordinator, node: NodeState, need: Tag) -> Tag | None:
        return original(core, node, Tag(need.t - 1) if node.uncommitted else need)

    changed(patch, Coordinator, "_window", window)


@mutant
def committed_only_below_the_window(patch: Patch) -> None:
    def window(original: Callable[..., Tag | None], core: Coordinator, node: NodeState, need: Tag) -> Tag | None:
        return original(core, node, succ(need) if node.uncommitted else need)

    changed(patch, Coordinator, "_window", window)


@mutant
def granted_at_the_window(patch: Patch) -> None:
    def window(original: Callable[..., Tag | None], core: Coordinator, node: NodeState, need: Tag) -> Tag | None:
        if node.uncommitted:
            return original(core, node, need)
        found = original(core, node, node.first)
        return None if found is None else max(found, need)

    changed(patch, Coordinator, "_window", window)


@mutant
def a_commit_lasts(patch: Patch) -> None:
    def done(original: Callable[..., None], core: Coordinator, name: str, done: GrantDone) -> None:
        committed = core._nodes[name].committed
        original(core, name, done)
        core._nodes[name].committed = committed

    changed(patch, Coordinator, "done", done)


@mutant
def what_was_granted_counts_as_done(patch: Patch) -> None:
    changed(
        patch,
        Coordinator,
        "done",
        lambda original, core, name, done: (forget(core._nodes[name]), original(core, name, done)),
    )


def forget(node: NodeState) -> None:
    node.drop(node.until)


@mutant
def inputs_are_sent_with_every_grant(patch: Patch) -> None:
    patch.setattr(NodeState, "send", lambda node, until: [d for d in node._pending if d.tag < until])


@mutant
def inputs_that_were_not_reached_are_forgotten(patch: Patch) -> None:
    changed(patch, Node, "_run", lambda original, node, grant: (node._kept.clear(), original(node, grant))[1])


@mutant
def new_inputs_come_behind_those_that_are_kept(patch: Patch) -> None:
    patch.setattr(node_module, "heappush", list.append)
    patch.setattr(node_module, "heappop", lambda kept: kept.pop(0))


@mutant
def who_is_sent_an_input_hears_nothing_more(patch: Patch) -> None:
    def send(original: Callable[..., list[Event]], node: NodeState, until: Tag) -> list[Event]:
        sent = original(node, until)
        node.drop(until)
        return sent

    changed(patch, NodeState, "send", send)


@mutant
def a_grant_that_ends_early_counts_as_done(patch: Patch) -> None:
    def run(original: Callable[..., GrantDone], node: Node, grant: Grant) -> GrantDone:
        done = original(node, grant)
        return msgspec.structs.replace(done, reached=min(grant.until, done.next))

    changed(patch, Node, "_run", run)


@mutant
def who_is_ahead_waits_even_if_nobody_is_behind(patch: Patch) -> None:
    patch.setattr(Coordinator, "_least", Tag(-1))


@mutant
def no_stop_after_speaking(patch: Patch) -> None:
    patch.setattr(node_module, "plus", lambda tag, delay: FOREVER)


@mutant
def the_echo_comes_a_microstep_late(patch: Patch) -> None:
    changed(patch, node_module, "plus", lambda original, tag, delay: succ(original(tag, delay)))


@mutant
def no_echo_in_grants(patch: Patch) -> None:
    def grant(original: Callable[..., Grant], core: Coordinator, node: NodeState, window: Tag) -> Grant:
        node.echo = None
        return original(core, node, window)

    changed(patch, Coordinator, "_grant", grant)


@mutant
def bags_in_the_order_of_arrival(patch: Patch) -> None:
    patch.setattr(node_module, "heappush", lambda kept, event: insort(kept, event, key=lambda d: d.tag))
    patch.setattr(node_module, "heappop", lambda kept: kept.pop(0))
    patch.setattr(known_module, "insort", lambda inputs, event: insort(inputs, event, key=lambda d: d.tag))


@mutant
def the_longest_lookahead_of_several_ports(patch: Patch) -> None:
    def longer(row: dict[int, Delay], to: int, delay: Delay) -> None:
        row[to] = max(delay, row.get(to, delay))

    patch.setattr(distance, "_shorten", longer)


@mutant
def only_neighbours_are_waited_for(patch: Patch) -> None:
    def distances(original: Callable[..., Ways], i: int, D: Matrix, R: Matrix, least: Sequence[int]) -> Ways:
        near = [{i: row[i]} if row.get(i) == distance.ZERO else {} for row in D]
        return original(i, near, R, least)

    changed(patch, core_module, "ways", distances)


@mutant
def a_node_between_costs_two_microsteps(patch: Patch) -> None:
    patch.setattr(distance, "reaction", lambda lookahead: (lookahead, 0) if lookahead else (0, 2))


@mutant
def microsteps_go_on_after_a_lookahead(patch: Patch) -> None:
    patch.setattr(distance, "chain", lambda first, second: (first[0] + second[0], first[1] + second[1] + 1))


@mutant
def all_ports_are_as_slow_as_the_slowest(patch: Patch) -> None:
    def hello(original: Callable[..., None], core: Coordinator, name: str, hello: Hello) -> None:
        slowest = max((ahead for ahead in hello.lookahead.values() if ahead < FOREVER.t), default=0)
        original(core, name, msgspec.structs.replace(hello, lookahead=dict.fromkeys(hello.lookahead, slowest)))

    changed(patch, Coordinator, "hello", hello)


@mutant
def who_was_held_back_is_forgotten(patch: Patch) -> None:
    def moved(original: Callable[..., None], core: Coordinator, node: NodeState) -> None:
        node.holds = {}
        original(core, node)

    changed(patch, Coordinator, "_moved", moved)


@mutant
def who_gets_an_input_is_not_looked_at(patch: Patch) -> None:
    def hold(original: Callable[..., None], core: Coordinator, event: Event) -> None:
        look = dict(core._look)
        original(core, event)
        core._look = look

    changed(patch, Coordinator, "_hold", hold)


class Deaf(list[Tag]):
    """Tags of which the last third, o_j, looks like the first, says_j."""

    def __getitem__(self, at: Any) -> Any:
        return super().__getitem__(slice(0, len(self) // 3) if isinstance(at, slice) else at)


@mutant
def events_leave_before_what_inputs_cause(patch: Patch) -> None:
    def ready(original: Callable[..., Any], core: Coordinator) -> Any:
        core._tags = Deaf(core._tags)
        return original(core)

    changed(patch, Coordinator, "ready", ready)
