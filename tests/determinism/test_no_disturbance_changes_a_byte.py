"""Hash seeds, processes, order of start, late messages, loaded cores, shorter grants: one digest.

Here any two levels of any two disturbances meet at least once; `tests/full` runs all combinations.
"""

from __future__ import annotations

from itertools import combinations, product

import pytest
from disturbances import LEVELS, Case, digests, pairwise

MODEL = "random_models:build(9) 60"


def test_the_test_cases_for_determinism_cover_all_pairs_of_execution_conditions() -> None:
    cases = pairwise(MODEL)
    for a, b in combinations(LEVELS, 2):
        assert {(getattr(c, a), getattr(c, b)) for c in cases} == set(product(LEVELS[a], LEVELS[b]))
    assert len(cases) <= 16


@pytest.mark.large
def test_process_placement_message_delays_and_hash_seeds_do_not_change_the_digest_of_random_models() -> None:
    assert len(set(digests(pairwise(MODEL)).values())) == 1


@pytest.mark.parametrize("what", ["scene lift end=25s", "scene damper end=6s models.damper.delay=70ms"])
def test_placement_of_processes_and_message_delays_and_hash_seeds_do_not_change_the_digest_of_a_scene(
    what: str,
) -> None:
    cases = [
        Case(what),
        Case(what, start=3, delay=3, cut=2),
        Case(what, hash_seed=1, processes=2, start=1, delay=1, cut=1),
    ]
    assert len(set(digests(cases).values())) == 1


@pytest.mark.parametrize(
    ("kind", "first", "second"),
    [
        ("hashing", {}, {"hash_seed": 1}),
        ("sharing", {}, {"processes": 2}),
        ("sharing", {}, {"delay": 1}),
        ("sharing", {"processes": 2}, {"processes": 2, "start": 1}),  # other nodes share a process
    ],
)
@pytest.mark.large(beyond=1)
def test_the_determinism_check_detects_a_model_that_depends_on_placement_or_hash_seed(
    kind: str, first: dict[str, int], second: dict[str, int]
) -> None:
    what = f"sloppy:group({kind!r}) 200"
    one, other = Case(what, **first), Case(what, **second)
    found = digests([one]) | digests([other])
    assert found[one] != found[other]


def test_the_determinism_check_accepts_a_model_that_is_deterministic() -> None:
    what = "sloppy:group('careful') 200"
    cases = [Case(what), Case(what, hash_seed=1, processes=2, start=1, delay=1, cut=1)]
    assert len(set(digests(cases).values())) == 1
