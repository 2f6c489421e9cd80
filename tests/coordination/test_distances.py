"""Path lookahead between nodes, by hand."""

import pytest
from heavylift.coordinator.distance import Coupling, chain, distances, plus
from heavylift.kernel.errors import ProtocolError
from heavylift.nodes.devs import FOREVER, NEVER, Tag


def link(source: str, target: str) -> Coupling:
    return Coupling(source, "o", target, "i")


def test_a_chain_sums_the_lookaheads_of_the_nodes_between() -> None:
    couplings = [link("a", "b"), link("b", "c"), link("c", "d")]
    assert distances(list("abcd"), couplings, {"a": 7, "b": 10, "c": 5, "d": 0}) == [
        [None, (0, 0), (10, 0), (15, 0)],
        [None, None, (0, 0), (5, 0)],
        [None, None, None, (0, 0)],
        [None, None, None, None],
    ]


def test_a_node_between_without_lookahead_costs_a_microstep() -> None:
    couplings = [link("a", "b"), link("b", "c"), link("c", "d")]
    row = distances(list("abcd"), couplings, {"a": 0, "b": 0, "c": 0, "d": 0})[0]
    assert row == [None, (0, 0), (0, 1), (0, 2)]
    assert distances(list("abcd"), couplings, {"a": 0, "b": 5, "c": 0, "d": 0})[0][3] == (5, 1)
    assert distances(list("abcd"), couplings, {"a": 0, "b": 0, "c": 5, "d": 0})[0][3] == (5, 0)


def test_the_shortest_path_counts_and_a_cycle_goes_through_others() -> None:
    couplings = [link("a", "b"), link("b", "a"), link("b", "c"), link("c", "a")]
    D = distances(list("abc"), couplings, {"a": 1, "b": 20, "c": 3})
    assert D == [[(20, 0), (0, 0), (20, 0)], [(0, 0), (1, 0), (0, 0)], [(0, 0), (1, 0), (21, 0)]]


def test_the_end_reaches_everybody_after_one_nanosecond() -> None:
    D = distances(["commander", "west"], [], {"commander": 0, "west": 0}, finish="commander")
    assert D == [[(1, 0), (1, 0)], [None, None]]


def test_delays_and_tags() -> None:
    assert plus(Tag(5, 3), (0, 2)) == Tag(5, 5)
    assert plus(Tag(5, 3), (4, 2)) == Tag(9, 2)
    assert plus(Tag(5, 3), None) == plus(FOREVER, (0, 1)) == plus(Tag(5), (NEVER, 0)) == FOREVER
    assert chain((0, 3), (2, 1)) == (2, 1)
    assert chain((2, 1), (0, 3)) == (2, 4)
    assert chain((2, 1), None) is None


def test_wrong_couplings_are_named() -> None:
    with pytest.raises(ProtocolError, match=r"^coupling a\.o -> x\.i: there is no node x$"):
        distances(["a"], [link("a", "x")], {"a": 0})
    with pytest.raises(ProtocolError, match=r"^coupling a\.o -> a\.i: couple it inside the node$"):
        distances(["a"], [link("a", "a")], {"a": 0})
