"""An operator pauses, steps, commands and stops a run of processes; all is on record, and the run can be repeated.

The simulated times that orders come at differ from run to run; what is asserted holds for all of them.
"""

import signal
from itertools import islice
from pathlib import Path

import pytest
import zenoh
from heavylift.coordinator.live import AnnouncedRun, RunOrder, journal_of, observe, operator_commands, order
from heavylift.coordinator.run import run
from heavylift.coordinator.supervision import read
from heavylift.coordinator.transport import OBSERVER, OPERATOR, Hub, guest_session, key
from heavylift.kernel import ProtocolError
from heavylift.nodes.devs import decode, seconds
from heavylift.nodes.scene import parse
from heavylift.recordings import Recording
from running import PATIENCE_s, found, going, said
from sledge import SLEDGE

SERVO_m = 0.005  # by which the servo is behind when the run ends with the last move
OUT_s, REST_s = 3.0, 4.0  # the end of the first move; an instant of the rest after it


def said_s(sentence: str) -> float:
    """The last time in a sentence."""
    return float(sentence.split(" s")[0].split()[-1])


def wait_for(run_: AnnouncedRun, port: str, name: str = "") -> None:
    """Until the commander says something on this port (a stage of this name)."""
    for _, event in observe(run_):
        if event.port == port and (not name or event.value.name == name):  # type: ignore[attr-defined]
            return


@pytest.mark.large
def test_a_replay_repeats_the_orders_of_an_operator(tmp_path: Path) -> None:
    """Paused in the first three seconds, while the pusher is busy; stepped into the rest, in which it is not."""
    recorded = tmp_path / "sledge.mcap"
    (tmp_path / "sledge.yaml").write_text(SLEDGE)
    with going(tmp_path, "run", "sledge.yaml", "--rate", "2") as process:
        run_ = found(recorded)
        list(islice(observe(run_), 1))
        paused = said_s(order(run_, RunOrder("pause")))
        assert paused < OUT_s
        with pytest.raises(ProtocolError, match=r"^command: there is no 'puller' to give an order to\n.*\n.*'pusher'"):
            order(run_, RunOrder("command", text="puller: drive 6 m/min by 1 m"))
        words = "pusher: drive 6 m/min by 50 mm"
        assert order(run_, RunOrder("command", text=words)).endswith(" s, when the run continues")
        assert len(list(read(journal_of(recorded)))) == 1
        code, out, _ = said(tmp_path, "step", "sledge.mcap", "--by", f"{REST_s - paused:.9f} s")
        assert (code, out) == (0, f"paused at {REST_s:.9f} s\n")
        assert order(run_, RunOrder("command", text=words)) == f"{words}: at {REST_s:.9f} s, when the run continues"
        assert said_s(order(run_, RunOrder("step"))) == pytest.approx(REST_s, abs=1e-8)  # the command is an event
        assert said(tmp_path, "continue", "sledge.mcap")[:2] == (0, "goes on\n")
        _, errors = process.communicate(timeout=PATIENCE_s)
        assert process.returncode == 0, errors
    recording = Recording(recorded)
    commands = recording.events("operator", "command")
    first, second = recording.events("commander", "answer")
    assert (
        [event.t_ns for event in commands]
        == [seconds(paused), seconds(REST_s)]
        == [first.value["t_ns"], second.value["t_ns"]]
    )
    busy = "pusher gets an order while its drive (order 1 of action 1) is not done; wait for `moves done`"
    assert first.value["refused"].startswith(busy)
    assert second.value["refused"] == ""
    assert recording.signal("joint/position").values[-1, 0] == pytest.approx(0.05, abs=SERVO_m)
    assert not journal_of(recorded).exists()
    again = run(parse(SLEDGE, "sledge.yaml"), tmp_path / "again.mcap", True, commands=operator_commands(recorded))
    assert again.digest == recording.result["digest"]


def test_an_operator_command_is_answered_and_an_order_to_stop_completes_the_recording(tmp_path: Path) -> None:
    (tmp_path / "sledge.yaml").write_text(SLEDGE.replace("wait: 2 s", "wait: 1 h"))
    with going(tmp_path, "run", "sledge.yaml", "--rate", "20") as process:
        run_ = found(tmp_path / "sledge.mcap")
        wait_for(run_, "stage", "rest")
        given = order(run_, RunOrder("command", text="pusher: drive 6 m/min by 1 m"))
        busy = r"refused: command: pusher gets an order while its drive \(an operator's command\) is not done"
        with pytest.raises(ProtocolError, match=busy):
            order(run_, RunOrder("command", text="pusher: drive 6 m/min by 1 m"))
        code, out, _ = said(tmp_path, "stop", "sledge.mcap")
        assert (code, out.split(" at ")[0]) == (0, "ends")
        output, errors = process.communicate(timeout=PATIENCE_s)
    assert process.returncode == 0, errors
    assert "an operator stopped the run, which was still waiting for moves done (wait" in " ".join(output.split())
    recording = Recording(tmp_path / "sledge.mcap")
    assert recording.result["status"] == "finished"
    assert given == f"pusher: drive 6 m/min by 1 m: began at {operator_commands(recording.path)[0].tag.t * 1e-9:.9f} s"
    assert [event.value["text"] for event in recording.events("operator")][-1] == "stop"
    assert recording.events("commander", "finished")[0].t_ns == pytest.approx(seconds(said_s(out)), abs=2)


def test_an_operator_command_given_before_the_coordinator_is_killed_is_read_from_the_journal(tmp_path: Path) -> None:
    (tmp_path / "sledge.yaml").write_text(SLEDGE)
    with going(tmp_path, "run", "sledge.yaml", "--rate", "1") as process:
        run_ = found(tmp_path / "sledge.mcap")
        order(run_, RunOrder("pause"))
        order(run_, RunOrder("command", text="pusher: drive 6 m/min by 1 m"))
        process.send_signal(signal.SIGKILL)
        process.wait(PATIENCE_s)
    (given,) = operator_commands(tmp_path / "sledge.mcap")
    assert decode("OperatorCommand", given.payload).text == "pusher: drive 6 m/min by 1 m"  # type: ignore[attr-defined]


def test_only_the_operator_may_give_orders() -> None:
    with Hub(["west"]) as hub:
        heard: list[str] = []

        def answer(query: zenoh.Query) -> None:
            heard.append(str(query.key_expr))
            with query:
                query.reply(query.key_expr, b"yes")

        hub.serve("control", answer)
        with (
            guest_session(hub.directory.path, OPERATOR) as operator,
            guest_session(hub.directory.path, OBSERVER) as observer,
        ):
            for session, replies in ((operator, 1), (observer, 0)):
                found_ = list(session.get(key(hub.run, "control"), timeout=0.3))
                assert sum(reply.ok is not None for reply in found_) == replies
            operator.put(key(hub.run, "out", "west", "west"), b"no node")
            assert list(operator.get(key(hub.run, "leave", "west"), timeout=0.3)) == []
        assert heard == [key(hub.run, "control")]
        assert hub.receive(0.1) is None


@pytest.mark.parametrize("arguments", [["--by", "3 kg"], ["--by", "0 s"]])
def test_an_invalid_length_of_an_operator_step_is_refused(tmp_path: Path, arguments: list[str]) -> None:
    code, _, error = said(tmp_path, "step", "x.mcap", *arguments)
    assert (code, error.count("\n")) == (1, 1)
    assert error.startswith("heavylift: --by")
