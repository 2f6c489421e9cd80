"""Limits and conditions share one table of signals, whose formulas give the same bits on columns and at instants."""

from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from heavylift.kernel.analysis import Poses
from heavylift.kernel.description import Point, Quantity, ScalarSignal, assembled, guard_of
from heavylift.kernel.model import LINED, ROWS, SIDES, check_signal, scalar
from heavylift.kernel.simulation import Simulation
from heavylift.kernel.simulation.native import reader
from heavylift.nodes.limits import BASES, KINDS, NOISE, REDUCTIONS, evaluated, measured, signal_of, signals_of
from heavylift.nodes.plan import IN_WIND, Quantity as Limited
from heavylift.nodes.scene import bundled, load, new_scene_with, parse
from heavylift.nodes.scene.text import library

PLACES = {
    "height": 1,
    "height difference": 2,
    "height over": 3,
    "radius": 2,
    "moment": 2,
    "use by place": 1,
    "gap": 8,
    "overhang": 5,
}
PLACES |= {"place along": 1, "place across": 1, "overhang": 5}
SHARES, LINES = (0.4, 0.6), (1, 1)
GROUPS = {"track pressure": 3, "corner load": 3, "tipping": 3, "joint moment": 2, "starting moment": 2}  # of its frame
PLACES |= {kind: frame + (8 if kind == "starting moment" else 2) + 4 for kind, frame in GROUPS.items()}
OF_SHAPES = ("clearance", "sharing")  # of no signals: shapes and counts of slings decide them
WITHOUT = ("inputs", "factor", "heavy sling", IN_WIND)  # rows without a value, or with one that is known at rest
SUPPORTS = ("support load", "impact")  # forces that no guard of the kernel is over
NUMBERS = {
    "load": (0.1, 3.0),
    "use": (0.5, 0.7, 0.2),
    "moment": (1.0, 2.0, 5.0, 4.0, 2.0),
    "use by place": (0.1, 0.0, -3.0, 2.0, 1.0, 6.0),
    "gap": (1.0, 2.0, 0.5, 2.0, 1.0, 1.0),
    "overhang": (2.0, 1.5),
    "pull": (0.3, 9.0),
    "reserve": (0.3, 9.0, 500.0),
    "place along": (4.0,),
    "place across": (4.0,),
    "vertical load": (0.1,),
    "track pressure": (0.8, 0.6, 7.0, 6.0, 1.2, -1.0, 2.0, 3.0),
    "corner load": (0.8, 0.6, 7.0, 6.0, 1.0, -1.0, 2.0, 3.0),
    "tipping": (0.8, 0.6, 7.0, 6.0, 1.0),
    "starting moment": (0.01,),
}
BODY = {"starting moment": (90.0, 9.0, *(float(x) for x in range(9)))}  # weight, mass, inertia
NUMBERS |= {kind: (*NUMBERS.get(kind, ()), *2 * BODY.get(kind, (90.0,)), *SHARES) for kind in GROUPS}


@pytest.mark.parametrize("quantity", get_args(Quantity))
def test_the_formula_of_a_signal_gives_equal_values_on_columns_and_at_single_instants(quantity: Quantity) -> None:
    random, n = np.random.default_rng(1), 200
    lined, side = quantity in LINED, quantity in SIDES
    x = ScalarSignal(quantity, of="one", point=Point("a"), origin=Point("b"), ropes=("r", "s", "t"))
    places = random.normal(0.0, 5.0, (4 if lined else PLACES.get(quantity, 0), 3, n)).round(3)
    numbers = (*NUMBERS.get(quantity, ()), *(SHARES if lined else ()))
    shared = side or quantity in GROUPS
    values, lines = random.normal(5.0, 4.0, (2 if shared else 3, n)).round(1), LINES if shared else ()
    columns = np.broadcast_to(scalar(x, list(places), numbers, list(values), lines), n)
    each = [scalar(x, places[:, :, k].tolist(), numbers, values[:, k].tolist(), lines) for k in range(n)]
    assert columns.tolist() == each


def test_every_quantity_with_a_limit_is_checked_on_signals_or_on_reductions_of_signals() -> None:
    assert set(KINDS.values()) <= set(ROWS)
    assert {*KINDS, *REDUCTIONS, *BASES, "signal", "interlock"} == {*get_args(Limited)} - {*OF_SHAPES, *WITHOUT}
    beyond = {quantity for quantity, reduction in REDUCTIONS.items() if reduction in ("ordered speed", "splash zone")}
    assert set(REDUCTIONS) - beyond <= set(KINDS), "what is ordered, or searched between samples, is no signal"


@pytest.mark.parametrize("name", ["lift", "crawler", "jib", "dock"])
def test_a_limit_and_a_condition_for_the_same_load_use_one_signal(name: str) -> None:
    plan = load(name).plan
    row = next(x for x in plan.limits if x.quantity == "hook load")
    words = f"load of {row.subject.replace('.', ' ')} <= 1 t"
    own = next(x for x in load(name, [f"limits={{signals: [{words}]}}"]).plan.limits if x.quantity == "signal")
    assert own.signal == signal_of(row, plan.machines, plan.gravity)


