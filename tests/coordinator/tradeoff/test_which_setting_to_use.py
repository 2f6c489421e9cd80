"""The verdict on a table: the fastest setting that is right in all that was asked, and the next faster that fails."""

from dataclasses import replace

from heavylift.coordinator.tradeoff import front, judge, percent
from measured_rows import row

FINE = row("1 ms", 10.0, rope_tension=1e-5, swing=1e-5)
GOOD = row("5 ms", 2.0, rope_tension=4.2e-3, swing=1e-3)
SWINGS_WRONG = row("10 ms", 1.0, rope_tension=4.3e-3, swing=0.21)
COARSE = row("20 ms", 0.5, rope_tension=0.5, swing=0.4)
BLOWN = row("50 ms", 0.0, reason="step 0.05 s: too long", rope_tension=0.0)
TABLE = [BLOWN, COARSE, SWINGS_WRONG, GOOD, FINE]


def test_the_fastest_that_passes_is_used_and_the_slowest_of_the_faster_ones_is_what_fails_next():
    verdict = judge(TABLE, 0.02)
    assert (verdict.pick, verdict.next_faster) == (GOOD, SWINGS_WRONG)
    assert verdict.sentence == (
        "Use the setting rung, rk4 at 5 ms: 2 s to wait, 0 s of them to start, worst rope tension error 0.42 % "
        "(limit 2 %), swing 0.1 %, places within 0.1 mm."
    )
    assert verdict.more == "Next faster setting that fails: rung, rk4 at 10 ms, 1 s (swing 21 %)."


def test_times_that_differ_by_noise_are_equal_and_the_most_exact_of_them_is_used():
    alike = row("4 ms", 2.15, rope_tension=1e-3, swing=1e-3)
    verdict = judge([*TABLE, alike], 0.02)
    assert verdict.pick is alike
    assert verdict.more.startswith("1 more keep 2 % in a time equal within noise. ")
    slower = row("4 ms", 2.25, rope_tension=1e-3, swing=1e-3)
    assert judge([*TABLE, slower], 0.02).pick is GOOD


def test_what_one_waits_is_the_start_and_the_run():
    rich, poor = (replace(x, start_s=s) for x, s in ((FINE, 1.0), (GOOD, 20.0)))
    assert (rich.waits_s, poor.waits_s) == (11.0, 22.0)
    assert rich.speed == 100.0 / 11.0
    assert judge([rich, poor], 0.02).pick is rich


def test_one_wrong_quantity_is_enough_to_fail():
    assert judge([SWINGS_WRONG, FINE], 0.02).pick is FINE


def test_a_tighter_limit_asks_for_a_slower_setting():
    assert judge(TABLE, 1e-3).pick is FINE


def test_a_run_that_failed_is_never_used_nor_named_as_the_next():
    verdict = judge([BLOWN, FINE], 0.02)
    assert (verdict.pick, verdict.next_faster) == (FINE, None)
    assert verdict.more.endswith("No faster setting fails: a looser one may do.")


def test_where_nothing_passes_the_nearest_is_told():
    verdict = judge([BLOWN, COARSE, SWINGS_WRONG], 0.02)
    assert (verdict.pick, verdict.next_faster) == (None, None)
    assert verdict.sentence == (
        "None of 3 settings keeps 2 %; the nearest is the setting rung, rk4 at 10 ms: worst swing error 21 % "
        "(limit 2 %), rope tension 0.43 %, places within 0.1 mm."
    )


def test_the_front_holds_what_nothing_beats_in_both():
    beaten = row("4 ms", 3.0, rope_tension=5e-3, swing=1e-3)  # slower and worse than GOOD
    assert front([*TABLE, beaten]) == [FINE, GOOD, SWINGS_WRONG, COARSE]


def test_relative_numbers_read_as_people_write_them():
    assert [percent(x) for x in (0.0042, 0.01, 0.21, 1.5, float("inf"))] == [
        "0.42 %", "1 %", "21 %", "150 %", "never comes to it",
    ]  # fmt: skip
