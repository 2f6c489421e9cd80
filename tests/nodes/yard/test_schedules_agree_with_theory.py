"""Critical paths, PERT and a network of Patterson's: results that are published or computed by hand."""

import random
from itertools import pairwise
from math import sqrt
from pathlib import Path
from statistics import NormalDist

import pytest
from heavylift.nodes.devs import NEVER, Simulator
from heavylift.nodes.yard import RULES, chain, coupled, dates, load, ranks, serial

HERE = Path(__file__).parent
DAY = 86400e9
SERIAL = {"EST": 21, "LST": 19, "LFT": 20, "MSLK": 19, "MTS": 20}
PARALLEL = {"EST": 21, "LST": 22, "LFT": 23, "MSLK": 22, "MTS": 23}
PERT = {
    "A": (20, 30, 40), "C": (50, 60, 100), "D": (30, 50, 100), "G": (25, 30, 35), "H": (10, 20, 30), "I": (20, 25, 60),
    "L": (20, 25, 60),
}  # fmt: skip


def written(folder, rows, text):
    (folder / "blocks.csv").write_text("\n".join(rows) + "\n")
    (folder / "yard.yaml").write_text(f"heavylift yard: 1\nstart: 2027-01-04\nblocks: {{from: blocks.csv}}\n{text}\n")
    return load(folder / "yard.yaml")


def ran(yard, rule="", seed=0):
    """The schedule of the dispatcher."""
    model = coupled(yard, seed, rule)
    simulator = Simulator(model)
    simulator.start()
    simulator.run(NEVER - 1)
    return model.children["dispatcher"].result()


def by_hand(yard, rule):
    """Parallel schedule generation, as books write it, for a yard without calendar."""
    rank, n = ranks(yard, rule), len(yard.activities)
    ends, starts, t = {}, {}, 0
    while len(starts) < n or any(end > t for end in ends.values()):
        fits = True
        while fits:
            fits = False
            for m in sorted(set(range(n)) - set(starts), key=rank.__getitem__):
                one = yard.activities[m]
                if one.ready > t or any(p not in ends or ends[p] + lag > t for p, lag in one.after):
                    continue
                active = [k for k in starts if ends[k] > t]
                used = {r: sum(x.units for k in active for x in yard.activities[k].needs if x.resource == r)
                        for r in yard.capacities}  # fmt: skip
                if all(used[x.resource] + x.units <= yard.capacities[x.resource] for x in one.needs):
                    starts[m], ends[m], fits = t, t + one.expected, True
                    break
        times = [
            end + lag for end in ends.values() for lag in {0, *(lag for one in yard.activities for _, lag in one.after)}
        ]
        times += [one.ready for one in yard.activities]
        t = min((x for x in times if x > t), default=t)
    return [(starts[m], ends[m]) for m in range(n)]


@pytest.mark.parametrize("rule", RULES)
def test_the_published_project_network_of_patterson_is_scheduled_with_its_known_duration(rule):
    yard = load(HERE / "pat1.yaml")
    assert max(dates(yard).early_finish) == 18 * DAY
    assert max(end for _, end in serial(yard, rule)) == SERIAL[RULES[rule]] * DAY
    assert ran(yard, rule).delivery == PARALLEL[RULES[rule]] * DAY / 1e9


NEWCASTLE = """block,after,work [days]
cargo-1,,2
cargo-2,cargo-1,4
cargo-3,cargo-2,4
cargo-4,cargo-3,4
cargo-5,cargo-4,4
cargo-6,cargo-5,5
lower-fore-end,cargo-6,6
upper-fore-end,lower-fore-end,8
deck-cranes,cargo-5,10
lower-engine-room,cargo-1,4
main-machinery,lower-engine-room,13
upper-engine-room,main-machinery,6
aft-end,upper-engine-room,8
superstructure,upper-engine-room,10
float-out,upper-fore-end deck-cranes aft-end superstructure,1"""


def test_a_published_erection_network_has_its_critical_path_and_floats(tmp_path):
    """Small yard, from the first unit in the dock to float-out (Newcastle University, MAR 2313, Network Planning)."""
    yard = load_rows(tmp_path, NEWCASTLE)
    known, path = dates(yard), chain(yard)[0]
    blocks = [one.block for one in yard.activities]
    assert [blocks[n] for n in path] == [*blocks[:8], "float-out"]
    assert ran(yard).delivery == known.early_finish[-1] / 1e9 == 38 * DAY / 1e9
    floats = {blocks[n]: (known.late_start[n] - known.early_start[n]) / DAY for n in range(len(blocks))}
    assert {block: x for block, x in floats.items() if x} == {
        "deck-cranes": 9, "lower-engine-room": 2, "main-machinery": 2, "upper-engine-room": 2, "aft-end": 4,
        "superstructure": 2,
    }  # fmt: skip


def load_rows(folder, table, text="resources: {}\nsteps: {work: {}}"):
    return written(folder, table.split("\n"), text)


