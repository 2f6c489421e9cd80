"""Parts of queueing networks: order of service, pulling, joining, distributions, checkpoints, refusals."""

from collections.abc import Callable
from random import Random

import numpy as np
import pytest
from heavylift.kernel import ModelError
from heavylift.nodes import drive
from heavylift.nodes.devs import Atomic, Coupled, Simulator, seconds
from heavylift.nodes.queueing import (
    Branch,
    Delay,
    Demand,
    Distribution,
    Empirical,
    Entity,
    Erlang,
    Exponential,
    Failures,
    Fixed,
    Join,
    LogNormal,
    Pert,
    Queue,
    Resource,
    Server,
    Sink,
    Source,
    Triangular,
    Uniform,
)
from scipy import stats

UNTIL = seconds(100)
DRAWS, DOUBT = 2000, 1e-3  # draws are refused below this probability (Kolmogorov and Smirnov)


def entities(*priorities: int) -> list[tuple[int, str, Entity]]:
    """One second apart, from 0 on."""
    return [(seconds(n), "into", Entity(n, priority=p)) for n, p in enumerate(priorities)]


def left(model: Atomic, inputs: list[tuple[int, str, Entity]], port: str = "done") -> list[tuple[float, int]]:
    """When [s] which entities leave by a port."""
    return [(tag.t / 1e9, e.number) for tag, out, e in drive(model, inputs, UNTIL) if out == port]  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("discipline", "preemptive", "expected"),
    [
        ("first in, first out", False, [(10, 0), (20, 1), (30, 2), (40, 3)]),
        ("last in, first out", False, [(10, 0), (20, 3), (30, 2), (40, 1)]),
        ("priority", False, [(10, 0), (20, 2), (30, 3), (40, 1)]),
        ("priority", True, [(12, 2), (20, 0), (30, 3), (40, 1)]),
    ],
)
def test_a_queue_serves_its_entities_in_the_order_of_its_discipline(
    discipline: str, preemptive: bool, expected: list[tuple[float, int]]
) -> None:
    server = Server("server", Fixed(10.0), 1, discipline, preemptive=preemptive)
    assert left(server, entities(1, 2, 0, 1)) == expected


def test_a_machine_in_a_queueing_network_that_fails_resumes_its_job_when_it_is_repaired() -> None:
    server = Server("server", Fixed(10.0), failures=Failures(Fixed(4.0), Fixed(3.0)))
    assert left(server, entities(0))[:1] == [(16.0, 0)]  # down from 4 to 7 s and from 11 to 14 s


def test_an_entity_that_arrives_at_a_full_queue_of_a_queueing_network_is_lost() -> None:
    server = Server("server", Fixed(10.0), capacity=1)
    assert left(server, entities(0, 0, 0), "lost") == [(2.0, 2)]
    assert left(server, entities(0, 0, 0)) == [(10.0, 0), (20.0, 1)]


def test_a_queue_that_feeds_a_server_on_demand_acts_like_the_queue_inside_a_server() -> None:
    def build(pulling: bool) -> Coupled:
        net = Coupled("net")
        source, sink = net.add(Source("source", Exponential(1.1))), net.add(Sink("sink"))
        server = net.add(Server("server", Exponential(2.0), 2, pulls=pulling))
        net.connect(server.done, sink.into)
        if not pulling:
            net.connect(source.out, server.into)
            return net
        queue = net.add(Queue("queue"))
        for a, b in ((source.out, queue.into), (queue.out, server.into), (server.ready, queue.demand)):
            net.connect(a, b)
        return net

    def results(pulling: bool) -> dict[str, object]:
        simulator = Simulator(build(pulling))
        simulator.start()
        simulator.run(seconds(3000))
        return dict(simulator.results())

    pulled, pushed = results(True), results(False)
    assert pulled["net.sink"] == pushed["net.sink"]
    assert pulled["net.queue"].wait == pytest.approx(pushed["net.server"].wait, rel=1e-12)  # type: ignore[attr-defined]


def test_a_queue_holds_entities_without_demand_and_loses_entities_beyond_its_capacity() -> None:
    queue = Queue("queue", "priority", capacity=2)
    inputs = [*entities(1, 0, 0), (seconds(9), "demand", Demand(2))]
    assert left(queue, inputs, "lost") == [(2.0, 2)]  # type: ignore[arg-type]
    assert left(queue, inputs, "out") == [(9.0, 1), (9.0, 0)]  # type: ignore[arg-type]


def test_a_join_of_a_queueing_network_waits_for_all_parts_of_an_entity() -> None:
    inputs = [(seconds(t), "into", Entity(n)) for t, n in ((1, 7), (2, 8), (3, 7), (4, 7), (5, 8), (6, 8))]
    assert left(Join("join", 3), inputs, "out") == [(4.0, 7), (6.0, 8)]


