"""A run is checked in parts of time, however long it is: what is found is that of the whole."""

from __future__ import annotations

import random
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.coordinator.verdict import (
    SHARP,
    Coarse,
    Collector,
    Moving,
    Stretches,
    clearances as looking,
    history as kept,
    history_of,
    intervals,
    verdict_of,
    whole,
)
from heavylift.coordinator.verdict.moving import moving
from heavylift.nodes.limits import SignalColumns, uses_of
from heavylift.nodes.plan import RatedLimit, Shapes
from heavylift.nodes.scene import load
from heavylift.recordings import Recording, SampleLayout
from heavylift.recordings.format import SampleChannel, digest as spool

ROPE = "crane.H1"
LIMITS = (
    RatedLimit(subject="hook", quantity="hook load", unit="kg", value=1.0, elements=(ROPE,)),
    RatedLimit(subject="rope", quantity="rope peak", unit="N", value=1e5, elements=(ROPE,)),
    RatedLimit(subject="rope", quantity="rope factor", unit="", value=5.0, least=True, elements=(ROPE,)),
    RatedLimit(subject="drum", quantity="rope length", unit="m", between=(10.0, 60.0), elements=(ROPE,)),
    RatedLimit(
        subject="trolley", quantity="trolley load", unit="kg", chart=((0.0, 2e5), (50.0, 1e5)), elements=(ROPE,)
    ),
)


def drawn(seed: int) -> SignalColumns:
    """A rope over 200 instants, some of them twice, on levels so that the worst comes more than once; gaps among it."""
    draw, n = random.Random(seed), 200
    t = np.cumsum([draw.choice((0.0, 0.1, 0.5)) for _ in range(n)])
    level = [draw.choice((0.0, 3e5, 9e5, 9e5 * (1 + draw.uniform(-2e-6, 2e-6)), np.nan)) for _ in range(n)]
    poses = {name: (np.array([[draw.gauss(0, 9) for _ in range(3)] for _ in t]), np.zeros((n, 3, 3)) + np.eye(3))
             for name in ("crane.upper", "crane.lower", "loader-1.upper")}  # fmt: skip
    lengths = np.array([draw.choice((9.0, 30.0, 61.0, 61.0)) for _ in range(n)])
    when = draw.choice([-1.0, *t.tolist(), float(t[-1]) + 1.0, draw.uniform(0, 40)])
    peaks = {ROPE: (draw.choice((1.0, 9.1e5)), when)}
    stages = [(0.0, "up"), (float(t[n // 2]), "down")]
    return SignalColumns(t, {ROPE: np.array(level)}, poses, {ROPE: lengths}, stages=stages, peaks=peaks, dynamic=True)


def some(x: SignalColumns, k: slice) -> SignalColumns:
    poses = {name: (p[k], R[k]) for name, (p, R) in x.poses.items()}
    columns = [{name: v[k] for name, v in y.items()} for y in (x.tensions, x.lengths)]
    return replace(x, t=x.t[k], tensions=columns[0], lengths=columns[1], poses=poses, known={})


def test_utilisations_do_not_depend_on_whether_the_run_is_checked_as_a_whole_or_in_parts() -> None:
    plan = load("lift").plan
    plan = msgspec.structs.replace(plan, limits=LIMITS)
    message = 0
    for seed in range(12):
        whole_, size = drawn(seed), random.Random(seed).choice((1, 3, 50, 199))
        parts = [some(whole_, slice(max(0, i - 1), i + size)) for i in range(0, len(whole_.t), size)]
        expected = uses_of(plan, [whole_])
        assert uses_of(plan, parts) == expected, seed
        message += sum(use.value is not None for use in expected)
    assert message == 12 * len(LIMITS)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("long") / "lift.mcap"
    run(load("lift", ["samples=4 Hz", "end=45 s"]), path, in_process=True)
    rec = Recording(path)
    del rec.result["verdict"]
    return rec


def test_the_verdict_does_not_depend_on_whether_a_run_is_checked_as_a_whole_or_in_parts(
    recorded: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = verdict_of(recorded)
    for module in (looking, kept):
        monkeypatch.setattr(module, "BLOCK", 50)
    found = verdict_of(recorded)
    assert found is not None
    assert expected is not None
    assert (found.line, found.findings, found.tables[0]) == (expected.line, expected.findings, expected.tables[0])
    assert len(found.clearances) == len(expected.clearances) == 10
    for a, b in zip(found.clearances, expected.clearances, strict=True):
        assert abs(a.distance - b.distance) <= SHARP


def test_clearances_of_a_long_run_are_searched_in_parts(recorded: Recording, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = verdict_of(recorded)
    monkeypatch.setattr(intervals, "PIECE", 37)
    assert verdict_of(recorded) == expected


def test_bounds_of_clearances_do_not_depend_on_whether_a_run_is_checked_as_a_whole_or_in_parts(
    recorded: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each stretch is in one part and as wide apart there; what steps may stray is the same."""
    plan, history = load("lift").plan, history_of(recorded)
    n, size = len(history.t), 64
    monkeypatch.setattr(looking, "BLOCK", size)
    thin = [(moving(Shapes(plan), part), between) for part, between in looking.thinned(history)]
    monkeypatch.setattr(looking, "BLOCK", n)
    ((shapes, (first, last)),) = [(moving(Shapes(plan), part), between) for part, between in looking.thinned(history)]
    assert sum(end - begin for _, (begin, end) in thin) == last - first
    block = next(i for i, s in enumerate(shapes) if s.shape.thing == "block")
    beam = next(i for i, s in enumerate(shapes) if s.shape.thing == "loader-1")

    def bounded(shapes: list[Moving], between: tuple[int, int]) -> Stretches:
        return whole(Coarse(shapes, np.zeros((len(shapes[0].t), 2)), between), [(block, beam)])

    expected = bounded(shapes, (first, last))
    strays = np.concatenate([part[block].stray[begin:end] for part, (begin, end) in thin])
    found = [bounded(part, between) for part, between in thin]
    assert np.array_equal(strays, shapes[block].stray)
    moved, least = (np.concatenate([getattr(x, name) for x in found]) for name in ("moved", "least"))
    assert np.allclose(moved + least, expected.moved + expected.least, rtol=1e-9)


def test_samples_kept_for_the_verdict_of_a_long_run_are_stored_in_a_file(monkeypatch: pytest.MonkeyPatch) -> None:
    """Batches that come twice are taken once, and each part is what was given."""
    monkeypatch.setattr(spool, "IN_MEMORY", 1000)
    pose = SampleChannel("pose/block", [*"xyzabcd"], "m", 1, 8)
    layout = SampleLayout([SampleChannel("rope/tension", ["r"], "N", 0, 1), pose])
    rows = np.random.default_rng(1).normal(size=(300, 8))
    past = Collector(layout)
    for first in range(0, 300, 20):
        begin = max(0, first - 10)
        past.samples(begin, list(range(begin, first + 20)), rows[begin : first + 20])
    assert past._rows._file._rolled  # type: ignore[attr-defined]
    for first, end in ((0, 300), (7, 20), (250, 999)):
        part = past.part(first, end)
        assert np.array_equal(part.tensions["r"], rows[first:end, 0])
        assert np.array_equal(part.poses["block"], rows[first:end, 1:])
        assert np.array_equal(part.t, np.arange(300)[first:end] * 1e-9)
    past.samples(300, [300], rows[:1])
    assert np.array_equal(past.part(299, 301).tensions["r"], rows[[299, 0], 0])
