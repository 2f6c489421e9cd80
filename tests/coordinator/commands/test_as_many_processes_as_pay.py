"""As many processes are taken as pay: the beginning of a run is tried with one, two, four ... on this machine."""

from collections.abc import Callable

import pytest
from heavylift.coordinator.commands.common import process_count
from heavylift.coordinator.run import RunObserver
from heavylift.kernel import ModelError
from heavylift.nodes.devs import Event

TICK_ns = 10**9  # an event each second of the run


class Machine:
    """A clock that only runs tell; an event takes `seconds[count]` of it with so many processes."""

    def __init__(self, seconds: dict[int, float], events: int = 10_000) -> None:
        self.seconds, self.events, self.now, self.tried = seconds, events, 0.0, list[int]()

    def perf_counter(self) -> float:
        return self.now

    def run(self, count: int, watch: RunObserver) -> None:
        self.tried.append(count)
        watch.waiting()
        for i in range(self.events):
            self.now += self.seconds[count]
            watch.event(Event((i + 1) * TICK_ns, 0, "clock", "tick", 0, "Tick", b""))
            watch.waiting()


@pytest.fixture
def on(monkeypatch: pytest.MonkeyPatch) -> Callable[[Machine], Machine]:
    def there(machine: Machine) -> Machine:
        monkeypatch.setattr(process_count, "time", machine)
        return machine

    return there


def test_the_option_processes_auto_takes_the_fastest_number_of_processes_and_prints_the_measured_times(on):
    machine = on(Machine({1: 0.25, 2: 0.15, 4: 0.1, 6: 0.2}))
    found = "1 process takes 1.25 s for the first 5 s of the run, 2 take 0.75 s, 4 take 0.50 s, 6 take longer"
    assert process_count.paying(machine.run, 8, most=6) == (4, found)
    assert machine.tried == [1, 2, 4, 6]


def test_the_option_processes_auto_ignores_a_speed_up_within_measurement_noise(on):
    machine = on(Machine({1: 0.25, 2: 0.24}))
    assert process_count.paying(machine.run, 8, most=2) == (
        1, "1 process takes 1.25 s for the first 5 s of the run, 2 take 1.20 s",
    )  # fmt: skip


def test_the_option_processes_auto_takes_one_process_for_a_run_shorter_than_a_second(on):
    machine = on(Machine({1: 0.25}, events=3))
    assert process_count.paying(machine.run, 8, most=4) == (1, "1 process takes 0.75 s for all of the run")
    assert machine.tried == [1]


def test_the_option_processes_auto_tries_no_more_processes_than_the_scene_has_models(on):
    machine = on(Machine({1: 0.25, 2: 0.15, 3: 0.1}))
    assert process_count.paying(machine.run, 3, most=64)[0] == 3
    assert machine.tried == [1, 2, 3]


def test_a_run_whose_models_send_no_messages_in_the_trial_run_gets_one_process_per_core(on):
    machine = on(Machine({}))

    def silent(count: int, watch: RunObserver) -> None:
        while True:
            watch.waiting()
            machine.now += 0.3

    assert process_count.paying(silent, 8, most=4) == (4, "its models work for 1 s before anything is said")


def test_the_option_processes_auto_ignores_a_failed_trial_run_since_the_recorded_run_reports_the_error(on):
    on(Machine({}))

    def failing(count: int, watch: RunObserver) -> None:
        raise ModelError("late message")

    assert process_count.paying(failing, 8, most=4) == (1, "the run fails")