@pytest.mark.parametrize("name", sorted({*bundled()} - {"yard"}))  # of several lifts, each with a path of its own
def test_signals_of_limits_can_be_used_as_thresholds_and_evaluated_along_the_equilibrium_path(name: str) -> None:
    scene = load(name)
    plan, signals = scene.plan, signals_of(scene.statics.states)
    system = assembled([machine.system for machine in plan.machines], plan.gravity)
    straight = {rope.name for rope in system.straight_ropes}
    for limit in plan.limits:
        if limit.quantity in SUPPORTS:
            continue
        each = measured(limit, plan.machines, plan.gravity, plan.actions)
        assert each or limit.quantity in (*OF_SHAPES, *WITHOUT, *REDUCTIONS, *BASES) or not limit.elements, limit
        for x, *_ in each:
            bent = x.quantity in LINED and not {*x.ropes} <= straight
            if not bent:
                check_signal(x, system, limit.subject)
            on_record = {*x.ropes} <= {*signals.tensions} and len(signals.t) > 0
            assert (evaluated(plan, x, signals) is None) == (bent or not on_record), limit


@pytest.mark.parametrize("crane", sorted(library()))
def test_a_signal_has_the_same_value_in_a_guard_and_in_samples_and_in_statics(
    crane: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Over every type: a guard on the value that is read off the first sample has its zero there, and what the columns
    of the first state at rest give is that value."""
    monkeypatch.chdir(tmp_path)
    size = "30,24" if crane.startswith(("goliath", "twin", "mobile")) else "6,5"
    head = "name,mass [t],size x [m],size y [m],size z [m]\n"
    Path("blocks.csv").write_text(f"{head}B,10,{size},4\n", encoding="utf-8")
    (text,) = new_scene_with("made", crane, "blocks.csv#B").values()
    scene = parse(text, str(tmp_path / "made.yaml"))
    plan, signals = scene.plan, signals_of(scene.statics.states[:1])
    system = assembled([machine.system for machine in plan.machines], plan.gravity)
    straight, found = {rope.name for rope in system.straight_ropes}, dict[str, ScalarSignal]()
    units = dict[str, str]()
    for limit in (limit for limit in plan.limits if limit.quantity not in SUPPORTS):
        for x, *_ in measured(limit, plan.machines, plan.gravity, plan.actions):
            if x.quantity not in LINED or {*x.ropes} <= straight:
                found[name := f"{limit.subject} {limit.quantity} {len(found)}"] = x
                units[name] = limit.unit
    guards = tuple(guard_of(name, x) for name, x in found.items())
    simulation = Simulation(replace(system, thresholds=guards))
    simulation.start()
    row = simulation.native.raw().tolist()
    for name, x in found.items():
        value = reader(simulation.program, x)(row)
        column = evaluated(plan, x, signals)
        assert column is None or column[0] == pytest.approx(value, rel=1e-3, abs=10.0 * NOISE.get(units[name], 1e-6)), (
            name
        )
        simulation.switches.watch(name, value, rising=True)
    poses = Poses(simulation)
    poses.accelerations(poses.q)
    values = dict(zip(simulation.program.guards, poses.guards(), strict=True))
    for name in found:
        assert values["threshold", name] == pytest.approx(0.0, abs=1e-9), name


def test_pull_and_side_force_of_ropes_agree_with_vector_algebra() -> None:
    """T and the weight of its length in the part at the upper end; T d / |d| summed over ropes."""
    random = np.random.default_rng(2)
    for _ in range(50):
        a, b, c, d = random.normal(0.0, 9.0, (4, 3))
        T, U = random.uniform(1e3, 9e5, 2)
        mean = 0.3 * (b - a) + 0.7 * (d - c)
        pull = 0.2 * T + 30.0 * np.linalg.norm(mean)
        one = ScalarSignal("pull", ropes=("r",), numbers=(0.2, 30.0))
        assert scalar(one, [a, b, c, d], (0.2, 30.0, 0.3, 0.7), [T]) == pytest.approx(pull, rel=1e-12)
        factor = scalar(ScalarSignal("reserve"), [a, b, c, d], (0.2, 30.0, 2e6, 0.3, 0.7), [T])
        assert factor == pytest.approx(2e6 / pull, rel=1e-12)
        both = T * (b - a) / np.linalg.norm(b - a) + U * (d - c) / np.linalg.norm(d - c)
        for axis, quantity in enumerate(SIDES):
            found = scalar(ScalarSignal(quantity, ropes=("r", "s")), [a, b, c, d], (1.0, 2.0), [T, U], (1, 1))
            assert found == pytest.approx(both[axis], rel=1e-9, abs=1e-6 * (T + U))
