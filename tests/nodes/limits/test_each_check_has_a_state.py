"""The state of a check (red, undecided, amber, green) follows from its value, its limit and the error of the value."""

from __future__ import annotations

import random
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
import typer
from heavylift.coordinator.commands.common import end_by
from heavylift.kernel.description import NOT_CHECKED, STATES, UNKNOWN, Check
from heavylift.nodes.limits import ABSENT, RatedLimit, SignalColumns, checks_of, likewise, line_of, table_of, uses_of
from heavylift.nodes.plan import Quantity, Use
from heavylift.nodes.scene import load, new_scene_with, parse
from heavylift.nodes.scene.text import library
from lifting import bare

QUANTITIES = ("hook height", "hook load", "off-lead", "sling tension")
PLAN = bare("lift").plan
STEP = 1e-6  # of a value, in which its use changes as along its tangent


def ends(state: str, strict: bool, fail_on: str) -> bool:
    """Whether a command with a verdict of this state ends with exit code 1."""
    try:
        end_by(strict, fail_on, state)
    except typer.Exit as error:
        return error.exit_code == 1
    return False


def drawn(rng: random.Random) -> Use:
    """A use of a random limit."""
    ends = {"between": (0.0, 10.0)} if rng.random() < 0.3 else {"value": rng.uniform(1.0, 10.0)}
    least = "value" in ends and rng.random() < 0.3
    limit = RatedLimit(
        subject="one", quantity=rng.choice(QUANTITIES), unit="kN", least=least, source="the scene", **ends  # type: ignore[arg-type]
    )  # fmt: skip
    value = rng.uniform(0.1, 12.0)
    return Use(limit, value, 1.0, use=limit.use(value))


def state(use: Use, errors: dict[str, float]) -> str:
    (check,) = (c for c in checks_of(PLAN, [use], [], errors, []) if c.quantity != "factor sheet")
    assert check.value == use.value
    return check.why or check.state


@pytest.mark.parametrize("seed", range(200))
def test_a_check_is_undecided_only_if_the_limit_lies_within_the_error_of_the_value(seed: int) -> None:
    """The oracle evaluates both ends of the bar, which is that of the use along the tangent."""
    rng = random.Random(seed)
    use, error = drawn(rng), rng.choice([0.0, 1e-3, 0.05, 0.5])
    value = use.value or 0.0
    slope = (use.limit.use(value * (1.0 + STEP)) - use.limit.use(value * (1.0 - STEP))) / (2.0 * STEP * value)
    size = error * max(1.0, use.use or 0.0) / abs(slope)
    beyond = [use.limit.excess(value + side * size) > 0.0 for side in (-1.0, 0.0, 1.0)]
    expected = "red" if all(beyond) else "undecided" if any(beyond) else "green"
    assert state(use, {f"use of one {use.limit.quantity}": error}) == expected


@pytest.mark.parametrize("seed", range(50))
def test_a_checked_value_whose_error_is_unknown_is_never_green(seed: int) -> None:
    use = drawn(random.Random(seed))
    assert state(use, {}) == ("red" if use.limit.excess(use.value or 0.0) > 0.0 else UNKNOWN)


@pytest.mark.parametrize("elements", [(), ("a",)], ids=["without elements", "with an element"])
@pytest.mark.parametrize("quantity", get_args(Quantity))
def test_a_quantity_without_a_limit_is_reported_as_not_checked(quantity: Quantity, elements: tuple[str, ...]) -> None:
    """Only where there is no wind, or no footing, is there nothing to check."""
    use = Use(RatedLimit(subject="one", quantity=quantity, unit="N", elements=elements), None, None)
    expected = "none" if quantity in ABSENT and not elements else NOT_CHECKED
    assert state(use, {}) == expected


def test_by_default_the_error_of_a_hook_load_is_that_of_its_rope_tensions() -> None:
    limit = RatedLimit(
        subject="load", quantity="hook load", unit="kg", value=10.0, elements=("a", "b"), source="the scene"
    )
    use = Use(limit, 9.5, 1.0, use=0.95)
    assert state(use, {"peak tension a": 0.1, "peak tension b": 0.01}) == "undecided"
    assert state(use, {"peak tension a": 0.01, "peak tension b": 0.01}) == "green"
    assert state(use, {"peak tension a": 0.01}) == UNKNOWN
    assert state(use, {"peak tension a": 0.1, "peak tension b": 0.1, "use of load hook load": 0.01}) == "green"


@pytest.mark.parametrize("seed", range(20))
def test_the_summary_line_names_a_finding_or_else_the_highest_utilisation(seed: int) -> None:
    rng = random.Random(seed)
    uses = [rng.uniform(1.0, 2.0) for _ in range(5)]
    found = [Check(quantity=f"load {i}", subject="x", state="red", sentence=f"{x}", use=x) for i, x in enumerate(uses)]
    assert line_of(found).endswith(f"; worst: {max(uses)}")
    cut = Check(quantity="cut", subject="run", state="red", sentence="a cut")
    assert line_of(rng.sample([*found, cut], 6)).endswith("; worst: a cut")


