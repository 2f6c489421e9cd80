"""Path lookahead between nodes, by hand."""

from collections.abc import Mapping

import pytest
from heavylift.coordinator.protocol import Coupling, Delay, chain, distances, plus
from heavylift.kernel import ProtocolError
from heavylift.nodes.devs import FOREVER, NEVER, Tag

Rows = list[list[Delay | None]]


def link(source: str, target: str, port: str = "o") -> Coupling:
    return Coupling(source, port, target, "i")


def said_and_heard(couplings: list[Coupling], lookaheads: Mapping[str, int]) -> tuple[Rows, Rows]:
    """D and R as full tables, for nodes whose ports have one lookahead."""
    names = list(lookaheads)
    tables = distances(
        [[name] for name in names], couplings, {f"{name}.o": lookaheads[name] for name in names}, heard=names
    )
    D, R = ([[row.get(i) for i in range(len(names))] for row in table] for table in tables)
    return D, R


def test_the_delay_along_a_chain_of_nodes_is_the_sum_of_their_lookaheads() -> None:
    couplings = [link("a", "b"), link("b", "c"), link("c", "d")]
    D, R = said_and_heard(couplings, {"a": 7, "b": 10, "c": 5, "d": 0})
    assert D == [
        [None, (0, 0), (10, 0), (15, 0)],
        [None, None, (0, 0), (5, 0)],
        [None, None, None, (0, 0)],
        [None, None, None, None],
    ]
    assert R == [
        [None, (7, 0), (17, 0), (22, 0)],
        [None, None, (10, 0), (15, 0)],
        [None, None, None, (5, 0)],
        [None, None, None, None],
    ]


def test_a_node_with_zero_lookahead_adds_one_microstep_to_the_delay_along_a_path() -> None:
    couplings = [link("a", "b"), link("b", "c"), link("c", "d")]
    D, R = said_and_heard(couplings, {"a": 0, "b": 0, "c": 0, "d": 0})
    assert (D[0], R[0]) == ([None, (0, 0), (0, 1), (0, 2)], [None, (0, 1), (0, 2), (0, 3)])
    assert said_and_heard(couplings, {"a": 0, "b": 5, "c": 0, "d": 0})[0][0][3] == (5, 1)
    assert said_and_heard(couplings, {"a": 0, "b": 0, "c": 5, "d": 0})[0][0][3] == (5, 0)


def test_the_delay_between_two_nodes_is_that_of_the_path_with_the_shortest_delay() -> None:
    couplings = [link("a", "b"), link("b", "a"), link("b", "c"), link("c", "a")]
    D, _ = said_and_heard(couplings, {"a": 1, "b": 20, "c": 3})
    assert D == [[(20, 0), (0, 0), (20, 0)], [(0, 0), (1, 0), (0, 0)], [(0, 0), (1, 0), (21, 0)]]


def test_the_delay_from_an_output_port_of_a_model_uses_the_lookahead_of_that_port() -> None:
    couplings = [link("a", "b", "fast"), link("a", "c", "slow"), link("c", "b")]
    D, R = distances("abc", couplings, {"a.fast": 0, "a.slow": 50, "c.o": 4}, heard="a")
    assert D == [{1: (0, 0), 2: (0, 0)}, {}, {1: (0, 0)}]
    assert R == [{1: (0, 1), 2: (50, 0)}, {}, {1: (4, 0)}]


def test_a_model_with_infinite_lookahead_cannot_delay_any_other_model() -> None:
    assert distances("ab", [link("a", "b")], {"a.o": NEVER}, heard="a") == ([{}, {}], [{}, {}])


def test_a_message_that_ends_the_run_takes_effect_on_every_node_after_one_nanosecond() -> None:
    nodes, lookaheads = [["commander"], ["west"]], {"commander.finished": 7, "west.o": 0}
    D, R = distances(nodes, [], lookaheads, ("commander", "finished"), heard=["commander"])
    assert (D, R) == ([{0: (1, 0), 1: (1, 0)}, {}], [{1: (8, 0)}, {}])


def test_adding_a_delay_in_microsteps_keeps_the_time_and_adding_one_in_ns_resets_the_microsteps() -> None:
    assert plus(Tag(5, 3), (0, 2)) == Tag(5, 5)
    assert plus(Tag(5, 3), (4, 2)) == Tag(9, 2)
    assert plus(Tag(5, 3), None) == plus(FOREVER, (0, 1)) == plus(Tag(5), (NEVER, 0)) == FOREVER
    assert chain((0, 3), (2, 1)) == (2, 1)
    assert chain((2, 1), (0, 3)) == (2, 4)


def test_invalid_couplings_between_nodes_are_reported_by_name() -> None:
    with pytest.raises(ProtocolError, match=r"^coupling a\.o -> x\.i: there is no node x$"):
        distances(["a"], [link("a", "x")], {})
    with pytest.raises(
        ProtocolError, match=r"^coupling a\.o -> a\.i: both ports belong to one node; couple them inside it$"
    ):
        distances(["a"], [link("a", "a")], {})
