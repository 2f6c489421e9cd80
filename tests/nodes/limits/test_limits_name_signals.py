"""A limit names a signal of the one table, whose formula conditions trace: on columns it gives the same bits."""

from typing import get_args

import numpy as np
import pytest
from heavylift.kernel.description import Point, Quantity
from heavylift.kernel.description.signals import Signal
from heavylift.kernel.model import ROWS, scalar
from heavylift.nodes.limits import KINDS, READERS, hooks_of, signal_of
from heavylift.nodes.scene import load

PLACES = {"height": 1, "height difference": 2, "radius": 2, "moment": 2, "use by place": 1, "gap": 8}
LINES = ("swing along", "swing across", "off-lead")
NUMBERS = {
    "load": (0.1, 3.0),
    "use": (0.5, 0.7, 0.2),
    "moment": (1.0, 2.0, 5.0, 4.0, 2.0),
    "use by place": (0.1, 0.0, -3.0, 2.0, 1.0, 6.0),
    "gap": (1.0, 2.0, 0.5, 2.0, 1.0, 1.0),
}


@pytest.mark.parametrize("quantity", get_args(Quantity))
def test_a_formula_gives_on_columns_what_it_gives_at_each_instant(quantity: Quantity) -> None:
    random, n = np.random.default_rng(1), 200
    lined = quantity in LINES
    x = Signal(quantity, of="one", point=Point("a"), origin=Point("b"), ropes=("r", "s", "t"))
    places = random.normal(0.0, 5.0, (4 if lined else PLACES.get(quantity, 0), 3, n)).round(3)
    numbers = (0.4, 0.6) if lined else NUMBERS.get(quantity, ())
    values = random.normal(5.0, 4.0, (3, n)).round(1)
    columns = np.broadcast_to(scalar(x, list(places), numbers, list(values)), n)
    each = [scalar(x, places[:, :, k].tolist(), numbers, values[:, k].tolist()) for k in range(n)]
    assert columns.tolist() == each


def test_every_named_signal_is_in_the_table() -> None:
    assert set(KINDS.values()) <= set(ROWS)
    assert set(KINDS) <= set(READERS)


@pytest.mark.parametrize("name", ["lift", "crawler", "jib", "dock"])
def test_the_limit_of_a_load_and_a_condition_on_it_name_one_signal(name: str) -> None:
    plan = load(name).plan
    row = next(x for x in plan.limits if x.quantity == "hook load")
    words = f"load of {row.subject.replace('.', ' ')} <= 1 t"
    own = next(x for x in load(name, [f"limits={{signals: [{words}]}}"]).plan.limits if x.quantity == "signal")
    assert own.signal == signal_of(row, hooks_of(plan), plan.gravity)
