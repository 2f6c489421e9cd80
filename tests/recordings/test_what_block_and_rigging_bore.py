"""Lugs, slings, supports and stages in the planner's document: each from statics."""

from __future__ import annotations

from math import degrees
from random import Random

import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.limits import RunTables, SignalColumns
from heavylift.nodes.plan import Use
from heavylift.nodes.scene import load
from heavylift.recordings import Recording, RopeLine
from heavylift.recordings.documents import Facts, block_rows, facts, tables_of
from heavylift.recordings.sheets import Table, plain
from scipy.spatial.transform import Rotation

G = 9.80665


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Facts:
    path = tmp_path_factory.mktemp("lift") / "lift.mcap"
    run(load("lift", ["end=60 s"]), path, in_process=True)
    return facts(Recording(path))


def rows(made: Table) -> list[dict[str, object]]:
    names = [column.name for column in made.columns]
    return [dict(zip(names, map(plain, row), strict=True)) for row in made.rows]


def table(found: Facts, title: str) -> list[dict[str, object]]:
    return next(rows(made) for made in tables_of(found) if made.title == title)


def test_the_reported_load_on_a_lug_is_the_force_of_its_sling(found: Facts) -> None:
    slings = {str(row["lug"]): row for row in table(found, "Slings")}
    assert {lug: row["sling"] for lug, row in slings.items()} == {
        f"{lug}{i}": f"loader-{n}.sling-{i}" for n, lug in ((1, "P"), (2, "Q"), (3, "R")) for i in (1, 2)
    }
    for row in table(found, "Loads on lugs"):
        parts = [row[f"along {axis}"] for axis in "uvw"]
        peak = found.peaks[str(slings[str(row["lug"])]["sling"])].tension / 1e3
        assert row["largest load"] == pytest.approx(peak, rel=1e-9)
        assert np.linalg.norm(parts) == pytest.approx(row["largest load"])
        assert parts[2] > 0.999 * row["largest load"], "upwards"


def test_the_support_reactions_in_the_report_sum_to_the_weight_of_the_block(found: Facts) -> None:
    supports = {row["support"]: row["largest load"] for row in table(found, "Reactions of supports")}
    weight = 300 * G
    assert supports["all together"] == pytest.approx(weight, rel=1e-3), "before the ropes are taut"
    assert supports["block.lower-1"] == pytest.approx(weight / 4, rel=1e-3)


def test_the_report_gives_the_position_of_the_block_in_each_stage(found: Facts) -> None:
    first, *_, last = table(found, "Path of the block")
    assert [first[x] for x in "xyz"] == pytest.approx([40.0, 75.0, 5.995], abs=0.01)
    assert last["z"] == pytest.approx(7.03, abs=0.02)
    assert 0.0 < last["largest tilt"] < 0.2
    assert ("centre of gravity at u, v, w", [0.0, 0.0, 0.0], "m") in block_rows(found.plan)


@pytest.mark.parametrize("seed", range(20))
def test_the_load_on_a_lug_is_reported_along_the_axes_of_a_turned_block(seed: int) -> None:
    """A block at a random attitude hangs on one sling in a random direction."""
    random, plan = Random(seed), load("lift").plan
    limit = next(x for x in plan.limits if x.quantity == "lug load" and x.subject == "P1")
    sling, tension = "loader-1.sling-1", random.uniform(1e4, 1e6)
    R = Rotation.random(random_state=seed)
    p, d = np.array([random.uniform(-9, 9) for _ in range(3)]), np.array([random.gauss(0, 1) for _ in range(3)])
    d /= np.linalg.norm(d)
    lug = next(cargo.lugs["P1"] for machine in plan.machines for cargo in machine.cargo)
    beam = p + R.apply(lug) + 10.0 * d
    poses = {"block": (p[None], R.as_matrix()[None]), "beam": (beam[None], np.eye(3)[None])}
    signals = SignalColumns(t=np.array([1.0]), tensions={sling: np.array([tension])}, poses=poses, dynamic=True)
    lines = [RopeLine(sling, "beam", (0.0, 0.0, 0.0), "block", lug)]
    use = Use(limit, tension / G, 1.0)
    made = {
        x.title: x for x in RunTables(plan, [], 1.0).tables([use], {sling: (tension, 1.0)}, lambda t: (signals, lines))
    }
    (row,), (leg,) = rows(made["Loads on lugs"]), rows(made["Slings"])
    assert [row[f"along {axis}"] for axis in "uvw"] == pytest.approx((R.inv().apply(d) * tension / 1e3).tolist())
    assert leg["angle to vertical at its peak"] == pytest.approx(degrees(np.arccos(abs(d[2]))))


@pytest.mark.parametrize("seed", range(10))
def test_the_report_gives_lowest_point_and_dynamic_factor_of_each_stage(seed: int) -> None:
    """Random loads and attitudes, in parts that overlap by one sample, beside the same all at once."""
    random, plan = np.random.default_rng(seed), load("lift").plan
    n, ropes = 40, [hook.rope for machine in plan.machines for hook in machine.hooks]
    R, p, t = Rotation.random(n, random_state=seed), random.uniform(5.0, 20.0, (n, 3)), np.arange(n) / 2.0
    pulls = {rope: random.uniform(1e6, 3e6, n) for rope in ropes}
    whole = RunTables(plan, [(0.0, "one"), (10.0, "two")], t[-1])
    for first in range(0, n - 1, 13):
        part = slice(first, first + 14)
        poses = {"block": (p[part], R.as_matrix()[part])}
        whole.see(SignalColumns(t=t[part], tensions={x: T[part] for x, T in pulls.items()}, poses=poses, dynamic=True))
    made = {x.title: x for x in whole.tables([], {}, lambda _: (None, ()))}
    total, one = sum(pulls.values()), t <= 10.0
    late = total[one][t[one] >= 9.5].mean()
    stage = rows(made["Stages"])[0]
    assert stage["dynamic factor of crane"] == pytest.approx(total[one].max() / max(total[0], late), rel=1e-9)
    corners = np.array([[x, y, z] for x in (-10, 10) for y in (-8, 8) for z in (-4, 4)])
    lowest = min((p[i] + R[i].apply(corners))[:, 2].min() for i in range(n) if one[i])
    assert rows(made["Path of the block"])[0]["lowest point"] == pytest.approx(lowest, abs=0.5), "stools and deck"
