"""Each command of a plan is carried by one message type, and each kernel input calls one method."""

from __future__ import annotations

from inspect import Parameter, signature
from typing import get_args

import pytest
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.devs import Message
from heavylift.nodes.models import COMMANDER, KERNEL, build, couplings
from heavylift.nodes.models.parts import messages
from heavylift.nodes.plan import ActorCommand, actions
from heavylift.nodes.scene import load


def below(kind: type) -> list[type]:
    return [each for child in kind.__subclasses__() for each in (child, *below(child))]


def test_only_messages_of_type_order_carry_the_orders_of_a_plan() -> None:
    commands = {*get_args(ActorCommand)}
    carrying = {kind for kind in below(Message) if commands & {*get_args(hint_of(kind, "what"))}}
    assert carrying == {messages.Order}
    assert {kind.__name__ for kind in below(Message)} & {kind.__name__ for kind in commands} == set()


def hint_of(kind: type, field: str) -> object:
    hint = kind.__annotations__.get(field)
    return getattr(actions, hint, None) if isinstance(hint, str) else hint


@pytest.mark.parametrize("kind", below(messages.KernelInput))
def test_each_message_type_that_the_kernel_receives_names_one_simulation_method_with_these_arguments(
    kind: type[messages.KernelInput],
) -> None:
    taken = [*signature(getattr(Simulation, kind.command)).parameters.values()][1:]
    needed = [each for each in taken if each.default is Parameter.empty]
    assert len(needed) <= len(kind.__struct_fields__) <= len(taken)
    assert "apply" not in vars(kind)


@pytest.mark.parametrize("name", ["turnover", "spreader", "dock", "in-turn"])
def test_each_kind_of_port_between_commander_and_machines_and_kernel_has_one_message_type(name: str) -> None:
    plan = load(name).plan
    models, machines = build(plan), {machine.name for machine in plan.machines}
    for source, out, target, into in couplings(plan):
        kinds = {models[node].ports[port].type for node, port in ((source, out), (target, into)) if node != KERNEL}
        if source == COMMANDER and target in machines:
            assert kinds == {messages.Order}
        elif source in machines and target == COMMANDER:
            assert kinds == {messages.Report}
        elif target == KERNEL:
            assert kinds == {messages.KernelInput}
        elif source == KERNEL and target in machines:
            assert kinds == {messages.StateEvent}