def test_a_branch_model_of_a_queueing_network_chooses_output_ports_by_their_weights() -> None:
    branch = Branch("branch", (1.0, 0.0, 3.0))
    said = drive(branch, [(n, "into", Entity(n)) for n in range(DRAWS)])
    ports = [port for _, port, _ in said]
    assert ports.count("out1") == 0
    assert ports.count("out0") == pytest.approx(DRAWS / 4, rel=0.1)


DISTRIBUTIONS: list[tuple[Distribution, Callable[[np.ndarray], np.ndarray]]] = [
    (Uniform(2.0, 5.0), stats.uniform(2.0, 3.0).cdf),
    (Exponential(3.0), stats.expon(scale=3.0).cdf),
    (Erlang(3, 6.0), stats.gamma(3, scale=2.0).cdf),
    (Triangular(1.0, 2.0, 6.0), stats.triang(0.2, 1.0, 5.0).cdf),
    (Pert(1.0, 2.0, 6.0), stats.beta(1.8, 4.2, 1.0, 5.0).cdf),
    (LogNormal(30.0, 10.0), stats.lognorm(0.3245928, scale=28.4604989).cdf),
]


@pytest.mark.parametrize(("distribution", "cdf"), DISTRIBUTIONS, ids=lambda x: type(x).__name__)
def test_random_draws_have_the_distributions_of_scipy(
    distribution: Distribution, cdf: Callable[[np.ndarray], np.ndarray]
) -> None:
    random = Random(1)
    draws = np.array([distribution.draw(random) for _ in range(DRAWS)])
    assert stats.kstest(draws, cdf).pvalue > DOUBT
    assert draws.mean() == pytest.approx(distribution.mean, abs=4 * draws.std() / np.sqrt(DRAWS))


def test_values_of_an_empirical_table_are_drawn_by_their_weights() -> None:
    table, random = Empirical((1.0, 2.0, 5.0), (1.0, 0.0, 1.0)), Random(1)
    draws = [table.draw(random) for _ in range(DRAWS)]
    assert ({*draws}, table.mean) == ({1.0, 5.0}, 3.0)


def test_a_network_of_models_restored_from_a_snapshot_repeats_the_run() -> None:
    net = Coupled("net")
    source, sink = net.add(Source("source", Erlang(2, 1.0), weights=(0.2, 0.8))), net.add(Sink("sink"))
    failures = Failures(Exponential(20.0), Exponential(5.0))
    server = net.add(Server("server", LogNormal(2.4, 1.2), 3, "priority", preemptive=True, failures=failures))
    delay, crane = net.add(Delay("delay", Pert(1.0, 2.0, 3.0))), net.add(Resource("crane", 4))
    for a, b in (
        (source.out, server.into), (server.done, crane.request), (crane.seized, delay.into), (delay.out, crane.release),
        (delay.out, sink.into),
    ):  # fmt: skip
        net.connect(a, b)
    simulator = Simulator(net)
    simulator.start()
    simulator.run(seconds(300))
    kept = simulator.snapshot()
    simulator.run(seconds(600))
    expected = simulator.results()
    simulator.restore(kept)
    simulator.run(seconds(600))
    assert simulator.results() == expected


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Fixed(-1.0), "Fixed: time is -1.0; give a finite number of seconds >= 0"),
        (lambda: Exponential(float("nan")), "Exponential: mean is nan; give a finite number of seconds >= 0"),
        (lambda: Triangular(3.0, 2.0, 5.0), "Triangular: 3, 2, 5 s are not in ascending order; sort them"),
        (lambda: LogNormal(0.0, 1.0), "LogNormal: mean is 0; it must be positive"),
        (lambda: Erlang(0, 1.0), "Erlang: 0 phases; give a whole number of at least 1"),
        (
            lambda: Empirical((1.0,), (0.0,)),
            "Empirical: 1 times and 1 weights; give one weight for each time, at least one above zero",
        ),
        (lambda: Server("crew", Fixed(1.0), 0), "crew: 0 units; give a whole number of at least 1"),
        (
            lambda: Server("crew", Fixed(1.0), preemptive=True),
            "crew: only the discipline 'priority' can be preemptive, not",
        ),
        (lambda: Queue("line", capacity=-1), "line: capacity -1; give a whole number >= 0, or None for no bound"),
        (lambda: Branch("fork", (0.0,)), r"fork: weights \(0.0,\); give numbers >= 0, one of them above zero"),
        (
            lambda: drive(Queue("line", "fifo"), []),
            "there is no discipline 'fifo'; choose one of first in, first out, last",
        ),
        (
            lambda: drive(Resource("crane", 1), [(0, "release", Entity(3))]),
            "entity 3 releases a unit of crane that it has not seized",
        ),
    ],
)
def test_invalid_models_of_a_queueing_network_are_refused(make: Callable[[], object], sentence: str) -> None:
    with pytest.raises(ModelError, match=sentence):
        make()
