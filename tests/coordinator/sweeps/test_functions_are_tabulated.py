"""`heavylift.tabulate` over systems and DEVS models, and response functions as columns of a study."""

from concurrent.futures import ThreadPoolExecutor
from math import pi, sqrt

import own_functions as own
import pytest
from heavylift import load, replicate, simulate, sweep, tabulate
from heavylift.coordinator.commands import app
from heavylift.kernel import HeavyliftError
from pyarrow import parquet
from typer.testing import CliRunner

G = 9.80665
SMALL = 1e-4  # relative: crossings between samples of 10 ms, means over several periods of 2 s


@pytest.fixture
def threads():
    with ThreadPoolExecutor(2) as pool:
        yield pool


def test_a_system_is_simulated_for_all_combinations_of_parameter_values(threads):
    rows = tabulate(own.pendulum, {"length": [0.5, 1.0], "angle": [1e-3, 2e-3]}, executor=threads)
    assert [(r["length"], r["angle"]) for r in rows] == [(0.5, 1e-3), (0.5, 2e-3), (1.0, 1e-3), (1.0, 2e-3)]
    for row in rows:
        assert row["period"] == pytest.approx(2.0 * pi * sqrt(row["length"] / G), abs=0.01 / 4)
    assert rows[1]["end"] == pytest.approx(2.0 * rows[0]["end"], rel=SMALL)


def test_a_study_varies_parameters_of_a_devs_model_and_stores_its_results_as_columns(threads):
    reference = "heavylift.nodes.zoo.multi_server_queue:mmc(seed=5)"
    rows = tabulate(reference, {"c": [2, 3]}, executor=threads, until=200.0)
    for row in rows:
        model = f"heavylift.nodes.zoo.multi_server_queue:mmc(c={row['c']})"
        assert {*row} - {"c"} == {*replicate(model, 1, 1, until=20.0, executor=threads).values}
    columns = {*rows[0]} - {"c"}
    assert any(rows[0][name] != rows[1][name] for name in columns)


def test_tabulating_a_function_in_a_pool_gives_the_same_table(threads):
    values = {"length": [0.7], "angle": [1e-3]}
    assert tabulate(own.pendulum, values, workers=1) == tabulate(own.pendulum, values, executor=threads)


def test_results_of_response_functions_are_columns_of_a_study(tmp_path, threads):
    reference = f"{own.__file__}:swing"
    study = sweep("pendulum", ["end={1 s, 2 s}"], into=tmp_path / "ends", executor=threads, responses={"a": reference})
    for n, end in enumerate((1.0, 2.0)):
        scene = load("pendulum", f"end={end:g} s")
        assert study.rows[n]["response/a"] == own.swing(simulate(scene))


def test_a_command_line_option_names_the_response_functions_of_a_study(tmp_path):
    words = ["sweep", "pendulum", "--vary", "end={1 s, 2 s}", "-o", str(tmp_path / "ends"), "--workers", "1"]
    given = [f"swing={own.__file__}:swing", f"twice={own.__file__}:scaled(by=2)"]
    found = CliRunner().invoke(app, [*words, *(x for text in given for x in ("--response", text))])
    assert found.exit_code == 0, found.output
    table = parquet.read_table(tmp_path / "ends" / "rows.parquet").to_pandas()
    for n, end in enumerate((1.0, 2.0)):
        want = own.swing(simulate(load("pendulum", f"end={end:g} s")))
        assert list(table.loc[n, ["response/swing", "response/twice"]]) == [want, 2.0 * want]
    assert "<!-- swing -->" in (tmp_path / "ends" / "summary.html").read_text()
    again = CliRunner().invoke(app, words)
    assert "holds another study (responses ['swing=" in str(again.exception)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("swing", "--response 'swing': give NAME=FUNCTION, each name once"),
        ("1=own.py:swing", "--response '1=own.py:swing': give NAME=FUNCTION"),
        (f"a={own.__file__}:absent", "has no function absent"),
        ("a=none.py:swing", "there is no such file"),
    ],
)
def test_a_response_function_that_cannot_be_called_is_refused_before_the_first_run(text, sentence, tmp_path):
    found = CliRunner().invoke(app, ["sweep", "pendulum", "--response", text, "-o", str(tmp_path / "x")])
    assert sentence in str(found.exception)
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((own.fails, {"x": [1.0, 0.0]}), "raised ZeroDivisionError"),
        ((own.text, {"x": [1.0]}), "returns something other than numbers"),
        ((own.huge, {"result": [1.0]}), "returns something other than numbers"),
        ((own.pendulum, {"length": 1.0}), "give a list of values for each argument"),
        (("no.such:function", {"x": [1.0]}), "no module no"),
        ((f"{own.__file__}:absent", {"x": [1.0]}), "has no function absent"),
    ],
)
def test_tabulating_an_invalid_function_is_reported_in_one_sentence(arguments, sentence, threads):
    with pytest.raises(HeavyliftError) as error:
        tabulate(*arguments, executor=threads)
    assert sentence in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(("name", "shown"), [("words", "'much'"), ("endless", "inf"), ("huge", f"1{'0' * 59}")])
def test_a_response_function_that_returns_no_finite_number_is_reported_in_its_study_row(name, shown, tmp_path, threads):
    reference = f"{own.__file__}:{name}"
    study = sweep("pendulum", ["end={1 s}"], into=tmp_path / "x", executor=threads, responses={"w": reference})
    assert study.rows[0]["status"] == "failed"
    assert f"the response w is {shown}, not a finite number" in study.rows[0]["sentence"]
