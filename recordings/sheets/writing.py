"""Writing a sheet to a file: a page, a PDF, a workbook, text or plain data, by the ending of its name."""

from __future__ import annotations

from pathlib import Path

import msgspec
from heavylift.recordings.format.text import GENERATOR
from heavylift.recordings.write.outputs import output_path
from heavylift.recordings.write.partfile import written

from .browser import print_page
from .page import page_of
from .sheet import Sheet, data_of
from .terminal import text_of
from .workbook import workbook_of

FORMATS = (".html", ".pdf", ".xlsx", ".json", ".txt")
PRINTED = f"% {GENERATOR}\n".encode()  # a comment behind the end of a PDF


def write(sheet: Sheet, out: str | Path, what: str, force: bool = False) -> Path:
    """Write a sheet and return its path; `what` names it in errors, such as "a report". Raises RecordingError."""
    path = output_path(out, what, FORMATS)
    return written(printed(sheet, path), path, what, FORMATS, force)


def printed(sheet: Sheet, out: Path) -> str | bytes:
    """Return a sheet in the form given by the ending of `out`."""
    match out.suffix.lower():
        case ".pdf":
            return print_page(page_of(sheet), out) + PRINTED
        case ".xlsx":
            return workbook_of(sheet)
        case ".json":
            return msgspec.json.format(msgspec.json.encode(data_of(sheet)), indent=1) + b"\n"
        case ".txt":
            return text_of(sheet)
    return page_of(sheet)
