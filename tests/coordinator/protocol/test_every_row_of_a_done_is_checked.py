"""Whatever is wrong with a DONE is refused by the row that it breaks; without that row it would pass.

Random runs go on undisturbed; beside each honest DONE stand others, each spoiled in one way.
"""

from collections import Counter
from collections.abc import Callable
from typing import Any

import pytest
from heavylift.coordinator.protocol import (
    EVENTS,
    WHOLE,
    Coordinator,
    GrantDone,
    Hello,
    NodeState,
    check_done,
    check_hello,
)
from heavylift.kernel import ProtocolError
from heavylift.nodes.devs import FOREVER, NEVER, Event, Tag, after, succ
from msgspec.structs import replace
from mutants import changed
from random_models import distributed

SEEDS = range(6)
Spoiled = Callable[[NodeState, GrantDone, Tag], GrantDone | None]


def alone(done: GrantDone, **fields: Any) -> GrantDone | None:
    """One event, changed."""
    if len(done.spoken) != 1:
        return None
    return replace(done, spoken=[replace(done.spoken[0], **fields)])


def early(node: NodeState, done: GrantDone, says: Tag) -> GrantDone | None:
    port = f"{node.name}.{done.spoken[0].port}" if len(done.spoken) == 1 else ""
    if not port or port in node.inner:
        return None
    soonest = min(says, after(node.hears, node.lookahead[port]))
    return alone(done, t=soonest.t - 1, k=0) if 0 < soonest.t < NEVER else None


def beyond(node: NodeState, done: GrantDone, says: Tag) -> GrantDone | None:
    late = max(done.reached, says)
    if late >= FOREVER or done.spoken:
        return None
    return replace(
        done, spoken=[Event(late.t + 1, 0, node.name, min(node.lookahead).partition(".")[2], 0, "Number", b"")]
    )


def offering(done: GrantDone, **fields: Any) -> GrantDone | None:
    return replace(done, **fields) if done.offer else None


ROWS: dict[str, tuple[str, Spoiled]] = {
    "is the node's own": (
        "sent an event of zz: a node sends events of its own models only",
        lambda n, d, s: alone(d, source="zz"),
    ),
    "leaves by a port that HELLO named": ("sent an event on port nix at", lambda n, d, s: alone(d, port="nix")),
    "comes in total order, numbered from 0 in each bag": (
        "sent events out of order",
        lambda n, d, s: replace(d, spoken=d.spoken[:1] * 2) if len(d.spoken) == 1 else None,
    ),
    "comes no earlier than quiet and lookahead have declared": ("that it had declared", early),
    "what is done ends with the GRANT and before what is next": (
        "a DONE reaches at most the end of its GRANT",
        lambda n, d, s: replace(d, reached=succ(d.next)) if d.next < FOREVER else None,
    ),
    "the first tag is done": (
        "a DONE must include the first tag of its GRANT",
        lambda n, d, s: replace(d, reached=n.first, last=Tag(0)) if not d.spoken and n.first > (0, 0) else None,
    ),
    "what is spoken lies in what is done": ("but has only done all before", beyond),
    "so does the last transition": ("last transition was at", lambda n, d, s: replace(d, last=d.reached)),
    "next and quiet are tags": (
        "which is not a valid tag",
        lambda n, d, s: None if d.offer else replace(d, quiet=Tag(NEVER + 7)),
    ),
    "an offer is for the next tag": (
        "an offer holds its own events at its next tag",
        lambda n, d, s: offering(d, next=succ(d.next), quiet=succ(d.next)),
    ),
    "quiet is the tag of an offer, and never earlier than the next tag": (
        "quiet must be the tag of its first possible event",
        lambda n, d, s: offering(d, quiet=succ(d.next)),
    ),
}


def verdicts(patch: pytest.MonkeyPatch, spoil: Spoiled) -> Counter[str]:
    """What is said of all spoiled DONEs of some random runs; "" of what passes."""
    found: Counter[str] = Counter()

    def done(original: Callable[..., None], core: Coordinator, name: str, honest: GrantDone) -> None:
        node = core._nodes[name]
        says = core._tags[node.rank]
        spoiled = spoil(node, honest, says)
        if spoiled is not None:
            try:
                check_done(node, spoiled, says)
                found[""] += 1
            except ProtocolError as error:
                found[str(error).removeprefix(f"{name} ")] += 1
        original(core, name, honest)

    changed(patch, Coordinator, "done", done)
    for seed in SEEDS:
        distributed(seed, 1)
    return found


@pytest.mark.parametrize("row", ROWS)
def test_each_check_of_done_messages_rejects_its_kind_of_corruption_without_the_other_checks(
    row: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    sentence, spoil = ROWS[row]
    with monkeypatch.context() as patch:
        text = verdicts(patch, spoil)
    assert all(sentence in message for message in text), text
    assert text.total() >= 3
    monkeypatch.delitem(EVENTS if row in EVENTS else WHOLE, row)  # type: ignore[arg-type]
    assert verdicts(monkeypatch, spoil)[""] > 0.5 * text.total()


def test_every_check_of_done_messages_has_a_case_in_the_tests() -> None:
    assert {*ROWS, "a lookahead is a time"} == {*EVENTS, *WHOLE}


@pytest.mark.parametrize("ahead", [-1, NEVER + 1])
def test_a_declared_lookahead_that_is_not_a_valid_time_is_refused(ahead: int, monkeypatch: pytest.MonkeyPatch) -> None:
    hello = Hello(Tag(0), [], Tag(0), {"a.out": ahead})
    with pytest.raises(
        ProtocolError, match=rf"^a declares a lookahead of {ahead} ns for port a.out, which is not between 0"
    ):
        check_hello(NodeState("a", 0, "a"), hello)
    monkeypatch.delitem(WHOLE, "a lookahead is a time")
    check_hello(NodeState("a", 0, "a"), hello)
