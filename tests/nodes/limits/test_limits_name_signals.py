"""A limit names a signal of the one table, whose formula conditions trace: on columns it gives the same bits."""

from typing import get_args

import numpy as np
import pytest
from heavylift.kernel.description import Point, Quantity, ScalarSignal, assembled
from heavylift.kernel.model import LINED, ROWS, SIDES, check_signal, scalar
from heavylift.nodes.limits import BASES, KINDS, READERS, evaluated, signal_of, signals_of
from heavylift.nodes.plan import IN_WIND, STANDING, TOUCHING
from heavylift.nodes.scene import bundled, load

PLACES = {"height": 1, "height difference": 2, "radius": 2, "moment": 2, "use by place": 1, "gap": 8}
PLACES |= {"place along": 1, "place across": 1}
SHARES, LINES = (0.4, 0.6), (1, 1)
UNSIGNALLED = ("clearance", "wind", "bridle angle", "assembly load", "sharing")
SUPPORTS = ("support load", "impact")  # forces that no guard of the kernel is over
NUMBERS = {
    "load": (0.1, 3.0),
    "use": (0.5, 0.7, 0.2),
    "moment": (1.0, 2.0, 5.0, 4.0, 2.0),
    "use by place": (0.1, 0.0, -3.0, 2.0, 1.0, 6.0),
    "gap": (1.0, 2.0, 0.5, 2.0, 1.0, 1.0),
    "pull": (0.3, 9.0),
    "reserve": (0.3, 9.0, 500.0),
    "place along": (4.0,),
    "place across": (4.0,),
}


@pytest.mark.parametrize("quantity", get_args(Quantity))
def test_a_formula_gives_the_same_on_whole_columns_and_at_each_instant(quantity: Quantity) -> None:
    random, n = np.random.default_rng(1), 200
    lined, side = quantity in LINED, quantity in SIDES
    x = ScalarSignal(quantity, of="one", point=Point("a"), origin=Point("b"), ropes=("r", "s", "t"))
    places = random.normal(0.0, 5.0, (4 if lined else PLACES.get(quantity, 0), 3, n)).round(3)
    numbers = (*NUMBERS.get(quantity, ()), *(SHARES if lined else ()))
    values, lines = random.normal(5.0, 4.0, (2 if side else 3, n)).round(1), LINES if side else ()
    columns = np.broadcast_to(scalar(x, list(places), numbers, list(values), lines), n)
    each = [scalar(x, places[:, :, k].tolist(), numbers, values[:, k].tolist(), lines) for k in range(n)]
    assert columns.tolist() == each


def test_every_signal_that_limits_can_name_is_in_the_table() -> None:
    assert set(KINDS.values()) <= set(ROWS)
    assert set(READERS) - {
        *STANDING,
        *TOUCHING,
        *BASES,
        "relative heave",
        "slack sling",
        "splash load",
        "assembly load",
        "drive moment",
        "brake moment",
    } <= set(KINDS)


@pytest.mark.parametrize("name", ["lift", "crawler", "jib", "dock"])
def test_a_limit_and_a_condition_on_the_same_load_use_one_signal(name: str) -> None:
    plan = load(name).plan
    row = next(x for x in plan.limits if x.quantity == "hook load")
    words = f"load of {row.subject.replace('.', ' ')} <= 1 t"
    own = next(x for x in load(name, [f"limits={{signals: [{words}]}}"]).plan.limits if x.quantity == "signal")
    assert own.signal == signal_of(row, plan.machines, plan.gravity)


@pytest.mark.parametrize("name", sorted({*bundled()} - {"yard"}))  # of several lifts, each with a path of its own
def test_a_limited_signal_can_be_a_threshold_and_evaluated_along_the_path(name: str) -> None:
    scene = load(name)
    plan, signals = scene.plan, signals_of(scene.statics.states)
    system = assembled([machine.system for machine in plan.machines], plan.gravity)
    straight = {rope.name for rope in system.straight_ropes}
    for limit in plan.limits:
        x = signal_of(limit, plan.machines, plan.gravity)
        if x is None or limit.quantity in SUPPORTS:
            assert (
                x
                or limit.quantity
                in (*UNSIGNALLED, *STANDING, *TOUCHING, *BASES, IN_WIND, "drive moment", "brake moment")
                or not limit.elements
            ), limit
            continue
        if not (x.quantity in LINED and not {*x.ropes} <= straight):
            check_signal(x, system, limit.subject)
        on_record = {*x.ropes} <= {*signals.tensions}
        bent = x.quantity in LINED and not {*x.ropes} <= straight
        assert (evaluated(plan, x, signals) is None) == (bent or not on_record), limit


def test_pull_and_side_force_of_ropes_agree_with_vectors() -> None:
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
