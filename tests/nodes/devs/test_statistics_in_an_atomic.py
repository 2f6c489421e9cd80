"""Tallies and time averages against hand calculation and Python's statistics; independent streams of random numbers."""

from math import isnan
from statistics import fmean, stdev

import pytest
from heavylift.kernel import ModelError
from heavylift.nodes.devs import Tag, Tally, TimeWeighted, stream


def test_a_tally_counts_each_observation_once() -> None:
    tally, draws = Tally(), [stream(1, "a").gauss(1e6, 3.0) for _ in range(1)] + [1e6 + x / 7 for x in range(100)]
    for x in draws:
        tally.add(x)
    assert (tally.count, tally.least, tally.most) == (101, min(draws), max(draws))
    assert tally.mean == pytest.approx(fmean(draws), rel=1e-14)
    assert tally.deviation == pytest.approx(stdev(draws), rel=1e-9)


def test_a_tally_of_observations_with_fewer_than_two_has_no_variance() -> None:
    tally = Tally()
    assert (isnan(tally.mean), isnan(tally.deviation)) == (True, True)
    tally.add(3)
    assert (tally.mean, isnan(tally.deviation)) == (3.0, True)


def test_a_statistic_over_time_weights_each_value_by_its_duration() -> None:
    length = TimeWeighted()
    length.set(2, Tag(10))
    length.set(5, Tag(10, 1))  # 2 held for no time
    length.set(1, Tag(14))
    assert length.mean(Tag(20)) == (0 * 10 + 5 * 4 + 1 * 6) / 20
    assert (length.least, length.most, length.value) == (0, 5, 1)
    assert length.mean(Tag(40)) == (5 * 4 + 1 * 26) / 40
    assert isnan(TimeWeighted(3.0, since_ns=7).mean(Tag(7)))
    assert TimeWeighted(3.0, since_ns=7).mean(Tag(9)) == 3.0


def test_an_invalid_observation_added_to_a_statistic_is_refused() -> None:
    for take in (Tally().add, lambda x: TimeWeighted().set(x, Tag(1)), TimeWeighted):
        with pytest.raises(ModelError, match=r"^nan is not a valid observation: give a finite number$"):
            take(float("nan"))
    late = TimeWeighted(1.0, since_ns=5)
    with pytest.raises(ModelError, match=r"^a time average cannot go back in time from \(0.000000005 s, 0\) to "):
        late.set(2.0, Tag(3))


def test_random_number_streams_with_different_seeds_or_names_differ() -> None:
    first = [stream(seed, name).random() for seed in (1, 2, 11) for name in ("a", "b", "1/a")]
    assert len({*first}) == 9
    assert first[0] == stream(1, "a").random() == 0.6881244510893788
