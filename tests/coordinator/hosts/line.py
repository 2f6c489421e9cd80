"""A line between hosts: it passes bytes on to a port, each piece a little late, until it is cut or falls silent."""

from __future__ import annotations

import random
import socket
import threading
import time

PIECE_bytes = 700  # less than a message, so that messages come in pieces
LATE_s = 0.003  # of a piece, at most


class Line:
    """Passes on what comes to `port`; `ends_after` [bytes] in all it is cut, or carries nothing more without a word."""

    def __init__(
        self, target: int, ends_after: int | None = None, silent: bool = False, late_s: float = LATE_s
    ) -> None:
        self.target, self.silent, self.late_s = target, silent, late_s
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.pieces, self.left, self.ended = 0, ends_after, threading.Event()
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        seed = 0
        while True:
            try:
                near, _ = self.listener.accept()
                far = socket.create_connection(("127.0.0.1", self.target))
            except OSError:
                return
            for ends in ((near, far), (far, near)):
                seed += 1
                threading.Thread(target=self._carry, args=(*ends, random.Random(seed)), daemon=True).start()

    def _carry(self, source: socket.socket, target: socket.socket, chance: random.Random) -> None:
        try:
            while data := source.recv(PIECE_bytes):
                time.sleep(chance.uniform(0.0, self.late_s))
                if self.left is not None:
                    self.left -= len(data)
                    if self.left < 0:
                        self.ended.set()
                        self.listener.close()
                        if not self.silent:
                            break
                        continue
                target.sendall(data)
                self.pieces += 1
        except OSError:
            pass
        for end in (source, target):
            end.close()
