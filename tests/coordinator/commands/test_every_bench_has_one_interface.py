"""Scripts of tests/bench: the same options, the same rows, and one sentence where a peer is not installed.

That each of them works is what `tests/bench/all.py --short` shows.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
BENCH = ROOT / "tests" / "bench"
SCRIPTS = sorted(path for path in BENCH.glob("*.py"))
ROOMS = ("kernel", "nodes", "coordinator", "recordings")
KEYS = ["name", "value", "unit", "peer", "peer_value", "ratio", "target", "met"]
ALL_HELPS = """
import contextlib, io, json, runpy, sys
helps = {}
for script in sys.argv[1:]:
    sys.argv, told = [script, "--help"], io.StringIO()
    with contextlib.redirect_stdout(told), contextlib.suppress(SystemExit):
        runpy.run_path(script, run_name="__main__")
    helps[script] = told.getvalue()
print(json.dumps(helps))
"""
FEW = """
import runpy, sys
sys.modules.update(dict.fromkeys(("xdevs", "simpy", "pypdevs"), None))
sys.argv = ["devs.py", "--json", "--short"]
runpy.run_path("devs.py", run_name="__main__")
"""
ROWS = """
from shared.rows import row
row("ours alone", 2.0, "s", at_most=3.0)
row("faster", 2.0, "s", "peer", 8.0, at_most=0.2)
row("as many", 9.0, "1/s", "peer", 9.0, at_least=0.9)
row("by itself", 2.0, "s", "peer", 8.0, at_most=1.0, absolute=True)
row("peer is missing", 2.0, "s", "peer", None, at_most=0.2)
"""
FAULTS = """
import json, sys
from all import fault
print(json.dumps([fault(line) for line in sys.argv[1:]]))
"""


def python(code: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(BENCH)!r})\n{code}", *arguments],
        cwd=BENCH,
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    )


@pytest.mark.large
def test_every_benchmark_script_takes_the_options_json_and_short() -> None:
    helps = json.loads(python(ALL_HELPS, *map(str, SCRIPTS)).stdout)
    for script in SCRIPTS:
        message = helps[str(script)]
        assert "--json" in message, script.name
        assert "--short" in message, script.name
        assert f"python tests/bench/{script.name} " in script.read_text().partition('"""\n\n')[0], script.name


def test_a_benchmark_row_has_its_eight_keys_and_compares_its_ratio_to_a_peer_engine_with_a_target() -> None:
    rows = [json.loads(line) for line in python(ROWS, "--json").stdout.splitlines()]
    assert all(list(row) == KEYS for row in rows)
    assert [tuple(row.values())[1:] for row in rows] == [
        (2.0, "s", None, None, None, 3.0, True),
        (2.0, "s", "peer", 8.0, 0.25, 0.2, False),
        (9.0, "1/s", "peer", 9.0, 1.0, 0.9, True),
        (2.0, "s", "peer", 8.0, 0.25, 1.0, False),
        (2.0, "s", "peer", None, None, 0.2, None),
    ]


def test_a_benchmark_that_returns_no_results_is_reported_by_name() -> None:
    good = {"name": "a", "value": 1.0, "unit": "s", "peer": "b", "peer_value": 2.0, "ratio": 0.5, "target": None}
    good["met"] = None
    bad = [
        "not JSON",
        json.dumps({**good, "median": 1.0}),
        json.dumps({key: good[key] for key in KEYS[:-1]}),
        json.dumps({**good, "value": None}),
        json.dumps({**good, "met": "yes"}),
        json.dumps({**good, "ratio": None}),
        json.dumps({**good, "peer": None}),
        f"{json.dumps(good)}\nnews",
        "",
    ]
    found = json.loads(python(FAULTS, json.dumps(good), *bad).stdout)
    assert found[0] == ""
    assert [message.partition(" (")[0].partition(":")[0] for message in found[1:]] == [
        *["line 1 is no row"] * 5,
        *["line 1"] * 2,
        "line 2 is no row",
        "no rows",
    ]


def test_a_peer_engine_that_is_not_installed_is_reported_in_one_sentence_without_a_figure() -> None:
    done = python(FEW)
    other = [row for row in map(json.loads, done.stdout.splitlines()) if row["peer"]]
    assert [(row["peer_value"], row["ratio"], row["met"]) for row in other] == [(None, None, None)] * 5
    assert [line.partition(" (")[0] for line in done.stderr.splitlines()] == [
        "xdevs is left out",
        "PythonPDEVS is left out",
        "SimPy is left out",
    ]


def test_every_script_named_on_a_page_exists() -> None:
    pages = [*ROOT.glob("*.md"), *(p for room in ROOMS for p in (ROOT / room).rglob("*.md"))]
    named = {script for page in pages for script in re.findall(r"tests/bench/[\w/]+\.py", page.read_text())}
    assert len(named) > 5
    assert {script for script in named if not (ROOT / script).is_file()} == set()
