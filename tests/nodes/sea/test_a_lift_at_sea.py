"""A lift by a crane on a barge in an irregular sea: one digest wherever it runs; one seed is never green."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from random import Random
from types import SimpleNamespace

import numpy as np
import pytest
from heavylift.coordinator.record import play
from heavylift.coordinator.run import Beginning, run
from heavylift.coordinator.run.resume import resume
from heavylift.coordinator.sweeps import SeedRun, SeedsVerdict, replicated, verdict_of_seeds
from heavylift.kernel import SceneError
from heavylift.nodes.limits import RatedLimit, SignalColumns, Use, checks_of, error_of, uses_of
from heavylift.nodes.plan import Plan
from heavylift.nodes.scene import LoadedScene, load, parse
from heavylift.nodes.scenes import bundled
from heavylift.nodes.sea import extreme

SEA = """\
seed: %d
accuracy: 5%%
end: 60 s
waves: {heading: 150 deg, ramp: 20 s, seas: {wind: {Hs: 0.8 m, Tp: 7 s, spreading: 4, components: 50},
                                             swell: {Hs: 0.3 m, Tp: 12 s, heading: 90 deg, components: 20}}}
vessels:
  barge:
    mass: 13716 t
    size: [110 m, 32 m, 8 m]
    draught: 4 m
    com: [0 m, 0 m, 1 m]
    motion: forces
    floating: {hydrodynamics: barge-110, mooring: {surge: 400 kN/m, sway: 400 kN/m, yaw: 400 MN m/rad}}