@pytest.mark.parametrize(("columns", "rows"), [(3, 1), (5, 2), (7, 4)])
def test_erection_takes_the_lift_times_plus_two_joints_if_joining_is_shorter_than_lifting(tmp_path, columns, rows):
    """Blocks upward and from the middle outward; joining no longer than lifting (the second special case of Tokola,
    Niemi and Remes 2013, Journal of Ship Production and Design 29): the crane waits for the first joint only, so that
    all lifts, the first joint and the last one remain, by hand."""
    lift, join, middle = 6, 5, columns // 2
    table = ["block,after"]
    for row in range(rows):
        for column in sorted(range(columns), key=lambda c: (abs(c - middle), c)):
            inner = column + (column < middle) - (column > middle)
            below = [f"{column}-{row - 1}"] if row else []
            table.append(f"{column}-{row},{' '.join(below + ([f'{inner}-{row}'] if inner != column else []))}")
    text = f"""resources: {{crane: 1}}
erection: [lift, join]
steps: {{lift: {{takes: {lift} h, needs: {{crane: 1}}}}, join: {{takes: {join} h, after: lift}}}}"""
    yard = load_rows(tmp_path, "\n".join(table), text)
    assert ran(yard, "earliest start").delivery == (columns * rows * lift + 2 * join) * 3600


def test_serial_schedule_generation_gives_the_schedule_computed_by_hand(tmp_path):
    """One resource of two units, latest finish: C and D compete; D is the more urgent, and B fits beside neither."""
    table = "block,after,work [h],work r\nA,,2,1\nB,,3,2\nC,A,2,1\nD,A,4,1\nE,C D,1,2"
    found = serial(load_rows(tmp_path, table, "resources: {r: 2}\nsteps: {work: {}}"), "latest finish")
    assert [(a / 3600e9, b / 3600e9) for a, b in found] == [(0, 2), (6, 9), (2, 4), (2, 6), (9, 10)]


def random_yard(folder, seed):
    draw = random.Random(seed)
    rows = ["block,after,ready,work [h],work r1,work r2"]
    for n in range(25):
        before = [f"B{m}" + draw.choice(["", "", " + 3 h"]) for m in range(max(0, n - 6), n) if draw.random() < 0.3]
        ready = f"2027-01-{draw.randint(4, 8):02}"
        rows.append(
            f'B{n},"{", ".join(before)}",{ready},{draw.randint(0, 20)},{draw.randint(0, 3)},{draw.randint(0, 2)}'
        )
    return written(folder, rows, "resources: {r1: 4, r2: 2}\nsteps: {work: {}}")


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("rule", RULES)
def test_the_yard_dispatcher_follows_the_parallel_schedule_generation_scheme(tmp_path, seed, rule):
    yard = random_yard(tmp_path, seed)
    schedule = ran(yard, rule)
    assert [*zip(schedule.starts, schedule.ends, strict=True)] == [(a / 1e9, b / 1e9) for a, b in by_hand(yard, rule)]


@pytest.mark.parametrize("seed", range(8))
def test_each_activity_of_the_critical_sequence_begins_when_the_one_before_allows_it(tmp_path, seed):
    yard = random_yard(tmp_path, seed)
    schedule = ran(yard)
    sequence = sorted((n for n in range(25) if schedule.critical[n]), key=lambda n: (schedule.ends[n], n))
    assert schedule.ends[sequence[-1]] == schedule.delivery
    for a, b in pairwise(sequence):
        lags = [lag / 1e9 for m, lag in yard.activities[b].after if m == a]
        assert schedule.starts[b] in {schedule.ends[a], *(schedule.ends[a] + lag for lag in lags)}


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("rule", RULES)
def test_serial_schedule_generation_respects_precedence_and_resources(tmp_path, seed, rule):
    yard = random_yard(tmp_path, seed)
    found = serial(yard, rule)
    for (start, _), one in zip(found, yard.activities, strict=True):
        assert start >= max([one.ready, *(found[m][1] + lag for m, lag in one.after)])
        for resource, most in yard.capacities.items():
            active = [n for n, (a, b) in enumerate(found) if a <= start < b]
            assert sum(x.units for n in active for x in yard.activities[n].needs if x.resource == resource) <= most


def test_a_chain_of_activities_has_the_mean_and_variance_of_pert(tmp_path):
    rows, last = ["block,after,work"], ""
    for name, (a, m, b) in PERT.items():
        rows.append(f"{name},{last},pert {a} h {m} h {b} h")
        last = name
    path, mean, spread = chain(written(tmp_path, rows, "resources: {}\nsteps: {work: {}}"))
    assert len(path) == 7
    assert mean / 3600 == pytest.approx(260)
    assert spread / 3600**2 == pytest.approx(319.43, abs=0.02)
    assert NormalDist(mean, sqrt(spread)).cdf(270 * 3600) == pytest.approx(0.712, abs=5e-4)
