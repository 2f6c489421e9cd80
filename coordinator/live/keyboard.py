"""Keys of a terminal while something runs: `wait` is a sleep that a key ends.

Without a terminal there are no keys and `wait` only sleeps.  The terminal gets its settings back in any case.
"""

from __future__ import annotations

import os
import select
import sys
import time
from contextlib import suppress
from typing import Self


class Keyboard:
    """The terminal at standard input; a context manager."""

    def __init__(self) -> None:
        self.there = False
        """Whether keys can come."""

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
        """The next key within so many seconds (None: whenever it comes), "" if there was none."""
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
