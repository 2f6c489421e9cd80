"""Stations beside closed forms of queueing theory: Erlang, Pollaczek and Khinchine, Cobham, Jackson, machine repair.

Each figure is the mean of independent replications; theory lies within WIDTH standard errors of it.
"""

from collections.abc import Callable
from math import factorial, sqrt
from statistics import fmean, stdev

import pytest
from heavylift.nodes.devs import Coupled, Simulator, seconds
from heavylift.nodes.queueing import (
    Branch,
    Delay,
    Erlang,
    Exponential,
    Failures,
    Fixed,
    LogNormal,
    Monitor,
    Resource,
    Server,
    Sink,
    Source,
)

REPLICATIONS, UNTIL = 10, 4000.0  # [s]
WIDTH = 3.5  # standard errors: one figure in 2000 lies outside by chance, and seeds are fixed
Figures = dict[str, float]


def run(build: Callable[[int], Coupled], seed: int) -> dict[str, object]:
    """Results by path of one replication."""
    simulator = Simulator(build(seed))
    simulator.start()
    simulator.run(seconds(UNTIL))
    return dict(simulator.results(seconds(UNTIL)))


def check(build: Callable[[int], Coupled], expected: dict[str, float]) -> None:
    """Means over replications agree with theory; `expected` by path.field."""
    runs = [run(build, seed) for seed in range(1, REPLICATIONS + 1)]
    for name, value in expected.items():
        path, _, field = name.rpartition(".")
        values = [getattr(results[path], field) for results in runs]
        assert abs(fmean(values) - value) <= WIDTH * stdev(values) / sqrt(REPLICATIONS), f"{name}: {fmean(values)}"


def line(source: Source, *stations: object) -> Coupled:
    """A source, servers one after the other, and a sink."""
    net = Coupled("net")
    before = net.add(source).out
    for station in stations:
        net.connect(before, net.add(station).into)  # type: ignore[attr-defined,type-var]
        before = getattr(station, "done", None) or station.out  # type: ignore[attr-defined]
    net.connect(before, net.add(Sink("sink")).into)
    return net


def erlang_c(c: int, load: float) -> float:
    """Probability that an arrival waits in M/M/c."""
    last = load**c / factorial(c) * c / (c - load)
    return last / (sum(load**n / factorial(n) for n in range(c)) + last)


@pytest.mark.parametrize(("c", "rate"), [(1, 0.7), (3, 2.1)])
def test_waiting_times_of_several_servers_agree_with_erlang_c(c: int, rate: float) -> None:
    wait = erlang_c(c, rate) / (c - rate)
    check(
        lambda seed: line(
            Source("source", Exponential(1 / rate), seed=seed), Server("server", Exponential(1.0), c, seed=seed)
        ),
        {"net.server.wait": wait, "net.server.line": rate * wait, "net.server.busy": rate, "net.sink.mean": wait + 1},
    )


def test_waiting_times_of_one_server_agree_with_pollaczek_and_khinchine() -> None:
    rate, mean, deviation = 0.6, 1.0, 1.5
    wait = rate * (mean**2 + deviation**2) / 2 / (1 - rate * mean)
    check(
        lambda seed: line(
            Source("source", Exponential(1 / rate), seed=seed), Server("server", LogNormal(mean, deviation), seed=seed)
        ),
        {"net.server.wait": wait},
    )


def by_priority(preemptive: bool) -> Callable[[int], Coupled]:
    def build(seed: int) -> Coupled:
        net = Coupled("net")
        server = net.add(Server("server", Exponential(1.0), 1, "priority", preemptive=preemptive, seed=seed))
        for n, rate in enumerate((0.3, 0.4)):
            weights = (1.0,) if n == 0 else (0.0, 1.0)
            source = net.add(Source(f"source-{n}", Exponential(1 / rate), str(n), weights, seed=seed))
            net.connect(source.out, server.into)
        for n in range(2):
            kind = net.add(OfKind(f"kind-{n}", str(n)))
            net.connect(server.done, kind.into)
        return net

    return build


class OfKind(Sink):
    """Measures entities of one kind only."""

    def __init__(self, name: str, kind: str) -> None:
        super().__init__(name)
        self.kind = kind

    def external(self, e: int, x: object) -> None:
        for entity in x[self.into]:  # type: ignore[index]
            if entity.kind == self.kind:
                self.times.add((self.ns - entity.born) / 1e9)


