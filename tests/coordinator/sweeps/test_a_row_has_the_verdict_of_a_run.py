"""A row of a sweep looks at no more than it tells; its verdict, its smallest clearance, its digest are of `run`."""

from __future__ import annotations

import pytest
from heavylift.coordinator.record import play
from heavylift.coordinator.sweeps import Task, Variant, played
from heavylift.nodes.scene import load


@pytest.mark.parametrize("limit", [0.5, 7.2, 30.0])
def test_a_single_clearance_below_its_limit_makes_a_row_of_a_study_red(limit: float) -> None:
    run = play(load("lift", ["end=30 s", f"limits.clearance={limit} m"]).plan)
    verdict, uses = run.judge.fine
    full = run.verdict
    assert (verdict.line, verdict.red, verdict.findings) == (full.line, full.red, full.findings)
    assert list(uses) == list(run.uses)
    red = [c for c in full.clearances if c.distance < limit]
    assert list(verdict.clearances) == (red or list(full.clearances[:1]))
    assert len(full.clearances) >= 10


@pytest.mark.parametrize(
    ("settings", "digests", "refused"),
    [
        ((), 1, 0),
        (("block.com=[1 m, 0 m, 0 m]",), 1, 0),  # settles on its supports before it begins
        (("cranes.crane.hook capacity=10 t",), 1, 1),  # less than the beams weigh: run where nothing is checked
        (("actions[0]={loader-1: unhook}", "actions[1]={loader-1: unhook}"), 0, 2),
        (("cranes.crane.at=1 m",), 0, 2),
    ],
)
def test_a_study_variant_has_the_same_digest_with_and_without_checks(
    settings: tuple[str, ...], digests: int, refused: int
) -> None:
    scene, variant = load("lift", ["end=1 s"]), Variant(0, settings, ())
    rows = [played(Task.of(scene, 60.0, "none", checked), variant) for checked in (True, False)]
    assert len({row["digest"] for row in rows if "digest" in row}) == digests
    assert [row["status"] for row in rows].count("refused") == refused
    assert len({row["sentence"] for row in rows if row["status"] == "refused"}) == min(refused, 1)


@pytest.mark.parametrize("name", ["jib", "hall", "lift"])
def test_a_study_row_is_green_only_if_the_errors_of_its_run_were_measured(name: str) -> None:
    scene = load(name, ["ask=[limits]", "accuracy=1 %"])
    first, second = (played(Task.of(scene, 60.0, "none", True), Variant(n, (), ())) for n in (0, 1))
    assert first["digest"] == second["digest"]
    assert ("error" in first, "error" in second) == (True, False)
    assert "error unknown" not in first["verdict"]
    assert (second["state"], " error unknown" in second["verdict"]) == ("amber", True)


def test_a_variant_has_the_same_row_whatever_ran_before_it_in_its_process() -> None:
    task = Task.of(load("lift", ["end=12 s"]), 60.0, "none", True)
    settings = ["block.mass=290 t", "rig.loaders.loader-2.sling=10.2 m", "factors.wind=12 m/s", "block.mass=310.5 t"]
    variants = [Variant(n, (setting,), ()) for n, setting in enumerate(settings, 1)]
    rows = {x.number: played(task, x) for x in variants}
    again = {x.number: played(task, x) for x in reversed(variants)}
    times = {"cpu_s", "wall_s"}
    for n, row in rows.items():
        assert {k: x for k, x in row.items() if k not in times} == {k: x for k, x in again[n].items() if k not in times}
    assert len({row["digest"] for row in rows.values()}) == len(variants)
