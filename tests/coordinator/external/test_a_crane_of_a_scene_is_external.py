"""`heavylift run --external crane`: a program without mechanics plays a model of a scene; no byte changes."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import msgspec
import pytest
from heavylift.coordinator.participants import Participant, parts
from heavylift.coordinator.protocol import messages as m
from heavylift.coordinator.run import run
from heavylift.coordinator.transport import NodeLink, Ticket, place
from heavylift.kernel import SceneError
from heavylift.nodes.models import node_names
from heavylift.nodes.plan import encode
from heavylift.nodes.scene import load

LIFT = load("lift")


def player(path: Path) -> None:
    """Knows the plan from elsewhere, and says no more of itself than a program of another kind can."""
    link = NodeLink(msgspec.json.decode(path.read_bytes(), type=Ticket))

    def send(payload: bytes) -> None:
        text = m.decode(payload)
        if isinstance(text, m.Hello):
            text = msgspec.structs.replace(text, declaration=b"", version="wire 1", scene="")
        link.send("crane", m.encode(text))

    crane = Participant(["crane"], send, partial(link.sample, "crane"))
    while not crane.over:
        data = link.receive()[1]
        welcome = m.decode(data)
        if isinstance(welcome, m.Welcome):
            message = msgspec.msgpack.decode(welcome.config)["models"]["crane"]
            assert message["into"] == {"order": "Order", "state": "StateEvent"}
            data = m.encode(m.Welcome(1, parts.encode(parts.ScenePart(encode(LIFT.plan)))))
        crane.handle(data)
    link.close()


@pytest.mark.large
def test_running_a_crane_as_an_external_program_does_not_change_the_digest(guest, tmp_path: Path) -> None:
    placement = place(node_names(LIFT.plan), {}, external=["crane"])
    with guest(player, "crane.ticket"):
        shared = run(LIFT, tmp_path / "shared.mcap", placement=placement)
    assert shared.digest == run(LIFT, tmp_path / "alone.mcap", in_process=True).digest


def test_running_the_kernel_as_an_external_program_is_refused() -> None:
    with pytest.raises(SceneError, match="--external 'kernel': the kernel cannot be an external program"):
        place(node_names(LIFT.plan), {}, external=["kernel"])