def test_waiting_times_with_priorities_agree_with_cobham() -> None:
    rest, first, both = 0.7, 1 - 0.3, 1 - 0.7
    check(
        by_priority(preemptive=False),
        {"net.kind-0.mean": 1 + rest / first, "net.kind-1.mean": 1 + rest / first / both},
    )


def test_preemption_makes_waiting_times_of_the_first_priority_independent_of_the_second() -> None:
    first, both = 1 - 0.3, 1 - 0.7
    check(
        by_priority(preemptive=True),
        {"net.kind-0.mean": 1 / first, "net.kind-1.mean": 1 / first + 0.7 / first / both},
    )


def test_the_loss_of_a_full_queue_agrees_with_theory() -> None:
    load, places = 0.8, 4  # M/M/1/K with K = 4 in the system
    lost = (1 - load) * load**places / (1 - load ** (places + 1))

    def build(seed: int) -> Coupled:
        net = line(
            Source("source", Exponential(1 / load), seed=seed),
            Server("server", Exponential(1.0), capacity=places - 1, seed=seed),
        )
        net.connect(net.children["server"].ports["lost"], net.add(Sink("balked")).into)
        return net

    runs = [run(build, seed) for seed in range(1, REPLICATIONS + 1)]
    shares = [r["net.balked"].count / r["net.source"].sent for r in runs]  # type: ignore[attr-defined]
    assert abs(fmean(shares) - lost) <= WIDTH * stdev(shares) / sqrt(REPLICATIONS)


def test_the_mean_number_of_machines_under_repair_agrees_with_queueing_theory() -> None:
    machines, repairers, up, down = 6, 2, 10.0, 4.0
    terms = [1.0]
    for n in range(machines):
        terms.append(terms[-1] * (machines - n) / up * down / min(n + 1, repairers))
    broken = sum(n * p for n, p in enumerate(terms)) / sum(terms)

    def build(seed: int) -> Coupled:
        net = Coupled("net")
        source = net.add(Source("source", Fixed(0.0), most=machines, seed=seed))
        working = net.add(Delay("working", Exponential(up), seed))
        crew = net.add(Server("crew", Exponential(down), repairers, seed=seed))
        monitor = net.add(Monitor("broken"))
        for a, b in (
            (source.out, working.into), (working.out, crew.into), (crew.done, working.into),
            (working.out, monitor.enter), (crew.done, monitor.leave),
        ):  # fmt: skip
            net.connect(a, b)
        return net

    check(build, {"net.broken.number": broken})


def test_the_availability_of_a_machine_with_failures_agrees_with_the_formula_for_mean_times() -> None:
    def build(seed: int) -> Coupled:
        failures = Failures(Exponential(50.0), Erlang(3, 10.0))
        return line(
            Source("source", Exponential(2.0), seed=seed),
            Server("server", Exponential(1.0), 3, failures=failures, seed=seed),
        )

    check(build, {"net.server.available": 3 * 50 / 60})


def test_the_joint_distribution_of_a_jackson_network_is_the_product_of_its_queue_distributions() -> None:
    rate, again = 0.4, 0.25
    first = rate / (1 - again)

    def build(seed: int) -> Coupled:
        net = Coupled("net")
        source, sink = net.add(Source("source", Exponential(1 / rate), seed=seed)), net.add(Sink("sink"))
        a, b = (net.add(Server(name, Exponential(1.0), seed=seed)) for name in "ab")
        branch = net.add(Branch("branch", (1 - again, again), seed))
        for x, y in (
            (source.out, a.into), (a.done, b.into), (b.done, branch.into),
            (branch.ports["out0"], sink.into), (branch.ports["out1"], a.into),
        ):  # fmt: skip
            net.connect(x, y)
        return net

    check(build, {"net.sink.mean": 2 * first / (1 - first) / rate})


def test_a_resource_model_occupied_for_a_service_time_acts_like_a_server_model() -> None:
    def build(seed: int) -> Coupled:
        net = Coupled("net")
        source = net.add(Source("source", Exponential(0.5), seed=seed))
        crane, work = net.add(Resource("crane", 3)), net.add(Delay("work", Exponential(1.0), seed))
        for a, b in ((source.out, crane.request), (crane.seized, work.into), (work.out, crane.release)):
            net.connect(a, b)
        return net

    check(build, {"net.crane.wait": erlang_c(3, 2.0) / (3 - 2.0), "net.crane.used": 2.0})
