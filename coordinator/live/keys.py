"""Keys of the terminal that started a run; they send the same orders as the commands.

    space: pause and continue    s or .: to the next event, then pause    + and -: twice and half the rate    q: end

A thread waits for keys and queues orders; the coordinator handles them between two rounds. If standard input is no
terminal there are no keys, and `wait`, a sleep that a key ends, only sleeps.
"""

import os
import select
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from threading import Event as Flag, Thread
from typing import Self

import msgspec

from .announce import RunOrder
from .command_queue import CommandQueue, QueuedOrder


class Keyboard:
    """The keyboard of the terminal at standard input, as a context manager."""

    def __init__(self) -> None:
        self.there = False
        """Whether standard input is a terminal, so that keys can be read."""

    def __enter__(self) -> Self:
        if sys.stdin is not None and sys.stdin.isatty():
            import termios
            import tty

            self._before = termios.tcgetattr(sys.stdin)
            tty.setcbreak(sys.stdin)
            self.there = True
        return self

    def __exit__(self, _: object, error: BaseException | None, *__: object) -> None:
        if self.there:
            import termios

            with suppress(termios.error):  # the terminal is gone
                termios.tcsetattr(sys.stdin, termios.TCSADRAIN, self._before)
            self.there = False

    def wait(self, seconds: float | None) -> str:
        """Wait up to `seconds` for a key (None: without limit) and return the key; "" if none was pressed."""
        if not self.there:
            time.sleep(seconds or 0.0)
            return ""
        ready, _, _ = select.select([sys.stdin], [], [], seconds)
        if not ready:
            return ""
        key = os.read(sys.stdin.fileno(), 1).decode(errors="replace")
        if not key:  # the terminal is gone
            self.there = False
        return key


POLL_s = 0.2  # how often the thread looks whether the run is over
FASTER = 2.0  # factor of a press on + or -


class Keys:
    """Control of a run by keys on the terminal, as a context manager; `say` receives the replies."""

    def __init__(self, queue: CommandQueue, keyboard: Keyboard, say: Callable[[str], None]) -> None:
        self._queue, self._keyboard, self._report = queue, keyboard, say
        self._paused, self._over = False, Flag()
        self._thread = Thread(target=self._listen, name="keys", daemon=True)

    def __enter__(self) -> Self:
        if self._keyboard.there:
            self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        if self._thread.is_alive():
            self._thread.join()

    def _listen(self) -> None:
        while self._keyboard.there and not self._over.is_set():
            if order := self._order(self._keyboard.wait(POLL_s)):
                self._queue.ask(QueuedOrder(msgspec.msgpack.encode(order), lambda reply: self._report(reply.said)))

    def _order(self, key: str) -> RunOrder | None:
        match key:
            case " ":
                self._paused = not self._paused
                return RunOrder("pause" if self._paused else "continue")
            case "s" | ".":
                self._paused = True
                return RunOrder("step")
            case "+":
                return RunOrder("rate", factor=FASTER)
            case "-":
                return RunOrder("rate", factor=1 / FASTER)
            case "q":
                return RunOrder("stop")
        return None
