"""VALIDATION.md shows the computed results, counts its rows and explains each miss."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
import pytest
from comparison import CASES, Case, Row
from measured_cases import EVERY, GRAVITY, RUNS, Run, swung
from page import PAGE, made, main, stale
from scipy.integrate import solve_ivp

SLOW = pytest.mark.large
EACH = [pytest.param(case, id=case.name, marks=SLOW if case.full else ()) for case in CASES]


@pytest.mark.parametrize("case", EACH)
def test_each_row_of_the_comparison_page_states_the_value_computed_from_the_sources(case: Case) -> None:
    assert stale(case, PAGE.read_text()) == []


def test_the_summary_of_the_comparison_page_states_the_number_of_its_rows() -> None:
    text = PAGE.read_text()
    rows = [line for line in text.splitlines() if re.match(r"\| (?:\[.*\]\(\.\./tests/[^)]*\) )?\| ", line)]
    rows = [line for line in rows if line.count("|") == 7]
    counted = [
        tuple(map(int, found))
        for found in re.findall(r"^\| (?:calc|meas)[^|]*\| (\d+) \| (\d+) \| (\d+) \|", text, re.M)
    ]
    assert len(rows) == sum(number for number, _, _ in counted)
    assert sum("missed**" in line for line in rows) == sum(missed for _, _, missed in counted)
    assert all(number == within + missed for number, within, missed in counted)


def test_every_comparison_that_misses_its_reference_states_why_on_the_page_of_comparisons() -> None:
    text = PAGE.read_text()
    for case in CASES:
        part = text.partition(f"| [{case.source}](")[2].partition("\n| [")[0].partition("\n\n")[0]
        missed = "missed**" in part
        assert missed == (f"- **{case.source}**" in text)
        assert case.why or not missed


def test_a_changed_figure_on_the_comparison_page_is_detected() -> None:
    case = Case("t", "s", "tests/x.py", lambda: iter([Row("q", 2.0, 2.1, 0.01, "m")]), False, "y")
    page = made([(case, case.lines())])
    (row, line), *_ = case.lines()
    assert row.missed
    assert "**+5 %: missed**" in line
    assert stale(case, line) == []
    assert stale(case, line.replace("2.10", "2.11")) == [line]
    assert "| calculated by others | 1 | 0 | 1 | 5 %: q (s) |" in page


@pytest.mark.parametrize("run", RUNS, ids=lambda run: run.name)
def test_scipy_reproduces_the_swing_of_the_measured_crane_runs(run: Run) -> None:
    """Its misses are not misses of the computation: L a'' = -g sin a - x'' cos a over the same pieces."""
    state, most = [np.radians(run.start), 0.0], []
    for v, faster in pairwise(run.speeds):
        push = (faster - v) / EVERY

        def rate(_: float, y: list[float], push: float = push) -> list[float]:
            return [y[1], -(GRAVITY * np.sin(y[0]) + push * np.cos(y[0])) / run.wire]

        found = solve_ivp(rate, (0.0, EVERY), state, "DOP853", rtol=1e-10, atol=1e-12, max_step=0.01).y
        state, most = found[:, -1], [*most, *found[0]]
    forward, back = np.degrees([max(most), min(most)])
    ours = [row.ours for row in swung(run)]
    assert ours[:2] == pytest.approx([forward, back], abs=0.1)
    free = np.degrees(np.arccos(np.cos(state[0]) - run.wire * state[1] ** 2 / (2 * GRAVITY)))
    assert ours[2] == pytest.approx(free, abs=0.1)


def test_an_unknown_option_of_the_comparison_script_is_reported(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--chekc"]) == 2
    assert "--check" in capsys.readouterr().err
