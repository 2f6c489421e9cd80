"""A temporary file for what must wait in a long run: in memory while it is little, then on disk, gone with the run."""

from __future__ import annotations

import tempfile
import weakref

from heavylift.kernel.errors import RecordingError

IN_MEMORY = 1 << 20  # bytes; what is more goes into a file


class Spool:
    """Bytes that are only appended; `what` they are, for the sentence of a RecordingError if there is no room."""

    def __init__(self, what: str) -> None:
        self._file = tempfile.SpooledTemporaryFile(IN_MEMORY)  # noqa: SIM115 - closed with its last reference
        weakref.finalize(self, self._file.close)  # which Python would warn of
        self._what = what
        self._size, self._end = 0, True  # whether the file stands at its end

    def write(self, data: bytes) -> None:
        """Append."""
        try:
            if not self._end:
                self._file.seek(self._size)
                self._end = True
            self._file.write(data)
        except OSError as error:
            raise RecordingError(
                f"{tempfile.gettempdir()}: {self._what} cannot be written ({error.strerror}); make room or set TMPDIR"
            ) from None
        self._size += len(data)

    def read(self, size: int, at: int | None = None) -> bytes:
        """So many bytes from a place on, or after those that were read last; fewer at the end."""
        self._end = False
        if at is not None:
            self._file.seek(at)
        return self._file.read(size)
