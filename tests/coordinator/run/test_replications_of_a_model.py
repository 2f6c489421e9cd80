"""A model for many seeds: means as queueing theory says, the same on any executor, faults told by replication."""

from __future__ import annotations

import ast
import json
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from math import factorial, isnan, sqrt
from multiprocessing import get_context
from pathlib import Path
from random import Random

import pytest
from command import finish
from heavylift import replicate
from heavylift.coordinator.commands import app
from heavylift.coordinator.run import Replications, numbers, run_models
from heavylift.kernel import ModelError, ProtocolError
from heavylift.nodes.devs import Atomic, Coupled, Message
from heavylift.nodes.zoo import bouncing_ball, multi_server_queue
from typer.testing import CliRunner

MMC = "heavylift.nodes.zoo.multi_server_queue:mmc"


def in_theory(c: int, arrivals: float, service: float, again: float) -> tuple[float, float]:
    """Mean number and sojourn time [s] of an M/M/c with feedback (Jackson 1957, Erlang C, Little)."""
    a = arrivals / (1 - again) / service
    waits = a**c / factorial(c) / (1 - a / c)
    waits /= sum(a**k / factorial(k) for k in range(c)) + waits
    length = a + waits * a / c / (1 - a / c)
    return length, length / arrivals


@pytest.mark.parametrize("parameters", [(3, 2.0, 1.2, 0.25), (1, 0.5, 2.0, 0.5)])
def test_queue_lengths_of_a_jackson_network_agree_with_theory(parameters: tuple[int, float, float, float]) -> None:
    with ThreadPoolExecutor(1) as executor:
        found = replicate(f"{MMC}{parameters}", 6, 5, until=400.0, executor=executor).estimates
    length, stay = in_theory(*parameters)
    assert abs(found["net.station.length"].mean - length) < 2 * found["net.station.length"].half < 0.8 * length
    assert abs(found["net.station.stay"].mean - stay) < 2 * found["net.station.stay"].half < 0.8 * stay


def test_replications_do_not_depend_on_the_executor_or_the_number_of_seeds() -> None:
    with ThreadPoolExecutor(2) as threads:
        some = replicate(MMC, 3, 7, until=20.0, executor=threads)
        other = replicate(MMC, 3, 8, until=20.0, executor=threads)
    assert replicate(MMC, 2, 7, until=20.0, workers=1).values == {k: x[:2] for k, x in some.values.items()}
    assert not {*some.seeds} & {*other.seeds}


@pytest.mark.filterwarnings("ignore:.*fork")
def test_a_process_forked_after_a_run_reports_that_it_cannot_simulate() -> None:
    run_models(MMC, 1.0, in_process=True)
    with (
        ProcessPoolExecutor(1, mp_context=get_context("fork")) as forks,
        pytest.raises(ProtocolError, match=r"forked from one that has run models.*get_context\('spawn'\)"),
    ):
        forks.submit(run_models, MMC, 1.0, in_process=True).result()


@pytest.mark.parametrize("seed", range(12))
def test_replications_in_the_flat_simulator_equal_runs_over_the_protocol(seed: int) -> None:
    """Random networks, horizons and ends by a message; every number of every result is equal."""
    draw = Random(seed)
    servers, arrivals, again = draw.randint(1, 4), draw.uniform(0.5, 2.0), draw.uniform(0.0, 0.5)
    until = draw.choice([0.0, draw.uniform(0.0, 25.0), draw.uniform(0.0, 25.0)])
    stop = draw.choice(["", "station.left", "source.job"])
    reference = f"{MMC}({servers}, {arrivals!r}, 1.2, {again!r})"
    with ThreadPoolExecutor(1) as executor:
        found = replicate(reference, 2, seed, until=until, stop=stop, executor=executor)
    for n, own in enumerate(found.seeds):
        run = run_models(f"{reference[:-1]}, seed={own})", until, in_process=True, stop=stop)
        assert {name: repr(x[n]) for name, x in found.values.items()} == {
            name: repr(x) for path, result in run.results.items() for name, x in numbers(path, result)
        }


