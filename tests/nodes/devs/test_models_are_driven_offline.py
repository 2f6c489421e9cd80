"""`heavylift.nodes.testing`: one atomic or one node, timed inputs, exact expected outputs, at most six lines."""

import re
from typing import Any

import pytest
from devs_stories import Item, Relay, coupled
from heavylift.kernel import ModelError
from heavylift.nodes import drive
from heavylift.nodes.devs import Coupled, Message, Tag, Transition, seconds
from heavylift.nodes.models import build_one
from heavylift.nodes.models.parts import Done, Order, SetProfile
from heavylift.nodes.plan import Motion
from heavylift.nodes.scene import load
from heavylift.nodes.zoo import Generator, Job, Processor


def test_the_model_of_the_west_crane_reports_after_30_s_that_it_has_travelled_10_m() -> None:
    west, gantry = build_one(load("turnover").plan, "west"), "west.gantry.drive"
    text = drive(west, [(seconds(1), "order", Order(gantry, 1, (0, 0), Motion(speed=0.5, accel=0.05, by=10.0)))])
    assert text[-2:] == [
        (Tag(seconds(1), 1), "input", SetProfile(gantry, seconds(1), 0.5, 0.05, 10.0)),
        (Tag(seconds(31)), "report", Done(gantry, 1, 50.0)),
    ]


def test_the_function_drive_returns_the_outputs_of_a_single_model_for_a_list_of_inputs() -> None:
    jobs = [(seconds(t), "into", Job(t)) for t in (1, 2, 4)]
    processor = Processor("p", seconds(2.5))
    assert drive(processor, jobs) == [
        (Tag(seconds(3.5)), "done", Job(1)),
        (Tag(seconds(6.5)), "done", Job(4)),
    ]
    assert drive(processor, jobs, until=seconds(6.5)) == [(Tag(seconds(3.5)), "done", Job(1))]


def test_inputs_at_one_logical_time_form_one_bag_and_logical_times_have_microsteps() -> None:
    inputs: list[tuple[int | Tag, str, Message]] = [(5, "into", Item(1)), (5, "into", Item(2))]
    assert drive(Relay("r", 3), inputs) == [(Tag(8), "out", Item(1)), (Tag(8), "out", Item(2))]
    assert drive(Relay("r", 0), [(Tag(5, 2), "into", Item(1))]) == [(Tag(5, 3), "out", Item(1))]


def test_the_function_drive_sends_inputs_to_the_ports_of_a_coupled_model_and_returns_its_outputs() -> None:
    first, second = Relay("first", 1), Relay("second", 2)
    model = coupled("both", [first, second], (first.out, second.into))
    model.connect(model.add_in("i", Item), first.into)
    model.connect(second.out, model.add_out("o", Item))
    assert isinstance(model, Coupled)
    assert drive(model, [(10, "i", Item(1))]) == [(Tag(13), "o", Item(1))]


def test_an_output_function_that_changes_its_model_is_refused_in_an_offline_test() -> None:
    class Impure(Generator):
        def output(self) -> None:
            self.number += 1
            super().output()

    with pytest.raises(ModelError, match=r"^g at \(0 s, 0\): output\(\) must not change the state: it changed number"):
        drive(Impure("g", seconds(1)), until=seconds(3))


def test_the_transitions_of_a_model_driven_offline_can_be_inspected() -> None:
    log: list[Transition] = []
    drive(Processor("p", 10), [(5, "into", Job(1)), (15, "into", Job(2))], log=log.append)
    assert [(line.tag.t, line.kind) for line in log] == [(5, "external"), (15, "confluent"), (25, "internal")]


@pytest.mark.parametrize(
    ("entry", "sentence"),
    [
        ((1.5, "into", Job(1)), "p: the input for into comes at 1.5; give seconds(1.5) or a Tag, from 0 on"),
        ((-1, "into", Job(1)), "p: the input for into comes at -1; give seconds(1.5) or a Tag, from 0 on"),
        ((1, "in", Job(1)), "p: there is no input port in; its input ports: into"),
        ((1, "done", Job(1)), "p: there is no input port done; its input ports: into"),
        ((1, "into", Item(1)), "p.into carries Job, not Item"),
    ],
)
def test_invalid_inputs_of_a_model_driven_offline_are_refused(entry: Any, sentence: str) -> None:
    with pytest.raises(ModelError, match=f"^{re.escape(sentence)}$"):
        drive(Processor("p", 10), [entry])