@pytest.mark.parametrize("seed", range(20))
def test_contact_that_no_order_allows_is_reported_before_narrow_clearances(seed: int) -> None:
    """The deepest contact first, however early and however many things only came near."""
    rng = random.Random(seed)
    gaps = [rng.uniform(0.05, 0.4) for _ in range(rng.randint(0, 4))]
    depths = [-0.5 * rng.random() for _ in range(rng.randint(1, 3))]
    values = rng.sample(gaps + depths, len(gaps) + len(depths))
    common: dict[str, Any] = {"quantity": "clearance", "state": "red", "limit": 0.5, "unit": "m"}
    found = [Check(subject=f"{i}", sentence=f"{x}", t=float(i), value=x, **common) for i, x in enumerate(values)]
    checks = checks_of(PLAN, [], found, {}, [])
    assert line_of(checks).endswith(f"; worst: {min(values)}")
    assert likewise(found)[0].value == min(values)
    (row,) = (row for row in table_of(checks).rows if row[1] == "clearance")
    assert str(row[-1]) == f"{min(values)}"


def test_a_check_based_on_an_assumption_is_amber_until_the_scene_accepts_the_assumption() -> None:
    plain, accepted = bare("lift"), bare("lift", ["assumed=accept"])
    assert {c.quantity for c in plain.checks if c.why == "assumed"} >= {"off-lead along", "sling tension"}
    assert not [c for c in accepted.checks if c.why == "assumed"]
    assert len(accepted.checks) == len(plain.checks)


@pytest.mark.parametrize("crane", sorted(library()))
def test_every_check_of_every_crane_type_states_what_would_turn_it_green(
    crane: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    long, wide = (30, 24) if crane.startswith(("goliath", "twin", "mobile")) else (6, 5)
    head = "name,mass [t],size x [m],size y [m],size z [m]\n"
    (tmp_path / "blocks.csv").write_text(f"{head}B,10,{long},{wide},4\n", encoding="utf-8")
    (text,) = new_scene_with("made", crane, "blocks.csv#B").values()
    scene = parse(text, str(tmp_path / "made.yaml"))
    checks = scene.checks
    assert [STATES.index(c.state) for c in checks] == sorted(STATES.index(c.state) for c in checks), "worst first"
    assert all(c.sentence for c in checks if c.state != "green")
    assert {c.subject for c in checks if c.basis} >= {limit.subject for limit in scene.plan.limits}
    counts = line_of(checks).partition(": ")[2].partition(";")[0].split(", ")
    assert sum(int(one.split()[0]) for one in counts) == sum(c.state != "none" or bool(c.why) for c in checks)


def test_a_limit_is_not_checked_if_the_run_did_not_record_its_signals() -> None:
    machines, t = PLAN.machines, np.array([0.0, 1.0])
    still = np.zeros((2, 3)), np.tile(np.eye(3), (2, 1, 1))
    poses = {body.name: still for machine in machines for body in machine.system.bodies}
    slack = {rope.name: np.zeros(2) for machine in machines for rope in machine.system.all_ropes}
    for recorded, expected in (({}, ("amber", NOT_CHECKED)), (poses, ("none", ""))):
        uses = uses_of(PLAN, [SignalColumns(t, slack, recorded, dynamic=True)])
        found = [c for c in checks_of(PLAN, uses, [], {}, []) if c.quantity.startswith("off-lead")]
        assert {(c.state, c.why) for c in found} == {expected}


def test_a_check_with_an_unknown_limit_names_the_scene_key_to_write() -> None:
    (check,) = [c for c in bare("lift").checks if c.subject == "block" and c.quantity == "support load"]
    message = "support load of block: give 'capacity' of its supports"
    assert (check.state, check.why, check.sentence) == ("amber", NOT_CHECKED, message)


@pytest.mark.parametrize(
    ("state", "failing"),
    [("red", "red undecided amber"), ("undecided", "undecided amber"), ("amber", "amber"), ("green", "")],
)
def test_a_verdict_as_bad_as_the_option_fail_on_gives_exit_code_1(state: str, failing: str) -> None:
    assert [word for word in ("red", "undecided", "amber") if ends(state, False, word)] == failing.split()
    assert ends(state, True, "") == (state in ("red", "undecided")), "--strict"


def test_a_value_beyond_its_limit_by_more_than_the_tolerance_gives_a_red_check() -> None:
    limit = RatedLimit(subject="crane", quantity="rails", unit="m", between=(0.0, 10.0), source="the scene")
    use = Use(limit, 10.04, 1.0, use=limit.use(10.04), tolerance=0.05)
    known = {"use of crane rails": 1e-6}
    assert state(use, known) == "green"
    assert state(replace(use, value=10.06, use=limit.use(10.06)), known) == "red"


def test_a_workbook_has_each_value_and_limit_as_a_number_in_the_column_of_its_unit() -> None:
    scene = load("crawler")
    numbers = table_of(scene.checks).numbers
    assert numbers is not None
    heads = [column.heading for column in numbers.columns]
    assert len(heads) == len({*heads})
    rows = [dict(zip(heads, row, strict=True)) for row in numbers.rows]
    factors = {"kg": ("t", 1e3), "N": ("kN", 1e3), "m/s": ("m/min", 1 / 60), "rad": ("deg", pi / 180), "m": ("m", 1)}
    for check, row in zip(scene.checks, rows, strict=True):
        if check.unit not in factors or check.value is None:
            continue
        unit, size = factors[check.unit]
        assert row[f"value [{unit}]"] == pytest.approx(check.value / size)
        others = [x for head, x in row.items() if head.startswith("value") and head != f"value [{unit}]"]
        assert others == [None] * len(others)
