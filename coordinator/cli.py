"""The command line: `heavylift COMMAND`; every command says what to type next, every error is one sentence.

Exit codes: 0 done; 1 the run or the file failed; 2 the command line is wrong; 128 and its number if a signal stopped it
(130 Ctrl-C); 141 nobody reads its output any more.
"""

# Until `main` holds signals back, Ctrl-C prints a traceback: nothing that takes time is imported before.
import _signal  # type: ignore[import-not-found]  # built in; `signal` takes a millisecond

LIGHT = {
    "OPENBLAS_NUM_THREADS": "1",  # threads reserve 40 MB each, and need none
    "MALLOC_ARENA_MAX": "2",  # nor the 64 MB of each of them here
    "MALLOC_MMAP_THRESHOLD_": f"{64 << 20}",  # batches keep their pages
    "MALLOC_TRIM_THRESHOLD_": f"{64 << 20}",
}


def main() -> None:
    """Entry point of the command `heavylift`."""
    _signal.pthread_sigmask(_signal.SIG_BLOCK, _signal.valid_signals())  # until somebody hears them
    import atexit
    import gc
    import os
    import signal
    import sys

    from heavylift.coordinator.supervision.hash_seed import start_again

    from .stopping import STOPPED, UNHEARD, ReaderLeft, Stopping, heard, open_streams

    open_streams()
    start_again()
    stopping = Stopping()
    gc.set_threshold(50_000)  # hardly anything that a start makes is garbage: looking for some takes a tenth of it
    atexit.register(gc.freeze)  # nor is what an end leaves: the system takes it back in no time
    os.environ.update(LIGHT | {name: value for name, value in os.environ.items() if name in LIGHT})
    with heard():
        try:
            try:
                signal.pthread_sigmask(signal.SIG_SETMASK, ())
                from heavylift.coordinator.commands.common.app import (
                    carry_out,  # takes a fifth of a second, in which Ctrl-C may come
                )

                carry_out()
            finally:
                stopping.end(process=True)
        except KeyboardInterrupt:
            stopping.end(process=True)
            print("heavylift: stopped", file=sys.stderr)
            sys.exit(stopping.code)
        except ReaderLeft:
            sys.exit(UNHEARD)
        except SystemExit as end:
            sys.exit(stopping.code if end.code == STOPPED else end.code)
