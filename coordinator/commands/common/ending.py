"""How a command ends: with an exit code, and with one sentence where something is wrong."""

import errno
import os
import resource
import sys
import tempfile
import traceback
from pathlib import Path

import typer
from heavylift.coordinator.stopping import STOPPED
from heavylift.kernel.errors import SPACES, HeavyliftError, OutputError, Stopped, out_of_memory, printable

from .app import app

LEAST_MB = 400  # below, libraries end the command in words of their own


def carry_out() -> None:
    """Run the command line; raises SystemExit with its exit code unless that is 0."""
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit != resource.RLIM_INFINITY and limit < LEAST_MB << 20:
        message = f"only {limit >> 20} MB of memory may be addressed, and heavylift needs at least {LEAST_MB}"
        print(f"heavylift: {message}; raise the limit (`ulimit -v unlimited`)", file=sys.stderr)
        sys.exit(1)
    for word in sys.argv[1:]:
        if len(word.splitlines()) > 1 and Path(word).exists():
            shown = printable(word)
            print(f"heavylift: '{shown}': the name of this file has more than one line; rename it", file=sys.stderr)
            sys.exit(2)
    try:
        code = app(prog_name="heavylift", standalone_mode=False)  # of a command that ends with typer.Exit
        if code == STOPPED:  # what typer makes of Ctrl-C where nobody hears it
            print("heavylift: stopped", file=sys.stderr)
        if sys.stdout is not None:  # what does not go out is noticed here, not when Python ends
            sys.stdout.flush()
        if code:
            sys.exit(code)
    except Stopped as error:
        print(f"heavylift: {error}", file=sys.stderr)
        _print_partial_verdict(error)
        sys.exit(STOPPED)
    except HeavyliftError as error:
        message = str(error)
        print(f"heavylift: {message}" if "\n" not in message else message, file=sys.stderr)
        _print_partial_verdict(error)
        sys.exit(2 if isinstance(error, OutputError) else 1)
    except (typer.Abort, KeyboardInterrupt):
        print("heavylift: stopped", file=sys.stderr)
        sys.exit(STOPPED)
    except Exception as error:
        if isinstance(error, OSError) and not error.filename and (why := _unwritable()):
            _discard_output()
            print(
                f"heavylift: standard output cannot be written ({why}); make room there or send it elsewhere",
                file=sys.stderr,
            )
            sys.exit(1)
        if hasattr(error, "format_message") and hasattr(error, "exit_code"):  # how click reports a wrong command line
            asked = type(error).__name__ == "NoArgsIsHelpError"
            message = error.format_message()
            print(message if asked else f"heavylift: {printable(message, keep=SPACES)}", file=sys.stderr)
            sys.exit(error.exit_code)
        if refused := _refused(error):
            print(f"heavylift: {refused}", file=sys.stderr)
            sys.exit(1)
        with tempfile.NamedTemporaryFile(
            "w", encoding="utf-8", prefix="heavylift-", suffix=".txt", delete=False
        ) as file:
            traceback.print_exc(file=file)
        message = f"internal error, {type(error).__name__}: {printable(str(error))}"
        print(
            f"heavylift: {message}; this is a defect of heavylift, {file.name} holds the details for its developers",
            file=sys.stderr,
        )
        sys.exit(1)


def _print_partial_verdict(error: HeavyliftError) -> None:
    """The verdict on what was recorded of a run that the error has ended."""
    if error.verdict is None:
        return
    from heavylift.coordinator.run.progress import print_verdict
    from heavylift.recordings.read.verdict import RecordedVerdict

    assert isinstance(error.verdict, RecordedVerdict)
    print_verdict(error.verdict)
    sys.stdout.flush()


def _refused(error: Exception) -> str:
    """A sentence for an error of the operating system (disk full, no permission); "" for any other error."""
    if out_of_memory(error):
        then = "then `heavylift resume` the recording, if there is one"
        return f"the system gives no more memory; end other programs or raise the limit (`ulimit -v`), {then}"
    if not isinstance(error, OSError):
        return ""
    if error.errno in (errno.EMFILE, errno.ENFILE):
        return "too many files are open for the system's limit; raise it, for instance with `ulimit -n 256`"
    if error.filename:
        return f"{error.filename}: {error.strerror}; give another name or place"
    return "" if _here() else "the working directory is gone; change to one that is there (`cd`)"


def _here() -> bool:
    try:
        return bool(os.getcwd())
    except FileNotFoundError:
        return False


def _unwritable() -> str:
    """Why standard output cannot be written to; "" if it can."""
    try:
        if sys.stdout is not None:
            os.write(sys.stdout.fileno(), b"\n")  # what has failed once is gone from Python's own buffer
    except OSError as error:
        return error.strerror or type(error).__name__
    return ""


def _discard_output() -> None:
    """Discard standard output from now on, so that Python does not fail when it flushes at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
