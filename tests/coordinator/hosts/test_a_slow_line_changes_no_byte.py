"""A line between hosts that holds back what it carries, piece by piece, for a random time: the same digest."""

import random
import socket
import threading
import time
from pathlib import Path

import pytest
from heavylift.recordings import Recording
from of_a_yard import ended, finish, free_port, start, until

PIECE_bytes = 700  # less than a message, so that messages come in pieces


class Line:
    """Passes bytes on between a port and the coordinator's, each piece up to 3 ms late."""

    def __init__(self, port: int) -> None:
        self.target = port
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.pieces = 0
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        seed = 0
        while True:
            try:
                near, _ = self.listener.accept()
            except OSError:
                return
            far = socket.create_connection(("127.0.0.1", self.target))
            for ends in ((near, far), (far, near)):
                seed += 1
                threading.Thread(target=self._carry, args=(*ends, random.Random(seed)), daemon=True).start()

    def _carry(self, source: socket.socket, target: socket.socket, chance: random.Random) -> None:
        try:
            while data := source.recv(PIECE_bytes):
                time.sleep(chance.uniform(0.0, 0.003))
                target.sendall(data)
                self.pieces += 1
        except OSError:
            pass
        for end in (source, target):
            end.close()


@pytest.mark.large
def test_a_line_that_holds_back_every_piece_changes_no_byte(tmp_path: Path, keys: Path, truth: str) -> None:
    port = free_port()
    listen = ["--listen", f"tls/127.0.0.1:{port}", "--certificates", keys]
    run = start(tmp_path, "run", "lift", "--remote", "block", *listen, "-o", "run.mcap")
    until(run, "waiting for process block")
    line = Line(port)
    code, said = finish(tmp_path, "node", "block", "--connect", f"tls/127.0.0.1:{line.port}", "--certificates", keys)
    line.listener.close()
    assert code == 0, said
    assert ended(run)[0] == 0
    assert line.pieces > 50
    assert Recording(tmp_path / "run.mcap").result["digest"] == truth
