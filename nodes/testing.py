"""Test of one atomic model or node (a coupled model) by itself: timed inputs go in, exact outputs come out.

    def test_hoist_reports_when_it_is_done() -> None:
        said = drive(Hoist("hoist"), [(seconds(1), "command", HoistCommand(id=7, duration=seconds(2)))])
        assert said == [(Tag(seconds(3)), "done", HoistDone(7))]

Inputs at the same logical time arrive in one bag. `output` is called twice at every logical time: a model whose output
differs the second time is refused.
"""

from collections.abc import Callable, Iterable

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import FOREVER, NEVER, Event, Message, Model, Simulator, Tag, Transition

__all__ = ["Said", "drive"]

Said = tuple[Tag, str, Message]  # when, by which port, what


def drive(
    model: Model,
    inputs: Iterable[tuple[int | Tag, str, Message]] = (),
    until: int = NEVER,
    log: Callable[[Transition], None] | None = None,
) -> list[Said]:
    """Simulate a model and return its outputs before `until` [ns].

    `inputs`: triples (time [ns] or logical time, input port, message)."""
    simulator = Simulator(model, log)
    simulator._present.node = True
    simulator.start()
    timed = ((_tag(model, when, port), port, value) for when, port, value in inputs)
    waiting = sorted(timed, key=lambda entry: entry[0])
    outputs: list[Said] = []
    while True:
        due = simulator.next_time
        tag = min(due, waiting[0][0]) if waiting else due
        if tag.t >= until:
            return outputs
        if tag == due:
            outputs += [(event.tag, event.port, event.value) for event in _twice(simulator)]
        while waiting and waiting[0][0] == tag:
            _, port, value = waiting.pop(0)
            simulator.inject(port, value)
        simulator.advance(tag)


def _tag(model: Model, when: int | Tag, port: str) -> Tag:
    tag = when if isinstance(when, Tag) else Tag(when)
    if type(tag.t) is not int or not (0, 0) <= tag < FOREVER:
        message = "take a time before 2**63 ns" if tag >= FOREVER else "give seconds(1.5) or a Tag, from 0 on"
        raise ModelError(f"{model.path}: the input for {port} comes at {when!r}; {message}")
    return tag


def _twice(simulator: Simulator) -> list[Event]:
    first = simulator.outputs()
    simulator._spoken = False
    if simulator.outputs() != first:
        path, tag = simulator.model.path, simulator.next_time
        raise ModelError(
            f"{path} at {tag}: output() sends other messages when called again; it must not change the model"
        )
    return first
