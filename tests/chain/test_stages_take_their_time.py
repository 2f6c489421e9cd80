"""Every crane move ends at the nanosecond of its trapezoidal profile: t = d/v + v/a, or 2 sqrt(d/a)."""

import pytest
from chain import CLOSED_FORMS, play
from heavylift.nodes.devs import seconds
from heavylift.recordings import Recording

FORM = CLOSED_FORMS["C24"]["expected"]
PLACE = 1e-9  # [m] that a winch may stand beside its length: round-off, the kernel computes it from the same trapezoid

CRANE = """\
heavylift: 1
name: stages
samples: 0.1 Hz
block:
  mass: 300 t
  size: [20 m, 16 m, 8 m]
  at: [40 m, 30 m, 6 m]
  supports: {height: 2 m, at: [[-8 m, -6 m], [8 m, -6 m], [-8 m, 6 m], [8 m, 6 m]]}
  lugs: {P1: [-8 m, -6 m, 4.3 m], P2: [-4 m, -6 m, 4.3 m]}
cranes:
  crane: {type: goliath-900, at: 40 m, upper trolley: 30 m, lower trolley: 60 m, ramp: 0.05 m/s2}
rig:
  loaders:                                 # empty: they hang on their hooks
    loader-1: {hook: crane H1, sling: 10 m, rope: 60 m}
    loader-2: {hook: crane H2, sling: 10 m, rope: 60 m}
    loader-3: {hook: crane H3, sling: 10 m, rope: 60 m}
actions:
  - crane H1: hoist 3 m/min ramp 0.02 m/s2 by 30 m
    crane H2: hoist 2 m/min ramp 0.02 m/s2 by 20 m
    trolleys: traverse 20 m/min by 40 m
    crane: travel 30 m/min by 250 m
  - crane H1: lower 3 m/min ramp 0.02 m/s2 by 30 m
    crane H2: lower 0.3 m/min ramp 0.005 m/s2 by 0.2 m
"""

MOVES = [  # closed form, actuator, its how-manieth order, where it stands then [m]
    ("hoist 30 m at 3 m/min, a=0.02", "crane.H1", 0, 30.0),
    ("turn 90 deg by hoisting 20 m at 2 m/min", "crane.H2", 0, 40.0),
    ("trolley 40 m at 20 m/min, a=0.05", "crane.upper-slide.drive", 0, 70.0),
    ("trolley 40 m at 20 m/min, a=0.05", "crane.lower-slide.drive", 0, 100.0),
    ("gantry 250 m at 30 m/min, a=0.05", "crane.gantry.drive", 0, 290.0),
    ("lower 30 m at 3 m/min", "crane.H1", 1, 60.0),
    ("inching: 0.2 m at 0.3 m/min, a=0.005", "crane.H2", 1, 40.2),
]


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """Twenty minutes of an empty crane."""
    return play(tmp_path_factory.mktemp("stages"), CRANE)


@pytest.mark.parametrize(("form", "actuator", "order", "stands"), MOVES)
def test_a_move_takes_the_time_of_its_trapezoidal_speed_profile(
    recording: Recording, form: str, actuator: str, order: int, stands: float
) -> None:
    events = [e for e in recording.events() if e.type in ("Order", "Done") and e.value["actor"] == actuator]
    begun = [e for e in events if e.type == "Order" and e.value["what"]["type"] == "motion"][order]
    done = [e for e in events if e.type == "Done"][order]

    assert done.value["id"] == begun.value["id"]
    assert done.t_ns - begun.t_ns == seconds(FORM[form])
    assert done.value["position"] == pytest.approx(stands, abs=PLACE)


def test_all_stage_times_agree_with_closed_forms_and_the_run_ends_with_the_last_move(
    recording: Recording,
) -> None:
    assert {form for form, *_ in MOVES} == set(FORM)
    last = recording.events()[-1]
    assert (last.type, last.t_ns) == ("Finished", seconds(2 * 602.5))


def test_rope_lengths_at_the_end_of_a_run_equal_the_ordered_lengths(recording: Recording) -> None:
    length, rate = recording.signal("rope/length"), recording.signal("rope/length_rate")
    at = [length.names.index(name) for name in ("crane.H1", "crane.H2", "crane.H3")]
    assert length.values[-1, at] == pytest.approx([60.0, 40.2, 60.0], abs=PLACE)
    assert rate.values[-1, at] == pytest.approx(0.0, abs=PLACE)
