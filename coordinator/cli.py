"""The command line: `heavylift COMMAND`; every command says what to type next, every error is one sentence.

Exit codes: 0 done; 1 the run or the file failed; 2 the command line is wrong; 130 stopped by Ctrl-C.
"""

from __future__ import annotations

import sys

from .hashing import start_again

__all__ = ["STOPPED", "main"]

STOPPED = 130


def main() -> None:
    """Entry point of the command `heavylift`."""
    try:  # the commands take a fifth of a second to import, in which Ctrl-C may come
        start_again()
        from .commands.ending import carry_out
    except KeyboardInterrupt:
        print("heavylift: stopped", file=sys.stderr)
        sys.exit(STOPPED)
    carry_out()
