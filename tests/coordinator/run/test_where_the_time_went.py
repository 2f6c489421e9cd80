"""The budget of a run: its parts make up the whole, and the summary shows them."""

import re

from heavylift.coordinator.commands import app
from heavylift.coordinator.record import Budget, ClockedWork, clocked
from typer.testing import CliRunner


def test_the_reported_shares_of_wall_clock_time_sum_to_the_duration_of_the_run():
    """Four instants with the recording until then: 2 s of start, 5 s of rounds and kernel, 1 s of exit."""
    budget = Budget.of((10.0, 0.0), (12.5, 0.5), (18.0, 1.0), (19.25, 1.25), 3.0)
    assert budget == Budget(start=2.0, kernel=3.0, rounds=2.0, recording=1.25, exit=1.0)
    assert str(budget) == "start 2.00, kernel 3.00, rounds 2.00, recording 1.25, exit 1.00"


def test_the_reported_time_of_grant_rounds_is_never_negative():
    assert Budget.of((0.0, 0.0), (1.0, 0.0), (5.0, 2.0), (5.0, 2.0), 3.5).rounds == 0.0


def test_the_working_time_of_a_recorder_includes_calls_that_raise_an_error():
    class Work(ClockedWork):
        @clocked
        def fail(self):
            raise ValueError

    work = Work()
    for _ in range(2):
        before = work.spent_s
        try:
            work.fail()
        except ValueError:
            assert work.spent_s > before


def test_the_option_verbose_prints_the_wall_clock_seconds_of_each_part_of_a_run(tmp_path):
    message = (
        CliRunner().invoke(app, ["run", "lift", "--in-process", "--verbose", "-o", str(tmp_path / "lift.mcap")]).output
    )
    line = re.search(
        r"seconds: start (\S+), kernel (\S+), rounds \S+, recording (\S+), exit \S+; \d+ grants\n", message
    )
    assert line, message
    assert all(float(x) > 0.0 for x in line.groups())
