"""A line between hosts that holds back what it carries, piece by piece, for a random time: the same digest."""

from pathlib import Path

import pytest
from heavylift.recordings import Recording
from line import Line
from of_a_yard import ended, finish, free_port, start, until


@pytest.mark.large
def test_a_network_that_delays_every_packet_changes_no_byte_of_the_recording(
    tmp_path: Path, keys: Path, truth: str
) -> None:
    port = free_port()
    listen = ["--listen", f"tls/127.0.0.1:{port}", "--certificates", keys]
    run = start(tmp_path, "run", "lift", "--remote", "block", *listen, "-o", "run.mcap")
    until(run, "waiting for process block")
    line = Line(port)
    code, text = finish(tmp_path, "node", "block", "--connect", f"tls/127.0.0.1:{line.port}", "--certificates", keys)
    line.listener.close()
    assert code == 0, text
    assert ended(run)[0] == 0
    assert line.pieces > 50
    assert Recording(tmp_path / "run.mcap").result["digest"] == truth