"""


@cache
def lift(seed: int = 1) -> LoadedScene:
    """The bundled lift from a barge, in an irregular sea."""
    text = bundled()["floating"].read_text()
    return parse(text[: text.index("waves:")] + SEA % seed + text[text.index("practice:") :])


@pytest.fixture(scope="module")
def digest() -> str:
    return play(lift().plan).digest


def test_a_run_with_another_seed_of_the_sea_differs(digest: str) -> None:
    assert play(lift(2).plan).digest != digest


def test_the_digest_of_a_lift_at_sea_is_equal_in_one_process_and_in_several(digest: str, tmp_path: Path) -> None:
    for name, in_process in (("one", True), ("many", False)):
        assert run(lift(), tmp_path / f"{name}.mcap", in_process=in_process).digest == digest


def test_an_interrupted_run_at_sea_continues_from_its_recording(digest: str, tmp_path: Path) -> None:
    """It repeats the part that was recorded, with the states of the water, and continues."""
    whole = tmp_path / "whole.mcap"
    run(lift(), whole, in_process=True)
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole.read_bytes()[: whole.stat().st_size * 3 // 4])
    assert resume(cut, Beginning.of(cut), in_process=True).digest == digest


def test_a_single_realisation_of_a_random_sea_gives_an_amber_check() -> None:
    (row,) = [x for x in checks_of(lift().plan, [], [], None, []) if x.quantity == "sea state"]
    assert (row.state, row.why) == ("amber", "not checked")
    assert row.sentence.startswith(
        "an irregular sea of 70 components at random frequencies, without a repeat time: one"
    )
    assert not [x for x in checks_of(load("floating").plan, [], [], None, []) if x.quantity == "sea state"]


@pytest.fixture(scope="module")
def over_seeds() -> SeedsVerdict:
    with ThreadPoolExecutor(1) as pool:
        return replicated(lift(), 10, executor=pool)


def test_a_verdict_over_seeds_checks_the_quantile_of_the_peaks_instead_of_the_largest_peak(
    over_seeds: SeedsVerdict,
) -> None:
    """The values are those of single runs; a bound beyond the limit leaves the check undecided."""
    largest = play(lift(over_seeds.seeds[3]).plan).judge.fine[1]
    assert [x.value for x in largest] == [x.value for x in over_seeds.runs[3].uses][: len(largest)]
    (row,) = [x for x in over_seeds.checks if x.quantity == "off-lead"]
    values = [x.value for run in over_seeds.runs for x in run.uses if x.limit.quantity == "off-lead"]
    assert row.value == pytest.approx(extreme(values, 0.9).value)
    assert row.shown.startswith("P90 ")
    assert (row.state, row.limit < extreme(values, 0.9).value + extreme(values, 0.9).above) == ("undecided", True)


@pytest.mark.parametrize("kind", ["most", "least", "between", "chart"])
@pytest.mark.parametrize("seed", range(10))
def test_in_runs_over_many_seeds_each_limit_is_checked_against_the_confidence_bound_of_a_quantile(
    seed: int, kind: str
) -> None:
    """A limit beyond the bound is green, one between quantile and bound undecided, one far on the other side red."""
    random = Random(seed)
    values = [random.gauss(100.0, 5.0) for _ in range(30)]
    found = extreme([-x for x in values] if kind == "least" else values, 0.9)
    scene = replace(lift(), answer=SimpleNamespace(figures={"use of crane signal": 0.0}))
    for way, state in ((1.1, "green"), (0.9, "undecided"), (-0.9, "undecided"), (-1.1, "red")):
        most = abs(found.value + way * found.above)
        more = {"between": (-most, most)} if kind == "between" else {"value": most, "least": kind == "least"}
        limit = RatedLimit(subject="crane", quantity="signal", unit="N", source="test", **more)
        bound = most if kind == "chart" else None
        uses = [Use(limit, x, use=x / most if bound else limit.use(x), bound=bound) for x in values]
        runs = [SeedRun({"status": "done", "simulated [s]": 60.0}, (use,)) for use in uses]
        (check,) = [x for x in verdict_of_seeds(scene, range(30), runs).checks if x.quantity == "signal"]
        assert (way, check.state) == (way, state)


@pytest.mark.parametrize("kind", ["most", "least", "between", "chart"])
def test_the_error_of_a_run_and_the_confidence_bound_of_a_quantile_are_added_for_each_kind_of_limit(kind: str) -> None:
    """A load of 100 t of 280 t, measured to 0.3 % of what is allowed: root of the sum of squares, in kilograms."""
    values = [1e5 + 10.0 * i for i in range(30)]
    found = extreme([-x for x in values] if kind == "least" else values, 0.9)
    more = {"between": (-2.8e5, 2.8e5)} if kind == "between" else {"value": 2.8e5, "least": kind == "least"}
    limit = RatedLimit(subject="crane", quantity="signal", unit="kg", source="test", **more)
    bound = 2.8e5 if kind == "chart" else None
    uses = [Use(limit, x, use=x / 2.8e5 if bound else limit.use(x), bound=bound) for x in values]
    runs = [SeedRun({"status": "done", "simulated [s]": 60.0}, (use,)) for use in uses]
    scene = replace(lift(), answer=SimpleNamespace(figures={"use of crane signal": 0.003}))
    (check,) = [x for x in verdict_of_seeds(scene, range(30), runs).checks if x.quantity == "signal"]
    (use,) = [x for x in verdict_of_seeds(scene, range(30), runs).uses]
    single = error_of(replace(use, value=check.value, use=check.use), {"use of crane signal": 0.003})
    assert 0.003 * 0.9e5 < single < 0.003 * 3.0e5 * max(1.0, check.use)
    assert check.error == pytest.approx(np.hypot(single, found.above), rel=1e-3)


def test_a_verdict_over_seeds_lists_the_quantile_of_each_limit_and_every_unfinished_lift(
    over_seeds: SeedsVerdict,
) -> None:
    (sea,) = [x for x in over_seeds.checks if x.quantity == "sea state"]
    assert sea.basis.endswith("; an irregular sea of 70 components at random frequencies, without a repeat time")
    assert (sea.state, sea.shown) == ("green", "P90")
    (cut,) = [x for x in over_seeds.checks if x.quantity == "cut"]
    assert (over_seeds.state, cut.state) == ("red", "red")
    assert cut.sentence.endswith("in 10 of 10 seeds)")


def test_replications_of_a_scene_without_random_waves_are_refused() -> None:
    with pytest.raises(SceneError, match="nothing in the scene depends on its seed"):
        replicated(load("floating"), 10)
    with pytest.raises(SceneError, match="give 10 or more"):
        replicated(lift(), 3)


@pytest.mark.parametrize(("speed", "hits"), [("0.6", True), ("6", False)])
def test_impacts_of_a_heaving_deck_on_a_lifted_block_are_counted_and_reported(speed: str, hits: bool) -> None:
    """Each time that all its supports were free and one of them presses again counts once; a fast lift has none."""
    text = bundled()["floating"].read_text()
    text = text[: text.index("  - stage: up")].replace("hoist 6 m/min until", f"hoist {speed} m/min until")
    text = text.replace("samples: 5 Hz", "samples: 5 Hz\nend: 60 s")
    run = play(parse(f"{text}  - stage: up\n    crane: hoist {speed} m/min by 0.2 m\n").plan)
    past = run.past.part(0, len(run.t))
    pressing = sum(x for name, x in past.tensions.items() if "lower" in name) > 0.0
    count = sum(1 for a, b in pairwise(pressing) if b and not a)
    found = [x for x in run.verdict.checks if x.quantity == "re-hit"]
    assert (count > 1, [f" again {count} times " in x.sentence for x in found]) == (hits, [True] if hits else [])
    assert [(x.state, x.why) for x in found] == ([("amber", "warning")] if hits else [])


def hanging(where: str) -> str:
    """The barge below an idle hook of a crane that stands somewhere; it heaves by 0.45 m per metre of amplitude."""
    text = bundled()["floating"].read_text().replace("samples: 5 Hz", "samples: 20 Hz\nend: 60 s")
    text = text.replace("limits: {", "limits: {heave: 0.6 m, ").replace("on: barge, at: [0 m, 0 m, 4 m]", where)
    for mode in ("surge", "sway", "roll", "pitch", "yaw"):
        text = "\n".join(x for x in text.splitlines() if not x.strip().startswith(f"{mode}: ["))
    return text[: text.index("actions:")] + "actions: [{wait: 50 s}]\n"


def test_the_heave_of_a_deck_below_a_hook_on_the_quay_is_checked() -> None:
    """Up and down is twice the amplitude; a crane that stands on the barge has no such limit."""
    plan = parse(hanging("at: [0 m, 0 m, 4 m]")).plan
    (use,) = [x for x in play(plan).judge.fine[1] if x.limit.quantity == "relative heave"]
    assert (use.limit.subject, use.limit.value) == ("crane.main over barge", 0.6)
    assert use.value == pytest.approx(2.0 * 0.45 * 0.75, rel=0.01)  # the hook bobs on its rope by less
    assert use.beyond
    carried = parse(hanging("on: barge, at: [0 m, 0 m, 4 m]")).plan
    assert not [x for x in carried.limits if x.quantity == "relative heave"]


@pytest.mark.parametrize("seed", range(20))
def test_the_relative_heave_does_not_depend_on_how_a_run_is_divided_into_parts(heaving: Plan, seed: int) -> None:
    """Random heave and a winch that moves now and then; the reference looks at each rest of the winch as a whole."""
    draw, n = np.random.default_rng(seed), 300
    (limit,) = (x for x in heaving.limits if x.quantity == "relative heave")
    rope, vessel = limit.elements
    (hook,) = (h for m in heaving.machines for h in m.hooks if h.rope == rope)
    z, length = np.cumsum(draw.normal(size=n)), np.cumsum(draw.random(n) < 0.02)
    turned, still = np.tile(np.eye(3), (n, 1, 1)), np.zeros((n, 3))
    poses = {hook.eye.body: (np.outer(z, [0.0, 0.0, 1.0]), turned), vessel: (still, turned)}

    def part(a: int, b: int) -> SignalColumns:
        cut = {name: (p[a:b], R[a:b]) for name, (p, R) in poses.items()}
        return SignalColumns(np.arange(n)[a:b] * 0.1, {}, cut, {rope: length[a:b] * 1.0}, dynamic=True)

    cuts = sorted({0, *draw.integers(1, n, 4).tolist()})
    parts = [part(max(0, a - 1), b) for a, b in pairwise([*cuts, n])]
    (use,) = (x for x in uses_of(heaving, parts) if x.limit == limit)
    rests = [z[length == x] for x in np.unique(length)]
    assert use.value == pytest.approx(max(float(np.ptp(x)) for x in rests), rel=1e-12)


@pytest.fixture(scope="module")
def heaving() -> Plan:
    """A crane on the quay whose hook hangs over a barge."""
    return parse(hanging("at: [0 m, 0 m, 4 m]")).plan