def test_the_confidence_interval_uses_students_t_distribution() -> None:
    found = Replications([1, 2, 3], {"a.x": [1.0, 2.0, 3.0], "a.y": [1.0, float("nan"), 1.0]}).estimates
    assert found["a.x"].half == pytest.approx(4.302652729911275 / sqrt(3), rel=1e-9)
    assert (found["a.x"].mean, found["a.x"].deviation) == (2.0, 1.0)
    assert isnan(found["a.y"].mean)
    alone = Replications([1], {"a.x": [4.0]}).estimates["a.x"]
    assert (alone.mean, isnan(alone.half)) == (4.0, True)


def test_the_replication_command_reports_means_and_the_values_of_each_replication(tmp_path: Path) -> None:
    asked = ("devs", MMC, "--until", "20s", "--json")
    message = json.loads(finish(tmp_path, *asked, "--replications", "2", "--processes", "1", "--seed", "7")[1])
    with ThreadPoolExecutor(1) as executor:
        here = replicate(MMC, 2, 7, until=20.0, executor=executor)
    assert (message["seeds"], message["values"]) == (here.seeds, here.values)
    once = json.loads(finish(tmp_path, *asked, "--in-process", "--seed", str(here.seeds[1]))[1])
    result = once["results"]["net.station"]
    assert {f"net.station.{name}": x for name, x in result.items()} == {k: x[1] for k, x in here.values.items()}


class Drawn(Message):
    x: float


class Drawing(Atomic):
    def __init__(self, name: str, seed: int) -> None:
        super().__init__(name)
        self.seed = seed

    def result(self) -> Drawn:
        return Drawn(1 / (self.seed % 2))


def drawing(seed: int) -> Coupled:
    model = Coupled("top")
    model.add(Drawing("even" if Random(seed).random() < 0.5 else "odd", seed | 1))
    return model


def failing(seed: int) -> Coupled:
    model = Coupled("top")
    model.add(Drawing("one", seed))
    return model


@pytest.mark.parametrize(
    ("build", "sentence"),
    [
        (drawing, r"^replication \d+ \(seed \d+\): top\.\w+\.x is a result of only some replications; "),
        (failing, r"^replication \d+, .*failing\(seed=\d+\): top.one at \(1 s, 0\): result\(\) raised ZeroDivision"),
        ("heavylift.nodes.zoo.token_ring:ring(3, 1, 5)", r"ring\(\) takes no seed, so all runs would be identical; "),
        (f"{MMC}(seed=4)", r"the seed is given twice; leave it out of the arguments$"),
    ],
)
def test_models_that_cannot_be_replicated_are_reported(build: object, sentence: str) -> None:
    with ThreadPoolExecutor(1) as executor, pytest.raises(ModelError, match=sentence):
        replicate(build, 6, until=1.0, executor=executor)  # type: ignore[arg-type]


@pytest.mark.parametrize("more", ["-o x.mcap", "--external station", "--place station=a", "--in-process"])
def test_options_that_cannot_be_combined_with_replications_are_refused(more: str) -> None:
    message = CliRunner().invoke(app, ["devs", MMC, "--until", "2s", "--replications", "2", *more.split()])
    assert (message.exit_code, "leave out" in message.output) == (2, True)


@pytest.mark.parametrize(
    ("option", "sentence"),
    [
        ("--until -5s", "--until -5s: a time must be zero or more"),
        ("--replications 0", "0 replications, confidence 0.95: give one"),
    ],
)
def test_an_invalid_number_of_replications_is_refused(option: str, sentence: str) -> None:
    message = CliRunner().invoke(app, ["devs", MMC, *option.split()])
    assert (message.exit_code, str(message.exception)[: len(sentence)]) == (1, sentence)


@pytest.mark.parametrize(("module", "most"), [(multi_server_queue, 40), (bouncing_ball, 35)])
def test_the_code_of_each_queueing_example_has_at_most_the_stated_number_of_lines(module: object, most: int) -> None:
    """Lines of code, without docstrings and blank lines."""
    text = Path(str(module.__file__)).read_text()  # type: ignore[attr-defined]
    documented = set[int]()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node):
            documented |= {*range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1)}
    code = [n for n, line in enumerate(text.splitlines(), 1) if line.strip() and n not in documented]
    assert len(code) <= most
