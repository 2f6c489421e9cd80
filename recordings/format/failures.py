"""What goes wrong where a file is read: errors of its bytes, and libraries that fail by themselves."""

import errno
import struct
import sys
from traceback import walk_tb
from types import ModuleType

import msgspec
import zstandard
from google.protobuf.message import DecodeError  # type: ignore[import-untyped]
from mcap.exceptions import McapError

BROKEN = (
    McapError,
    struct.error,
    zstandard.ZstdError,
    msgspec.MsgspecError,
    DecodeError,
    OSError,
    EOFError,
    ArithmeticError,
    ValueError,
    LookupError,
    AttributeError,
    TypeError,
    MemoryError,
    RecursionError,
)
"""What bytes raise that are not what a run has written."""
READERS = {"heavylift", "__main__", "mcap", "msgspec", "zstandard", "google", "numpy"} | sys.stdlib_module_names


def failing(error: BaseException) -> str:
    """The library that caused an error regardless of the file: import failure or defect; "" for errors of reading
    bytes."""
    if isinstance(error, ImportError):
        return (error.name or str(error)).partition(".")[0]
    if isinstance(error, AttributeError) and isinstance(error.obj, ModuleType):
        return error.obj.__name__.partition(".")[0]
    for frame, _ in walk_tb(error.__traceback__):
        package = str(frame.f_globals.get("__name__", "")).partition(".")[0]
        importing = frame.f_code.co_name == "<module>" and package not in ("heavylift", "__main__")
        if importing or (package not in READERS and "-packages" in frame.f_code.co_filename):  # site-, dist-
            return package
    return ""


def refused(error: BaseException) -> str:
    """A refusal of the system: disk failure, memory; "" for other errors."""
    if isinstance(error, MemoryError):
        return "there is too little memory; end other programs and try again"
    if isinstance(error, OSError) and error.errno not in (None, errno.EINVAL, errno.EOVERFLOW):
        return f"{error.strerror}; look after the disk and try again"
    return ""
